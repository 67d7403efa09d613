//! What a model misses along an angle: mean and root mean square over whole periods, with their uncertainty.

use crate::estimate::Estimate;
use crate::uncertainty::{Component, combine, correlation_factor, mean_of_repeats};

/// Fewest whole periods whose scatter tells an uncertainty.
pub const LEAST_PERIODS: usize = 4;

/// What is left of a record when a model is taken off, in the unit of the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Mean over all whole periods; type A.
    pub mean: Estimate,
    /// Root mean square over all bins; type A.
    pub rms: Estimate,
    /// Root mean square of the means of the periods: what is left when ripple inside a period is averaged away.
    pub rms_of_periods: f64,
}

/// Why there is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ResidualError {
    /// Too few whole periods.
    #[error("{found} whole periods, at least {LEAST_PERIODS} are needed")]
    TooFew {
        /// Whole periods in the record.
        found: usize,
    },
    /// A value is no number.
    #[error("value {index} is not a number")]
    NotFinite {
        /// Index of the sample.
        index: usize,
    },
}

/// Mean and root mean square of `residual`, equally spaced along an angle with `bins_per_period` bins in a period; a
/// broken period at the end is left out.
///
/// Standard uncertainties from the scatter of the means (mean squares) of the periods, widened by what neighbours
/// share (see [`correlation_factor`]); that of the root mean square is u(m²)/(2·rms), JCGM 100:2008, 5.1.2.
///
/// # Errors
/// See [`ResidualError`].
pub fn residual(residual: &[f64], bins_per_period: usize) -> Result<Residual, ResidualError> {
    if let Some(index) = residual.iter().position(|r| !r.is_finite()) {
        return Err(ResidualError::NotFinite { index });
    }
    let whole = residual.chunks_exact(bins_per_period.max(1));
    let found = whole.len();
    if found < LEAST_PERIODS {
        return Err(ResidualError::TooFew { found });
    }
    let bins = bins_per_period.max(1) as f64;
    let means: Vec<f64> = whole.clone().map(|p| p.iter().sum::<f64>() / bins).collect();
    let squares: Vec<f64> = whole.map(|p| p.iter().map(|r| r * r).sum::<f64>() / bins).collect();
    let n = found * bins_per_period.max(1);
    let (mean, spread) = averaged(&means);
    let (square, of_square) = averaged(&squares);
    let rms = square.sqrt();
    let u_rms = if rms > 0.0 { of_square.u / (2.0 * rms) } else { 0.0 };
    Ok(Residual {
        mean: Estimate { value: mean, u: spread.u, dof: spread.dof, n },
        rms: Estimate { value: rms, u: u_rms, dof: of_square.dof, n },
        rms_of_periods: (means.iter().map(|m| m * m).sum::<f64>() / found as f64).sqrt(),
    })
}

/// Mean with the uncertainty of neighbours that resemble each other.
fn averaged(values: &[f64]) -> (f64, Component) {
    let Some((mean, spread)) = mean_of_repeats(values) else { return (0.0, combine(&[])) };
    let off: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let factor = correlation_factor(&off);
    (mean, Component { u: spread.u * factor.sqrt(), dof: (spread.dof / factor).max(1.0) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 periods of 16 bins: an offset, ripple with the period, a deviation of each period of its own.
    fn record(offset: f64, ripple: f64, scatter: f64) -> Vec<f64> {
        (0..640_i32)
            .map(|k| {
                let own = if (k / 16) % 2 == 0 { scatter } else { -scatter };
                offset + own + ripple * (std::f64::consts::TAU * f64::from(k) / 16.0).sin()
            })
            .collect()
    }

    #[test]
    fn ripple_with_the_period_is_in_the_rms_and_neither_in_the_mean_nor_in_its_uncertainty() {
        let found = residual(&record(3.0, 8.0, 0.0), 16).expect("forty periods");
        assert!((found.mean.value - 3.0).abs() < 1e-12 && found.mean.u < 1e-12);
        assert!((found.rms.value - (9.0_f64 + 32.0).sqrt()).abs() < 1e-9);
        assert!((found.rms_of_periods - 3.0).abs() < 1e-9);
    }

    #[test]
    fn periods_that_differ_tell_the_uncertainty_of_both() {
        let found = residual(&record(3.0, 0.0, 0.5), 16).expect("forty periods");
        // s = 0.506 of 40 periods; their mean squares are 12.25 and 6.25 by turns.
        assert!((found.mean.u - 0.5 / 39.0_f64.sqrt()).abs() < 1e-9, "{found:?}");
        let u_rms = 3.0 / 39.0_f64.sqrt() / (2.0 * 9.25_f64.sqrt());
        assert!((found.rms.u - u_rms).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn a_slope_that_the_model_misses_widens_the_uncertainty_of_the_mean() {
        let slope: Vec<f64> = (0..640_i32).map(|k| 0.01 * (f64::from(k) - 319.5)).collect();
        let wide = residual(&slope, 16).expect("a slope");
        let narrow = residual(&record(0.0, 0.0, 1.8), 16);
        assert!(wide.mean.value.abs() < 1e-9);
        assert!(wide.mean.u > 3.0 * narrow.expect("scatter").mean.u, "{wide:?}");
    }

    #[test]
    fn too_few_periods_and_what_is_no_number_give_none() {
        assert_eq!(residual(&[1.0; 63], 16), Err(ResidualError::TooFew { found: 3 }));
        assert_eq!(residual(&[], 0), Err(ResidualError::TooFew { found: 0 }));
        let mut holed = vec![1.0; 64];
        holed[7] = f64::NAN;
        assert_eq!(residual(&holed, 16), Err(ResidualError::NotFinite { index: 7 }));
    }
}
