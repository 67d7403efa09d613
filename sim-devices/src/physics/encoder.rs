//! Single-turn absolute encoder.

mod biss;
mod coupling;
#[cfg(test)]
mod tests;

pub use self::biss::{EncoderFault, Reading, crc6, frame_word, read_word};
pub(crate) use self::coupling::Coupling;

use crate::physics::phasor::Phasor;
use crate::unit::AxisSettings;

/// Turns an angle into counts.
#[derive(Clone, Debug)]
pub struct Encoder {
    /// What the drive is told.
    counts_per_rev: i64,
    /// What it really counts in a turn.
    modulus: i64,
    counts_per_rad: f64,
    zero_rad: f64,
    error: ScaleError,
    fault: Option<EncoderFault>,
}

/// What the scale reads too much, as a function of the angle.
#[derive(Clone, Debug)]
struct ScaleError {
    /// a·sin(θ + φ) + b·sin(2θ + ψ) as coefficients of sin θ, cos θ, sin 2θ, cos 2θ.
    coefficients_rad: [f64; 4],
    once: Phasor,
    round: bool,
    interpolation_rad: f64,
    pitches_per_rad: f64,
}

impl ScaleError {
    fn new(axis: &AxisSettings) -> Self {
        let [first, second] = [axis.encoder_eccentricity_rad, axis.encoder_second_order_rad];
        let (sin, cos) = axis.encoder_eccentricity_phase_rad.sin_cos();
        let (second_sin, second_cos) = axis.encoder_second_order_phase_rad.sin_cos();
        Self {
            coefficients_rad: [first * cos, first * sin, second * second_cos, second * second_sin],
            once: Phasor::new(1.0, 0.0),
            round: first != 0.0 || second != 0.0,
            interpolation_rad: axis.encoder_interpolation_rad,
            pitches_per_rad: axis.encoder_pitches_per_rev / std::f64::consts::TAU,
        }
    }

    #[inline]
    fn at(&mut self, angle_rad: f64) -> f64 {
        let mut error_rad = 0.0;
        if self.round {
            let (sin, cos) = self.once.turn_to(angle_rad);
            let [a, b, c, d] = self.coefficients_rad;
            error_rad = a * sin + b * cos + 2.0 * c * sin * cos + d * (cos * cos - sin * sin);
        }
        if self.interpolation_rad != 0.0 {
            error_rad += self.interpolation_rad * wave(angle_rad * self.pitches_per_rad);
        }
        error_rad
    }
}

/// Two parabolas a period: a sine to within 6 %, without a library call; the real shape is no sine either.
#[inline]
fn wave(periods: f64) -> f64 {
    // Nearest whole number by a truncating conversion on one side of zero: no library call.
    const BIAS: i64 = 1 << 40;
    let phase = periods - ((periods + (BIAS as f64 + 0.5)) as i64 - BIAS) as f64;
    8.0 * phase * (1.0 - 2.0 * phase.abs())
}

impl Encoder {
    /// The encoder of an axis.
    pub fn new(axis: &AxisSettings) -> Self {
        let counts_per_rev = axis.encoder_bits_count.exp2().round();
        let modulus = (axis.encoder_modulus_ratio * counts_per_rev).round();
        Self {
            counts_per_rev: counts_per_rev as i64,
            modulus: modulus as i64,
            counts_per_rad: axis.encoder_sign_factor.signum() * modulus / std::f64::consts::TAU,
            zero_rad: axis.encoder_zero_rad,
            error: ScaleError::new(axis),
            fault: None,
        }
    }

    /// +1 or -1: whether counts grow with the angle.
    pub fn sign(&self) -> f64 {
        self.counts_per_rad.signum()
    }

    /// Counts per revolution as the drive is told, a power of two.
    pub fn counts_per_rev(&self) -> i64 {
        self.counts_per_rev
    }

    /// Unwrapped counts as the encoder sends them: it begins again after a real turn.
    pub fn wrapped(&self, counts: i64) -> i64 {
        counts.rem_euclid(self.modulus)
    }

    /// Counts without the single-turn wrap: what differences of samples are made of. The scale's own error is in
    /// them: it reads θ + a·sin(θ + φ) + b·sin(2θ + ψ) + interpolation.
    #[inline]
    pub fn unwrapped_counts(&mut self, angle_rad: f64) -> i64 {
        // The bias keeps the truncating conversion on one side of zero, so that it rounds to nearest everywhere.
        const BIAS: i64 = 1 << 40;
        let scale_rad = angle_rad + self.error.at(angle_rad);
        ((scale_rad - self.zero_rad) * self.counts_per_rad + (BIAS as f64 + 0.5)) as i64 - BIAS
    }

    /// What the encoder reports: 0 ≤ counts < counts per revolution.
    pub fn counts(&mut self, angle_rad: f64) -> i64 {
        let counts = self.unwrapped_counts(angle_rad);
        self.wrapped(counts)
    }

    /// The BiSS-C word that it sends at an angle, with the injected fault.
    pub fn word(&mut self, angle_rad: f64) -> u64 {
        frame_word(self.counts(angle_rad) as u64, self.counts_per_rev.ilog2(), self.fault)
    }

    /// Injects a fault from now on, or takes it away.
    pub fn inject(&mut self, fault: Option<EncoderFault>) {
        self.fault = fault;
    }

    /// The fault that is injected.
    pub fn fault(&self) -> Option<EncoderFault> {
        self.fault
    }

    /// Angle that one count is worth, with the sign of the encoder.
    pub fn rad_per_count(&self) -> f64 {
        1.0 / self.counts_per_rad
    }
}
