//! Rejection of a disturbance by a loop, read from a response: value at a frequency, 0 dB crossing, largest amplification.
//!
//! Lines of a spectrum scatter; each number comes from a parabola with complex coefficients through the lines around it.

use super::frf::{C64, Line};
use super::least_squares::LinearFit;
use super::uncertainty::{Component, within_and_between};

#[cfg(test)]
mod tests;

/// Lines within this part of a frequency to either side belong to it.
const BAND_RATIO: f64 = 0.15;
/// And at least so many spacings to either side.
const LEAST_SPACINGS: f64 = 2.2;
/// Fewest lines of a parabola.
const FEWEST: usize = 5;
/// Variance of a mean of lines over that of as many independent ones: estimates at neighbouring lines of a Hann window
/// correlate by (2/3)² and (1/6)².
const HANN_FACTOR: f64 = 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0);
/// A rejection that begins above this is none.
const REJECTS_DB: f64 = -3.0;

/// A response at a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rejected {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// What is left of the disturbance.
    pub value: C64,
    /// Standard uncertainty of 20·lg|value| by scatter, dB.
    pub scatter_db: Component,
    /// Lines that it rests on.
    pub lines: usize,
}

impl Rejected {
    /// 20·lg|value|, dB.
    pub fn db(&self) -> f64 {
        20.0 * self.value.norm().log10()
    }
}

/// Why a response has no such number.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RejectionError {
    /// Too few lines.
    #[error(
        "{found} lines around {frequency_hz:.2} Hz, at least 5 are needed: use longer segments, or another frequency"
    )]
    TooFew {
        /// Where, Hz.
        frequency_hz: f64,
        /// How many.
        found: usize,
    },
    /// No line has the gain 1.
    #[error("the residual does not reach 0 dB up to {last_hz:.1} Hz")]
    NoCrossing {
        /// Highest line that was looked at, Hz.
        last_hz: f64,
    },
}

/// The response at a frequency: parabola over the lines within ± 15 % of it, at least 2.2 spacings to either side.
///
/// `lines` ascend and are evenly spaced, as of a spectrum. Uncertainty: variances of the lines, correlated as by a Hann
/// window; what the lines leave of the parabola beyond that is a component of its own.
///
/// # Errors
/// Fewer than five lines around the frequency.
pub fn rejected(lines: &[Line], frequency_hz: f64) -> Result<Rejected, RejectionError> {
    let spacing_hz = lines.windows(2).map(|l| l[1].frequency_hz - l[0].frequency_hz).fold(f64::MAX, f64::min);
    let reach_hz = (BAND_RATIO * frequency_hz).max(LEAST_SPACINGS * spacing_hz);
    let near: Vec<&Line> =
        lines.iter().filter(|l| (l.frequency_hz - frequency_hz).abs() <= reach_hz).collect();
    let too_few = RejectionError::TooFew { frequency_hz, found: near.len() };
    let inside = |l: &&&Line| l.frequency_hz <= frequency_hz + 1e-9;
    if near.len() < FEWEST || near.iter().filter(inside).count() < 2 {
        return Err(too_few);
    }
    let x: Vec<f64> = near.iter().map(|l| (l.frequency_hz - frequency_hz) / reach_hz).collect();
    let columns = [vec![1.0; x.len()], x.clone(), x.iter().map(|x| x * x).collect()];
    let fit = |part: &dyn Fn(C64) -> f64| {
        let values: Vec<f64> = near.iter().map(|l| part(l.value)).collect();
        LinearFit::new(&columns, &values, None).map_err(|_| too_few)
    };
    let re = fit(&|v| v.re)?;
    let im = fit(&|v| v.im)?;
    let value = C64::new(re.coefficients[0], im.coefficients[0]);
    let leverage = HANN_FACTOR * re.unscaled_covariance[(0, 0)];
    let line_variance = near.iter().map(|l| 0.5 * l.variance).sum::<f64>() / near.len() as f64;
    let left_variance = 0.5 * (re.residual_variance + im.residual_variance);
    let db = 20.0 / std::f64::consts::LN_10 / value.norm().max(f64::MIN_POSITIVE);
    let u = |variance: f64| db * (leverage * variance).sqrt();
    let own_dof = near.iter().map(|l| 2.0 * l.dof).fold(f64::INFINITY, f64::min);
    let within = Component { u: u(line_variance), dof: own_dof };
    let between = Component { u: u(left_variance), dof: 2.0 * re.dof as f64 };
    let scatter_db = within_and_between(within, between);
    Ok(Rejected { frequency_hz, value, scatter_db, lines: near.len() })
}

/// Every line as [`rejected`] reads it, where it can.
pub fn smoothed(lines: &[Line], up_to_hz: f64) -> Vec<Rejected> {
    let inside = lines.iter().filter(|l| l.frequency_hz <= up_to_hz);
    inside.filter_map(|l| rejected(lines, l.frequency_hz).ok()).collect()
}

/// Lowest frequency at which nothing is rejected any more, with the uncertainty of its scatter in Hz. A loop that rejects
/// less than 3 dB at the lowest line crosses there at the latest.
///
/// # Errors
/// No crossing, or too few lines.
pub fn crossing(lines: &[Line], curve: &[Rejected]) -> Result<(Rejected, Component), RejectionError> {
    let too_few = RejectionError::TooFew { frequency_hz: 0.0, found: curve.len() };
    let first = curve.first().ok_or(too_few)?;
    let last = curve.last().ok_or(too_few)?;
    if first.db() > REJECTS_DB {
        return Ok((*first, Component { u: 0.0, dof: first.scatter_db.dof }));
    }
    let pair = curve.windows(2).find(|pair| pair[1].db() >= 0.0);
    let pair = pair.ok_or(RejectionError::NoCrossing { last_hz: last.frequency_hz })?;
    let slope_db_per_hz = (pair[1].db() - pair[0].db()) / (pair[1].frequency_hz - pair[0].frequency_hz);
    let at_hz = pair[0].frequency_hz - pair[0].db() / slope_db_per_hz;
    let there = rejected(lines, at_hz)?;
    let u = there.scatter_db.u / slope_db_per_hz.abs();
    Ok((there, Component { u, dof: there.scatter_db.dof }))
}

/// Where most is added instead of rejected.
pub fn peak(curve: &[Rejected]) -> Option<Rejected> {
    curve.iter().copied().max_by(|a, b| a.db().total_cmp(&b.db()))
}
