//! Designed excitation: multisines on a grid, sweeps.
//!
//! A multisine runs on while the axis slides back and forth; only windows of one length inside the plateaus are used.
//! Its lines are f = (m + φ)/T_w, m whole, φ one for all lines: differences of lines are whole multiples of 1/T_w, so
//! that each line is told from all others on **any** window of length T_w, though the record repeats only after
//! 1, 2 or 4 windows ([`Grid`]).

mod grid;
mod phases;
mod sweep;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

pub use grid::{Grid, Kind, Offset, Selection, Spacing};
pub use phases::Phases;
pub use sweep::{
    Law, Sweep, expected_peak_error, iso_linear_limit_hz_per_min, iso_logarithmic_limit_oct_per_min,
};

/// One sine of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sine {
    /// Frequency.
    pub frequency_hz: f64,
    /// Amplitude in the unit of what it is added to.
    pub amplitude: f64,
    /// Phase of the cosine.
    pub phase_rad: f64,
}

/// Highest excited frequency as a part of the sample rate: above it the hold and the anti-alias filter leave too
/// little, and products of distortion fold back.
pub const HIGHEST_RATIO: f64 = 0.4;

/// Why an excitation cannot be designed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExcitationError {
    /// A frequency above 0.4 of the sample rate.
    #[error(
        "expected at most {limit_hz} Hz (0.4 of the sample rate), found {frequency_hz} Hz: reduce it or sample faster"
    )]
    TooFast {
        /// The frequency, Hz.
        frequency_hz: f64,
        /// The limit, Hz.
        limit_hz: f64,
    },
    /// A quantity that must be positive and finite.
    #[error("{what}: expected a finite number above 0, found {found}")]
    NotPositive {
        /// Name of the quantity with its unit.
        what: &'static str,
        /// Value given.
        found: f64,
    },
    /// A window that is no whole number of samples.
    #[error(
        "expected a window of a whole number of samples, found {window_s} s = {samples} samples: change it"
    )]
    Window {
        /// Window, s.
        window_s: f64,
        /// Length of the window, samples.
        samples: f64,
    },
    /// No line of the grid left.
    #[error(
        "no line in {from_hz}…{to_hz} Hz outside the forbidden bands: widen the band or lengthen the window"
    )]
    Empty {
        /// Lower end, Hz.
        from_hz: f64,
        /// Upper end, Hz.
        to_hz: f64,
    },
    /// The band is empty or reversed.
    #[error("expected an ascending band, found {from_hz}…{to_hz} Hz")]
    Band {
        /// Lower end, Hz.
        from_hz: f64,
        /// Upper end, Hz.
        to_hz: f64,
    },
    /// The weight of a line is not positive.
    #[error("weight at {frequency_hz} Hz: expected a finite number above 0, found {found}")]
    Weight {
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Weight.
        found: f64,
    },
}

/// A sum of sines.
#[derive(Clone, Debug, PartialEq)]
pub struct Multisine {
    /// Lines in ascending frequency.
    pub lines: Vec<Sine>,
    /// Time after which the sum repeats, s: 1, 2 or 4 windows.
    pub period_s: f64,
}

impl Multisine {
    /// Lines of a grid with amplitudes `weight(f)` (f in Hz) and phases of a law.
    ///
    /// # Errors
    /// [`ExcitationError::Weight`].
    pub fn new(
        grid: &Grid,
        weight: &dyn Fn(f64) -> f64,
        phases: Phases<'_>,
    ) -> Result<Self, ExcitationError> {
        let mut lines = Vec::with_capacity(grid.orders.len());
        for frequency_hz in grid.frequencies_hz() {
            let amplitude = weight(frequency_hz);
            if !(amplitude > 0.0 && amplitude.is_finite()) {
                return Err(ExcitationError::Weight { frequency_hz, found: amplitude });
            }
            lines.push(Sine { frequency_hz, amplitude, phase_rad: 0.0 });
        }
        let mut multisine = Self { lines, period_s: grid.repeats_after_s() };
        phases::set(&mut multisine, phases);
        Ok(multisine)
    }

    /// This multisine with all amplitudes scaled to a peak-to-peak value.
    ///
    /// # Errors
    /// [`ExcitationError::NotPositive`].
    pub fn scaled_to(mut self, peak_to_peak: f64) -> Result<Self, ExcitationError> {
        positive("peak-to-peak value", peak_to_peak)?;
        let ratio = peak_to_peak / self.peak_to_peak();
        for line in &mut self.lines {
            line.amplitude *= ratio;
        }
        Ok(self)
    }

    /// Value at a time, s.
    pub fn at(&self, t_s: f64) -> f64 {
        let value = |l: &Sine| {
            l.amplitude * (std::f64::consts::TAU * (l.frequency_hz * t_s).fract() + l.phase_rad).cos()
        };
        self.lines.iter().map(value).sum()
    }

    /// Root mean square over a period: √(Σ a²/2).
    pub fn rms(&self) -> f64 {
        self.lines.iter().map(|l| 0.5 * l.amplitude * l.amplitude).sum::<f64>().sqrt()
    }

    /// Largest less smallest value over a period (to 0.5 %: 16 points or more a period of the highest line).
    pub fn peak_to_peak(&self) -> f64 {
        let (low, high) = self.range();
        high - low
    }

    /// Largest |value| over rms.
    pub fn crest_factor(&self) -> f64 {
        let (low, high) = self.range();
        high.max(-low) / self.rms()
    }

    fn range(&self) -> (f64, f64) {
        let values = phases::Synthesis::new(self, 16).period(self);
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)))
    }
}

/// Refuses what is not positive and finite.
fn positive(what: &'static str, found: f64) -> Result<(), ExcitationError> {
    if found > 0.0 && found.is_finite() { Ok(()) } else { Err(ExcitationError::NotPositive { what, found }) }
}

/// Refuses frequencies above the highest a sample rate allows.
fn slow_enough(frequency_hz: f64, sample_rate_hz: f64) -> Result<(), ExcitationError> {
    let limit_hz = HIGHEST_RATIO * sample_rate_hz;
    if frequency_hz > limit_hz {
        return Err(ExcitationError::TooFast { frequency_hz, limit_hz });
    }
    Ok(())
}
