//! Response from repeated windows with errors in both channels.

use super::error::{PeriodicError, ascending, within_range};
use super::windows::enough;
use crate::frf::{C64, Frf, Line};

/// Ĝ = Ȳ/Ū with its variance from the scatter of P windows (windows × lines, both in steady state, phases to one
/// time, e.g. from [`super::transfer`]); P − 1 complex degrees of freedom.
///
/// var Ĝ = |G|²·(σ_Y²/|Y|² + σ_U²/|U|² − 2·Re(σ_YU²/(Y·Ū*))), σ² those of the means (Pintelon & Schoukens, *System
/// Identification*, 2nd ed., §2.4; the maximum-likelihood estimate with errors in both channels), written as
/// Σ|δY − Ĝ·δU|²/(P(P−1)·|Ū|²), which is the same and cannot turn negative by rounding.
///
/// Coherence of one window: S/(S + N) with N the variance of Y − Ĝ·U in one window and S = |Ȳ|² − N/P the linear
/// power less what the noise adds to it: the |mean|²/mean|·|² of the output, free of its bias, and without the part
/// of the scatter that the input explains.
///
/// # Errors
/// [`PeriodicError::TooFew`] below two windows, [`PeriodicError::Length`], [`PeriodicError::NotFinite`],
/// [`PeriodicError::MissingReference`] where the mean input is 0, [`PeriodicError::NotAscending`],
/// [`PeriodicError::TooLarge`].
pub fn errors_in_variables(
    frequencies_hz: &[f64],
    u: &[Vec<C64>],
    y: &[Vec<C64>],
) -> Result<Frf, PeriodicError> {
    enough(u.len())?;
    rectangular("input", frequencies_hz.len(), u.len(), u)?;
    rectangular("output", frequencies_hz.len(), u.len(), y)?;
    ascending(frequencies_hz.iter().copied())?;
    frequencies_hz
        .iter()
        .enumerate()
        .map(|(l, &frequency_hz)| {
            let mean_u = mean(u, l);
            let mean_y = mean(y, l);
            excited(frequency_hz, mean_u)?;
            let value = mean_y / mean_u;
            let p = u.len() as f64;
            let rest = |w: usize| ((y[w][l] - mean_y) - value * (u[w][l] - mean_u)).norm_sqr();
            let noise = (0..u.len()).map(rest).sum::<f64>() / (p - 1.0);
            let variance = noise / (p * mean_u.norm_sqr());
            within_range("response", value.norm_sqr() + variance + mean_y.norm_sqr())?;
            let coherence = Some(coherence(mean_y.norm_sqr(), noise, p));
            Ok(Line { frequency_hz, value, variance, dof: p - 1.0, coherence })
        })
        .collect()
}

/// Signal to noise of one window from its coherence (0…1), dB: 10·lg(γ²/(1 − γ²)); −∞ for 0, ∞ for 1.
pub fn snr_db(coherence: f64) -> f64 {
    let coherence = coherence.clamp(0.0, 1.0);
    10.0 * (coherence / (1.0 - coherence)).log10()
}

fn coherence(power: f64, noise: f64, windows: f64) -> f64 {
    let signal = (power - noise / windows).max(0.0);
    if signal > 0.0 { signal / (signal + noise) } else { 0.0 }
}

/// Refuses a mean input whose square vanishes.
pub(super) fn excited(frequency_hz: f64, mean_u: C64) -> Result<(), PeriodicError> {
    if mean_u.norm_sqr() >= f64::MIN_POSITIVE {
        return Ok(());
    }
    let expected = f64::MIN_POSITIVE.sqrt();
    Err(PeriodicError::MissingReference { frequency_hz, expected, found: mean_u.norm() })
}

/// Mean over the windows at a line.
pub(super) fn mean(windows: &[Vec<C64>], line: usize) -> C64 {
    windows.iter().map(|w| w[line]).sum::<C64>() / windows.len() as f64
}

/// Refuses arrays that are not windows × lines, or not finite.
pub(super) fn rectangular(
    name: &str,
    lines: usize,
    windows: usize,
    values: &[Vec<C64>],
) -> Result<(), PeriodicError> {
    let channel = || name.to_owned();
    if values.len() != windows {
        return Err(PeriodicError::Length { channel: channel(), expected: windows, found: values.len() });
    }
    for window in values {
        if window.len() != lines {
            return Err(PeriodicError::Length { channel: channel(), expected: lines, found: window.len() });
        }
        if let Some(sample) = window.iter().position(|v| !(v.re.is_finite() && v.im.is_finite())) {
            return Err(PeriodicError::NotFinite { channel: channel(), sample });
        }
    }
    Ok(())
}
