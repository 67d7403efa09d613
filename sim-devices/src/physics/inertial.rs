//! Errors of inertial sensors, and where the sensors sit.
//!
//! Error model of IEEE Std 952 (annex C): angle random walk N, bias instability B, rate random walk K, bias, scale
//! and quantisation. The same model serves accelerometers, with velocity instead of angle.

mod drift;
mod mount;
#[cfg(test)]
mod tests;

pub use self::drift::Drift;
pub use self::mount::{Felt, Mount};

use crate::physics::noise::{Noise, SeedAddress};

/// Errors of one sensor; `u` is the unit of what it senses (rad/s or m/s²).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorErrors {
    /// Random walk N of the integral, u/√Hz (rad/√s for a gyro): Allan deviation N/√τ.
    pub random_walk_per_sqrt_hz: f64,
    /// Bias instability B, u: Allan deviation √(2 ln 2/π)·B = 0.664·B where it is flat.
    pub bias_instability: f64,
    /// Rate random walk K, u/√s: Allan deviation K·√(τ/3).
    pub rate_walk_per_sqrt_s: f64,
    /// Constant bias, u.
    pub bias: f64,
    /// Scale error: the sensor reads (1 + this) times the truth.
    pub scale_error_ratio: f64,
    /// Step of the output, u; 0 for none.
    pub quantum: f64,
    /// Size of single wrong samples of either sign, u; 0 for none.
    pub spike: f64,
    /// How often they come, Hz.
    pub spike_rate_hz: f64,
}

/// One sensor.
#[derive(Clone, Debug)]
pub struct Sensor {
    white: White,
    drift: Drift,
    bias: f64,
    factor: f64,
    quantum: f64,
    /// Whether a tick has a spike, and of which sign.
    spikes: Noise,
    spike: f64,
    spike_rate_hz: f64,
    random_walk_per_sqrt_hz: f64,
    /// Averaging time of the last sample and the deviation that follows from it.
    averaging_s: f64,
    white_deviation: f64,
}

impl Sensor {
    /// A sensor whose noise is addressed by `source`; a tick lasts `tick_s`.
    pub fn new(errors: &SensorErrors, address: &SeedAddress, source: &str, tick_s: f64) -> Self {
        Self {
            white: White::new(address, &format!("{source}.white"), unit_if(errors.random_walk_per_sqrt_hz)),
            drift: Drift::new(errors, address, &format!("{source}.drift"), tick_s),
            bias: errors.bias,
            factor: 1.0 + errors.scale_error_ratio,
            quantum: errors.quantum,
            spikes: Noise::new(address, &format!("{source}.spikes"), 1.0),
            spike: errors.spike,
            spike_rate_hz: errors.spike_rate_hz,
            random_walk_per_sqrt_hz: errors.random_walk_per_sqrt_hz,
            averaging_s: f64::INFINITY,
            white_deviation: 0.0,
        }
    }

    /// What it reads at a tick, as the mean over the last `averaging_s`, if the true mean is `truth`.
    ///
    /// White rate noise of density N averaged over Δt has the deviation N/√Δt. The value of a tick does not depend
    /// on which ticks were asked for before.
    #[inline]
    pub fn read(&mut self, tick: u64, averaging_s: f64, truth: f64) -> f64 {
        if averaging_s != self.averaging_s {
            self.averaging_s = averaging_s;
            self.white_deviation = self.random_walk_per_sqrt_hz / averaging_s.sqrt();
        }
        let noise = self.white_deviation * self.white.at(tick) + self.drift.at(tick);
        let mut value = truth * self.factor + self.bias + noise;
        if self.spike != 0.0 {
            value += self.spike_at(tick, averaging_s);
        }
        if self.quantum > 0.0 { (value / self.quantum).round() * self.quantum } else { value }
    }

    /// What a sample is off by as a whole: mostly nothing.
    fn spike_at(&mut self, tick: u64, averaging_s: f64) -> f64 {
        let share = self.spike_rate_hz * averaging_s;
        match self.spikes.uniform_at(tick) {
            drawn if drawn < 0.5 * share => -self.spike,
            drawn if drawn < share => self.spike,
            _ => 0.0,
        }
    }
}

/// White noise in which two ticks in a row share a pair of Gaussians: half the price.
#[derive(Clone, Debug)]
struct White {
    noise: Noise,
    place: Option<u64>,
    pair: [f64; 2],
}

impl White {
    fn new(address: &SeedAddress, source: &str, deviation: f64) -> Self {
        Self { noise: Noise::new(address, source, deviation), place: None, pair: [0.0; 2] }
    }

    #[inline]
    fn at(&mut self, tick: u64) -> f64 {
        let place = tick / 2;
        if self.place != Some(place) {
            self.pair = self.noise.pair_at(place);
            self.place = Some(place);
        }
        self.pair[(tick % 2) as usize]
    }
}

/// Deviation 1 where there is noise at all: what is not there costs nothing.
fn unit_if(amount: f64) -> f64 {
    if amount == 0.0 { 0.0 } else { 1.0 }
}
