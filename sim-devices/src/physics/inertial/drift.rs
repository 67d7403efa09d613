//! Slow errors: flicker as a sum of Gauss–Markov processes, and rate random walk.

use super::{SensorErrors, unit_if};
use crate::physics::noise::{Noise, SeedAddress};

/// Time constants of the Gauss–Markov processes, one per decade: flat Allan deviation from about 3 s to 300 s.
const TIME_CONSTANTS_S: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];
/// ln of the ratio between neighbours.
const LOG_SPACING: f64 = std::f64::consts::LN_10;
/// The drift advances in steps of about this, a fiftieth of the shortest time constant, and holds in between.
const STEP_S: f64 = 0.02;
/// Places of the noise that one step owns: the processes, the walk, and room.
const PLACES: u64 = 8;

/// Slow error of one sensor.
///
/// A sum over log-spaced T of processes with variance q each and two-sided PSD 2qT/(1 + (2πfT)²) comes to
/// q/(2f·ln r), r = 10 the ratio of neighbours. Flicker of IEEE 952 is B²/(2πf), so q = B²·ln r/π. The ripple of the
/// sum is ± 5.5 % of the PSD (Fourier series of the sech kernel), less in the Allan deviation.
///
/// The states advance with every step of 20 ms, each step from noise at its own address. A jump ahead runs through
/// the steps between, a jump back starts over, so the value of a tick never depends on the ticks asked for before.
#[derive(Clone, Debug)]
pub struct Drift {
    noise: Noise,
    ticks_per_step: u64,
    /// exp(−h/T).
    decays: [f64; 4],
    /// Deviation of what one step adds to a process.
    kicks: [f64; 4],
    /// Stationary deviation of a process.
    deviation: f64,
    walk_kick: f64,
    states: [f64; 4],
    walk: f64,
    step: u64,
    /// First and last tick of the step.
    ticks: [u64; 2],
    value: f64,
}

impl Drift {
    /// Drift of a sensor in its stationary state; the walk begins at 0.
    pub fn new(errors: &SensorErrors, address: &SeedAddress, source: &str, tick_s: f64) -> Self {
        let ticks_per_step = ((STEP_S / tick_s).round() as u64).max(1);
        let step_s = ticks_per_step as f64 * tick_s;
        let deviation = errors.bias_instability * (LOG_SPACING / std::f64::consts::PI).sqrt();
        let amount = errors.bias_instability + errors.rate_walk_per_sqrt_s;
        let decays = TIME_CONSTANTS_S.map(|time_s| (-step_s / time_s).exp());
        let mut drift = Self {
            noise: Noise::new(address, source, unit_if(amount)),
            ticks_per_step,
            decays,
            kicks: decays.map(|decay| deviation * (1.0 - decay * decay).sqrt()),
            deviation,
            walk_kick: errors.rate_walk_per_sqrt_s * step_s.sqrt(),
            states: [0.0; 4],
            walk: 0.0,
            step: 0,
            ticks: [0, if amount == 0.0 { u64::MAX } else { ticks_per_step - 1 }],
            value: 0.0,
        };
        drift.begin();
        drift
    }

    /// Slow error at a tick.
    #[inline]
    pub fn at(&mut self, tick: u64) -> f64 {
        let [first, last] = self.ticks;
        if tick < first || tick > last {
            self.seek(tick / self.ticks_per_step);
        }
        self.value
    }

    #[cold]
    fn seek(&mut self, step: u64) {
        if step < self.step {
            self.begin();
        }
        while self.step < step {
            self.advance();
        }
        self.value = self.states.iter().sum::<f64>() + self.walk;
        let first = step * self.ticks_per_step;
        self.ticks = [first, first + (self.ticks_per_step - 1)];
    }

    fn begin(&mut self) {
        self.step = 0;
        for (place, state) in self.states.iter_mut().enumerate() {
            *state = self.deviation * self.noise.at(place as u64);
        }
        self.walk = 0.0;
        self.value = self.states.iter().sum();
    }

    fn advance(&mut self) {
        self.step += 1;
        let place = self.step * PLACES;
        for k in 0..self.states.len() {
            let kick = self.kicks[k] * self.noise.at(place + k as u64);
            self.states[k] = self.decays[k] * self.states[k] + kick;
        }
        self.walk += self.walk_kick * self.noise.at(place + self.states.len() as u64);
    }
}
