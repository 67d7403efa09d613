//! Windows of a record, and what they hold at the lines.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::error::PeriodicError;
use super::projection::{Channel, Drift, Projection};
use crate::frf::C64;

/// Smallest amplitude of the reference at a line, in parts of its largest.
const LEAST_REFERENCE: f64 = 1e-6;

/// Windows of one length in a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Windows {
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Length T_w·f_s, samples.
    pub length: usize,
    /// First sample of each window.
    pub starts: Vec<usize>,
}

impl Windows {
    fn check(&self, channel: Channel<'_>) -> Result<(), PeriodicError> {
        let expected = self.starts.iter().max().map_or(0, |s| s.saturating_add(self.length));
        let found = channel.samples.len();
        if found < expected {
            return Err(PeriodicError::Length { channel: channel.name.to_owned(), expected, found });
        }
        Ok(())
    }

    fn cut<'a>(&self, samples: &'a [f64], start: usize) -> &'a [f64] {
        &samples[start..start + self.length]
    }
}

/// Refuses fewer than two windows.
pub(super) fn enough(windows: usize) -> Result<(), PeriodicError> {
    if windows < 2 {
        return Err(PeriodicError::TooFew { what: "windows", expected: 2, found: windows });
    }
    Ok(())
}

/// Amplitudes of several channels: channel × window × line. Phases refer to sample 0 of the record, so that windows
/// that start anywhere agree in steady state. `nuisance` columns are as long as the record.
///
/// # Errors
/// See [`PeriodicError`].
pub fn spectra(
    windows: &Windows,
    grid_hz: &[f64],
    channels: &[Channel<'_>],
    nuisance: &[&[f64]],
) -> Result<Vec<Vec<Vec<C64>>>, PeriodicError> {
    spectra_with(windows, grid_hz, channels, nuisance, Drift::Slope)
}

/// Responses of windows with a choice of what drift is taken for.
///
/// # Errors
/// See [`PeriodicError`].
pub fn spectra_with(
    windows: &Windows,
    grid_hz: &[f64],
    channels: &[Channel<'_>],
    nuisance: &[&[f64]],
    drift: Drift,
) -> Result<Vec<Vec<Vec<C64>>>, PeriodicError> {
    for &channel in channels {
        windows.check(channel)?;
    }
    for (k, samples) in nuisance.iter().enumerate() {
        windows.check(Channel { name: &format!("nuisance column {k}"), samples })?;
    }
    let projection = Projection::new(windows.sample_rate_hz, windows.length, grid_hz)?;
    let of_window = |&start: &usize| -> Result<Vec<Vec<C64>>, PeriodicError> {
        let columns: Vec<&[f64]> = nuisance.iter().map(|c| windows.cut(c, start)).collect();
        let prepared = projection.prepare_with(drift, &columns)?;
        let begin_s = start as f64 / windows.sample_rate_hz;
        channels
            .iter()
            .map(|c| {
                let cut = Channel { name: c.name, samples: windows.cut(c.samples, start) };
                let mut lines = prepared.amplitudes(cut, start)?;
                for (value, f) in lines.iter_mut().zip(grid_hz) {
                    *value *= C64::from_polar(1.0, -TAU * (f * begin_s).fract());
                }
                Ok(lines)
            })
            .collect()
    };
    let each: Result<Vec<_>, _> = windows.starts.par_iter().map(of_window).collect();
    let each = each?;
    Ok((0..channels.len()).map(|c| each.iter().map(|w| w[c].clone()).collect()).collect())
}

/// Z = X/R at every line against the logged reference: channel × window × line. `grid_hz` are the excited lines,
/// **all** of them: a line that is left out is noise to the offset, slope and nuisance.
/// Slow motion below the first line needs columns of its own among the `nuisance`: see
/// [`amplitudes`](super::amplitudes).
///
/// # Errors
/// [`PeriodicError::MissingReference`] at a line that the reference does not hold (less than 10⁻⁶ of its largest),
/// [`PeriodicError::TooFew`] windows; see [`PeriodicError`].
pub fn transfer(
    windows: &Windows,
    grid_hz: &[f64],
    reference: &[f64],
    channels: &[Channel<'_>],
    nuisance: &[&[f64]],
) -> Result<Vec<Vec<Vec<C64>>>, PeriodicError> {
    enough(windows.starts.len())?;
    let named = Channel { name: "reference", samples: reference };
    let all: Vec<Channel<'_>> = std::iter::once(named).chain(channels.iter().copied()).collect();
    let mut each = spectra(windows, grid_hz, &all, nuisance)?;
    let reference = each.remove(0);
    for lines in &reference {
        let expected = LEAST_REFERENCE * lines.iter().map(|r| r.norm()).fold(0.0, f64::max);
        if let Some((&frequency_hz, r)) = grid_hz.iter().zip(lines).find(|(_, r)| r.norm() <= expected) {
            return Err(PeriodicError::MissingReference { frequency_hz, expected, found: r.norm() });
        }
    }
    for channel in &mut each {
        for (lines, reference) in channel.iter_mut().zip(&reference) {
            lines.iter_mut().zip(reference).for_each(|(x, r)| *x /= r);
        }
    }
    Ok(each)
}
