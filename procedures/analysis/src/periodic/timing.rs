//! Hold and delays: which plant a response is of; and integrals and derivatives of it.

use std::f64::consts::{PI, TAU};

use super::error::PeriodicError;
use crate::frf::{C64, Frf, Line};

/// What stands between the logged command and the logged answer beside the plant.
///
/// A response measured from logged command to logged answer is that of the *sampled* plant: hold and delays are in
/// it. [`Timing::removed`] gives the *continuous* plant, [`Timing::applied`] the sampled one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Time a command is held, s (one sample; 0: no hold).
    pub hold_s: f64,
    /// From the logged command to the start of its hold at the plant, s.
    pub command_delay_s: f64,
    /// From the plant's motion to the time stamp of its log, s.
    pub sensor_delay_s: f64,
}

impl Timing {
    /// Response of hold and delays: e^(−jω(τ_c + τ_s))·e^(−jωT/2)·sin(ωT/2)/(ωT/2).
    pub fn response(&self, frequency_hz: f64) -> C64 {
        let delay_s = self.command_delay_s + self.sensor_delay_s + 0.5 * self.hold_s;
        let half = PI * frequency_hz * self.hold_s;
        let sinc = if half.abs() < 1e-9 { 1.0 } else { half.sin() / half };
        C64::from_polar(1.0, -TAU * frequency_hz * delay_s) * sinc
    }

    /// The sampled plant of a continuous one.
    pub fn applied(&self, continuous: &[Line]) -> Frf {
        continuous.iter().map(|l| scaled(l, self.response(l.frequency_hz))).collect()
    }

    /// The continuous plant of a sampled one (frequencies well below half the sample rate: what folds back is not
    /// undone).
    ///
    /// # Errors
    /// [`PeriodicError::HoldZero`] at whole multiples of 1/T, [`PeriodicError::Timing`] for a hold or delay that is not
    /// finite.
    pub fn removed(&self, sampled: &[Line]) -> Result<Frf, PeriodicError> {
        let found = self.hold_s + self.command_delay_s + self.sensor_delay_s;
        if !found.is_finite() {
            return Err(PeriodicError::Timing { found });
        }
        let turned = |l: &Line| {
            let response = self.response(l.frequency_hz);
            if response.norm() < 1e-9 {
                let frequency_hz = l.frequency_hz;
                let hold_s = self.hold_s;
                return Err(PeriodicError::HoldZero { frequency_hz, hold_s });
            }
            Ok(scaled(l, response.inv()))
        };
        sampled.iter().map(turned).collect()
    }
}

/// A response times (jω)^n: its n-th derivative, or integral for negative n.
///
/// # Errors
/// [`PeriodicError::NotPositive`] for a line at 0 Hz or below with n < 0, or at no finite frequency.
pub fn times_jw(lines: &[Line], n: i32) -> Result<Frf, PeriodicError> {
    let turned = |l: &Line| {
        if !l.frequency_hz.is_finite() || (n < 0 && l.frequency_hz <= 0.0) {
            return Err(PeriodicError::NotPositive {
                what: "frequency to integrate at, Hz",
                found: l.frequency_hz,
            });
        }
        Ok(scaled(l, C64::new(0.0, TAU * l.frequency_hz).powi(n)))
    };
    lines.iter().map(turned).collect()
}

fn scaled(line: &Line, factor: C64) -> Line {
    Line { value: line.value * factor, variance: line.variance * factor.norm_sqr(), ..*line }
}
