//! Swept sines.

use std::f64::consts::TAU;

use super::{ExcitationError, positive, slow_enough};

/// Peak error of a response read off the envelope of a sweep, by η: simulated linear sweeps of a mode, Q = 100
/// (estimators.md §1.1, figures [M]; checked by the tests of `periodic`).
const PEAK_ERROR: [[f64; 2]; 6] =
    [[0.0, 0.0], [0.05, -0.003], [0.1, -0.006], [0.25, -0.021], [0.5, -0.05], [1.0, -0.10]];

/// How the frequency runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// Equal steps of frequency in equal times.
    Linear,
    /// Equal ratios of frequency in equal times.
    Logarithmic,
}

/// A sine whose frequency runs from one value to another, up or down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Frequency at t = 0, Hz.
    pub from_hz: f64,
    /// Frequency at the end, Hz.
    pub to_hz: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// How the frequency runs.
    pub law: Law,
    /// Amplitude, in the unit of the signal.
    pub amplitude: f64,
}

impl Sweep {
    /// Checks the numbers against each other and the sample rate.
    ///
    /// # Errors
    /// [`ExcitationError::NotPositive`], [`ExcitationError::Band`] if both frequencies are the same,
    /// [`ExcitationError::TooFast`].
    pub fn check(&self, sample_rate_hz: f64) -> Result<(), ExcitationError> {
        positive("sample rate, Hz", sample_rate_hz)?;
        positive("first frequency of the sweep, Hz", self.from_hz)?;
        positive("last frequency of the sweep, Hz", self.to_hz)?;
        positive("duration of the sweep, s", self.duration_s)?;
        positive("amplitude of the sweep", self.amplitude)?;
        if self.from_hz.to_bits() == self.to_hz.to_bits() {
            return Err(ExcitationError::Band { from_hz: self.from_hz, to_hz: self.to_hz });
        }
        slow_enough(self.from_hz.max(self.to_hz), sample_rate_hz)
    }

    /// Phase ψ at a time within the sweep, rad: 2π·∫ f dt, 0 at t = 0.
    pub fn phase_rad(&self, t_s: f64) -> f64 {
        let part = t_s / self.duration_s;
        let turns = match self.law {
            Law::Linear => self.from_hz * t_s + 0.5 * (self.to_hz - self.from_hz) * part * t_s,
            Law::Logarithmic => {
                let log_ratio = (self.to_hz / self.from_hz).ln();
                self.from_hz * self.duration_s / log_ratio * (log_ratio * part).exp_m1()
            }
        };
        TAU * turns
    }

    /// Value at a time, s: amplitude·sin ψ, 0 before the start and after the end (the ring-down).
    pub fn at(&self, t_s: f64) -> f64 {
        let running = (0.0..=self.duration_s).contains(&t_s);
        if running { self.amplitude * self.phase_rad(t_s).sin() } else { 0.0 }
    }

    /// |df/dt| as the sweep passes a frequency, Hz/s.
    pub fn rate_hz_per_s(&self, frequency_hz: f64) -> f64 {
        let rate = match self.law {
            Law::Linear => (self.to_hz - self.from_hz) / self.duration_s,
            Law::Logarithmic => frequency_hz * (self.to_hz / self.from_hz).ln() / self.duration_s,
        };
        rate.abs()
    }

    /// Dimensionless speed η = 2π·(df/dt)/(ζ·ω_n)² past a mode of damping ratio ζ: the square of the mode's time
    /// constant against the sweep. The limit of ISO 7626-2 is η = 1.8/π = 0.57.
    pub fn eta(&self, zeta: f64, natural_hz: f64) -> f64 {
        TAU * self.rate_hz_per_s(natural_hz) / (zeta * TAU * natural_hz).powi(2)
    }

    /// Whether the sweep passes a mode no faster than ISO 7626-2 allows.
    pub fn within_iso_limit(&self, zeta: f64, natural_hz: f64) -> bool {
        let rate = self.rate_hz_per_s(natural_hz);
        match self.law {
            Law::Linear => 60.0 * rate <= iso_linear_limit_hz_per_min(zeta, natural_hz),
            Law::Logarithmic => {
                60.0 * rate / natural_hz / 2_f64.ln() <= iso_logarithmic_limit_oct_per_min(zeta, natural_hz)
            }
        }
    }
}

/// Fastest linear sweep past a mode by ISO 7626-2, Hz/min: 54·f²/Q², Q = 1/(2ζ).
pub fn iso_linear_limit_hz_per_min(zeta: f64, natural_hz: f64) -> f64 {
    54.0 * (natural_hz * 2.0 * zeta).powi(2)
}

/// Fastest logarithmic sweep past a mode by ISO 7626-2, octaves/min: 78·f/Q², Q = 1/(2ζ).
pub fn iso_logarithmic_limit_oct_per_min(zeta: f64, natural_hz: f64) -> f64 {
    78.0 * natural_hz * (2.0 * zeta).powi(2)
}

/// Relative error of the peak to expect from the envelope of a sweep of speed η: −0.3 % at 0.05, −0.6 % at 0.1,
/// −2.1 % at 0.25, −5 % at 0.5, −10 % at 1, straight lines between; `None` beyond 1 (worse than −10 %) and below 0.
pub fn expected_peak_error(eta: f64) -> Option<f64> {
    PEAK_ERROR.windows(2).find(|w| (w[0][0]..=w[1][0]).contains(&eta)).map(|w| {
        let part = (eta - w[0][0]) / (w[1][0] - w[0][0]);
        w[0][1] + part * (w[1][1] - w[0][1])
    })
}
