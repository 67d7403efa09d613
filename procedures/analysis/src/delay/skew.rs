//! Two clocks that stamp the same events.

use super::DelayError;
use super::input::{InputError, check_values};
use crate::least_squares::LinearFit;

/// second = offset + (1 + skew)·first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockFit {
    /// What the second clock shows where the first shows `epoch_s`, less that, s.
    pub offset_s: f64,
    /// Standard uncertainty of `offset_s`, s.
    pub offset_u_s: f64,
    /// Rate of the second clock over that of the first, less 1.
    pub skew_ratio: f64,
    /// Standard uncertainty of `skew_ratio`.
    pub skew_u_ratio: f64,
    /// Mean of the first clock's stamps, where offset and skew are uncorrelated, s.
    pub epoch_s: f64,
    /// Standard deviation of a pair of stamps from the line, s.
    pub jitter_s: f64,
}

impl ClockFit {}

/// Fits a straight line to the stamps that two clocks gave the same events. A constant transport between the stamps is
/// part of the offset: no fit can tell the two.
///
/// # Errors
/// Fewer than five events, stamps that do not ascend.
pub fn clock_fit(first_s: &[f64], second_s: &[f64]) -> Result<ClockFit, DelayError> {
    if first_s.len() < 5 {
        return Err(InputError::TooFew { found: first_s.len(), least: 5 }.into());
    }
    check_values(first_s, first_s.len())?;
    check_values(second_s, first_s.len())?;
    for stamps in [first_s, second_s] {
        if let Some(k) = stamps.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(InputError::NotAscending { index: k + 1 }.into());
        }
    }
    let epoch_s = first_s.iter().sum::<f64>() / first_s.len() as f64;
    let since: Vec<f64> = first_s.iter().map(|t| t - epoch_s).collect();
    let apart: Vec<f64> = first_s.iter().zip(second_s).map(|(a, b)| b - a).collect();
    let columns = [vec![1.0; since.len()], since];
    let fit = LinearFit::new(&columns, &apart, None).map_err(|_| DelayError::NoFit)?;
    Ok(ClockFit {
        offset_s: fit.coefficients[0],
        offset_u_s: fit.u(0),
        skew_ratio: fit.coefficients[1],
        skew_u_ratio: fit.u(1),
        epoch_s,
        jitter_s: fit.residual_variance.sqrt(),
    })
}
