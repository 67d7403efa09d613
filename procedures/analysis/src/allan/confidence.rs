//! Deviations with their intervals.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{AllanError, Deviation, Noise, Series, Statistic, deviations, freedom, identify};

/// A deviation with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    /// The deviation.
    pub at: Deviation,
    /// Noise found at this averaging time.
    pub noise: Noise,
    /// Equivalent degrees of freedom, ν = dof; `None` where none is known for this noise.
    pub dof: Option<f64>,
    /// Lower and upper end of the 95 % interval of the deviation, σ·√(ν/χ²); `None` without degrees of freedom.
    pub interval: Option<[f64; 2]>,
}

/// Deviations with intervals by χ², for the noise found at each averaging time.
///
/// Total and Thêo1 variances stay uncorrected ([`Statistic::bias_ratio`]).
///
/// # Errors
/// As [`deviations`].
pub fn bounded(series: &Series, statistic: Statistic, factors: &[usize]) -> Result<Vec<Bounded>, AllanError> {
    let noises = identify(series, factors)?;
    let one = |(at, noise): (Deviation, Noise)| {
        let dof = freedom(statistic, noise, at.factor, series.rates());
        let interval = dof.and_then(|dof| interval(at.deviation, dof));
        Bounded { at, noise, dof, interval }
    };
    Ok(deviations(series, statistic, factors)?.into_iter().zip(noises).map(one).collect())
}

/// 95 % interval of a deviation whose square has `dof` degrees of freedom.
pub(super) fn interval(deviation: f64, dof: f64) -> Option<[f64; 2]> {
    let chi2 = ChiSquared::new(dof).ok()?;
    let end = |p: f64| deviation * (dof / chi2.inverse_cdf(p)).sqrt();
    let ends = [end(0.975), end(0.025)];
    ends.iter().all(|e| e.is_finite()).then_some(ends)
}
