//! Stepped sines.

use std::f64::consts::TAU;

use super::{ExcitationError, positive, slow_enough};

/// One frequency of a stepped sine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Time to let the transient die, s: whole periods.
    pub settle_s: f64,
    /// Time to measure, s: whole periods.
    pub measure_s: f64,
}

/// Plans a stepped sine: at each frequency the transient of the slowest mode (ζ, natural frequency) decays to
/// `left_ratio` of its start, t ≥ ln(1/ε)/(ζ·ω_n), then at least `least_s` and one period are measured; both times
/// are rounded up to whole periods.
///
/// # Errors
/// [`ExcitationError::NotPositive`], [`ExcitationError::TooFast`].
pub fn stepped_sine(
    frequencies_hz: &[f64],
    [zeta, natural_hz]: [f64; 2],
    left_ratio: f64,
    least_s: f64,
    sample_rate_hz: f64,
) -> Result<Vec<Step>, ExcitationError> {
    positive("damping ratio", zeta)?;
    positive("natural frequency, Hz", natural_hz)?;
    positive("part of the transient that may be left", left_ratio)?;
    positive("part of the transient that may go", 1.0 - left_ratio)?;
    positive("time to measure, s", least_s)?;
    let decay_s = (1.0 / left_ratio).ln() / (zeta * TAU * natural_hz);
    frequencies_hz
        .iter()
        .map(|&frequency_hz| {
            positive("frequency of a step, Hz", frequency_hz)?;
            slow_enough(frequency_hz, sample_rate_hz)?;
            let whole = |t_s: f64| (t_s * frequency_hz - 1e-9).ceil().max(1.0) / frequency_hz;
            Ok(Step { frequency_hz, settle_s: whole(decay_s), measure_s: whole(least_s) })
        })
        .collect()
}
