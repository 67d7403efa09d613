//! Sines of known frequencies in samples at any times: the three-parameter fit of IEEE Std 1057 (sine, cosine, offset),
//! for several sines at once and with a drift.

use std::f64::consts::TAU;

use super::frf::C64;
use super::least_squares::{FitError, LinearFit};

#[cfg(test)]
mod tests;

/// Samples at times that need not be evenly spaced, as long as the values.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// Times, s.
    pub time_s: &'a [f64],
    /// Values in any unit.
    pub values: &'a [f64],
}

/// Sines found in samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Tones {
    /// X of each sine, x = Re(X·e^(jω(t − origin))), in the unit of the values.
    pub amplitudes: Vec<C64>,
    /// Root mean square of what sines, offset and drift leave, in the unit of the values.
    pub left: f64,
}

/// Fits all sines together with an offset and a drift by least squares; phases count from `origin_s`.
///
/// # Errors
/// Too few samples, unequal lengths, values that are not finite, sines that the samples cannot tell apart: [`FitError`].
pub fn tones(samples: Samples<'_>, frequencies_hz: &[f64], origin_s: f64) -> Result<Tones, FitError> {
    let Samples { time_s, values } = samples;
    if time_s.len() != values.len() {
        return Err(FitError::Length { expected: time_s.len(), found: values.len() });
    }
    let middle_s = 0.5 * (time_s.first().unwrap_or(&0.0) + time_s.last().unwrap_or(&0.0));
    let mut columns = vec![vec![1.0; time_s.len()], time_s.iter().map(|t| t - middle_s).collect()];
    for frequency_hz in frequencies_hz {
        let turn = |t: &f64| TAU * frequency_hz * (t - origin_s);
        columns.push(time_s.iter().map(|t| turn(t).cos()).collect());
        columns.push(time_s.iter().map(|t| turn(t).sin()).collect());
    }
    let fit = LinearFit::new(&columns, values, None)?;
    let b = &fit.coefficients;
    Ok(Tones {
        amplitudes: (0..frequencies_hz.len()).map(|k| C64::new(b[2 + 2 * k], -b[3 + 2 * k])).collect(),
        left: fit.residual_variance.sqrt(),
    })
}
