//! Means of independent differences, as of a candidate and a baseline on the same units: interval, p, pairs needed to decide.
//!
//! Student's t with n − 1 degrees of freedom: exact for normal differences, and the interval of a mean is little disturbed by
//! others. Differences must be independent: several runs of one unit are one difference, their mean.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::estimate::Estimate;
use crate::uncertainty::mean_of_repeats;

mod plan;
#[cfg(test)]
mod tests;

pub use plan::{Plan, PlannedCall, scatter_at_most};

/// From as many degrees of freedom on t and normal agree to 1e-6, and the incomplete beta function loses digits.
const NORMAL_FROM: f64 = 1e6;
/// Most pairs that are thought of.
const MOST_PAIRS: u64 = 1_000_000_000;

/// Why differences have no mean with an uncertainty, or values no difference.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PairedError {
    /// The scatter of fewer than two is not known.
    #[error("{found} differences, at least 2 are needed")]
    TooFew {
        /// Differences.
        found: usize,
    },
    /// A difference that is no number.
    #[error("difference {index} is {value}, expected a finite number")]
    NoNumber {
        /// Its place, from 0.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A value that has no logarithm.
    #[error(
        "a log-ratio needs two finite values above zero, found {baseline:e} (baseline) and {candidate:e} (candidate)"
    )]
    NotPositive {
        /// Value of the baseline.
        baseline: f64,
        /// Value of the candidate.
        candidate: f64,
    },
}

/// Natural logarithm of candidate over baseline; both in the same unit.
///
/// # Errors
/// A value that is not finite or not above zero.
pub fn log_ratio(baseline: f64, candidate: f64) -> Result<f64, PairedError> {
    let has_logarithm = |value: f64| value.is_finite() && value > 0.0;
    if !has_logarithm(baseline) || !has_logarithm(candidate) {
        return Err(PairedError::NotPositive { baseline, candidate });
    }
    // The quotient of two tiny or huge numbers may leave the range of a double.
    Ok(if baseline == candidate { 0.0 } else { candidate.ln() - baseline.ln() })
}

/// Mean of independent differences, its standard uncertainty from their scatter, n − 1 degrees of freedom; in their unit.
///
/// # Errors
/// Fewer than two differences, or one that is not finite.
pub fn mean(differences: &[f64]) -> Result<Estimate, PairedError> {
    if let Some((index, value)) = differences.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        return Err(PairedError::NoNumber { index, value: *value });
    }
    let found = differences.len();
    let (value, spread) = mean_of_repeats(differences).ok_or(PairedError::TooFew { found })?;
    Ok(Estimate { value, u: spread.u, dof: spread.dof, n: found })
}

/// Standard deviation of a single difference, in the unit of the mean.
pub fn scatter(mean: &Estimate) -> f64 {
    mean.u * (mean.n as f64).sqrt()
}

/// Two-sided interval of the mean at a level such as 0.90, [low, high]. At level 1 it is without end.
pub fn interval(mean: &Estimate, level: f64) -> [f64; 2] {
    let half = half_width(mean.u, mean.dof, level);
    [mean.value - half, mean.value + half]
}

/// One-sided p of the hypothesis that the true mean is not above `bound`. Without scatter it is 0 or 1.
pub fn p_not_above(mean: &Estimate, bound: f64) -> f64 {
    let excess = mean.value - bound;
    if mean.u > 0.0 { upper_tail(excess / mean.u, mean.dof) } else { f64::from(u8::from(excess <= 0.0)) }
}

/// How many pairs in all would make the interval narrow enough to decide, if their mean and scatter stayed as they are: inside
/// of ±`margin`, or clear of zero. `None`: a thousand million are not enough.
///
/// It is a plan for the next comparison and no promise: the mean of more pairs is another one.
pub fn pairs_to_decide(mean: &Estimate, margin: f64, level: f64) -> Option<u64> {
    let scatter = scatter(mean);
    let shift = mean.value.abs();
    smallest_count(|pairs| {
        let half = half_width(scatter / (pairs as f64).sqrt(), (pairs - 1) as f64, level);
        shift + half <= margin || half < shift
    })
}

/// The smallest number of pairs, from 2 on, with a property that all larger numbers have too.
fn smallest_count(is_enough: impl Fn(u64) -> bool) -> Option<u64> {
    let mut enough = 2;
    while !is_enough(enough) {
        enough *= 2;
        if enough > MOST_PAIRS {
            return None;
        }
    }
    let mut too_few = enough / 2;
    while too_few + 1 < enough {
        let middle = too_few + (enough - too_few) / 2;
        if is_enough(middle) {
            enough = middle;
        } else {
            too_few = middle;
        }
    }
    Some(enough)
}

/// Half of the interval of a mean with this standard uncertainty.
fn half_width(u: f64, dof: f64, level: f64) -> f64 {
    if u > 0.0 { t_quantile(level, dof) * u } else { 0.0 }
}

/// Quantile t that |T| exceeds with probability 1 − level.
fn t_quantile(level: f64, dof: f64) -> f64 {
    let tail = 0.5 * (1.0 - level.clamp(0.0, 1.0));
    if tail <= 0.0 {
        return f64::INFINITY;
    }
    let normal = || -Normal::standard().inverse_cdf(tail);
    match StudentsT::new(0.0, 1.0, dof) {
        Ok(student) if dof < NORMAL_FROM => -student.inverse_cdf(tail),
        _ => normal(),
    }
}

/// P(T > t).
fn upper_tail(t: f64, dof: f64) -> f64 {
    match StudentsT::new(0.0, 1.0, dof) {
        Ok(student) if dof < NORMAL_FROM => student.sf(t),
        _ => Normal::standard().sf(t),
    }
}
