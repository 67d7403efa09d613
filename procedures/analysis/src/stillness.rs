//! A quantity that should not change: its mean, its noise about a straight line, its drift.

use crate::estimate::Estimate;
use crate::least_squares::LinearFit;
use crate::residual::residual;
use crate::uncertainty::correlation_factor;

/// Batches that a record is cut into; their scatter tells the uncertainties.
const BATCHES: usize = 32;
/// Fewest samples: two a batch.
pub const LEAST_SAMPLES: usize = 2 * BATCHES;

/// A record at rest, in the unit of the record; all uncertainties are type A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stillness {
    /// Mean.
    pub mean: Estimate,
    /// Standard deviation of a sample about the straight line.
    pub noise: Estimate,
    /// Slope of the straight line, unit of the record per second.
    pub drift_per_s: Estimate,
}

/// Why there is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StillnessError {
    /// Too few samples.
    #[error("{found} samples at rest, at least {LEAST_SAMPLES} are needed")]
    TooFew {
        /// Samples given.
        found: usize,
    },
    /// Times and values differ in number.
    #[error("expected {expected} values, one for each time, found {found}")]
    Length {
        /// Times.
        expected: usize,
        /// Values.
        found: usize,
    },
    /// A value or time is no number.
    #[error("sample {index} is not a number")]
    NotFinite {
        /// Index of the sample.
        index: usize,
    },
    /// Time stands still.
    #[error("time does not advance")]
    NoTime,
}

/// Mean, noise and drift of `values` at the times `time_s`.
///
/// Means of 32 equal batches are fitted by a straight line (least squares). The uncertainty of the slope comes from the
/// scatter of the batches about the line, that of the mean and of the noise from the scatter of the batches' means and
/// mean squares, each widened by what neighbouring batches share, so that noise of any colour down to the length of a
/// batch counts as what it is. A drift is no noise: it is in the slope. Up to 31 samples at the end are left out.
///
/// # Errors
/// See [`StillnessError`].
pub fn stillness(time_s: &[f64], values: &[f64]) -> Result<Stillness, StillnessError> {
    let found = values.len();
    if time_s.len() != found {
        return Err(StillnessError::Length { expected: time_s.len(), found });
    }
    if found < LEAST_SAMPLES {
        return Err(StillnessError::TooFew { found });
    }
    if let Some(index) = (0..found).find(|&k| !(time_s[k].is_finite() && values[k].is_finite())) {
        return Err(StillnessError::NotFinite { index });
    }
    let each = found / BATCHES;
    let n = each * BATCHES;
    let means = |all: &[f64]| -> Vec<f64> {
        all[..n].chunks_exact(each).map(|batch| batch.iter().sum::<f64>() / each as f64).collect()
    };
    let mean = means(values).iter().sum::<f64>() / BATCHES as f64;
    let times = means(time_s);
    let tops = means(values).iter().map(|v| v - mean).collect::<Vec<f64>>();
    let middle_s = times.iter().sum::<f64>() / BATCHES as f64;
    let column: Vec<f64> = times.iter().map(|t| t - middle_s).collect();
    let fit =
        LinearFit::new(&[vec![1.0; BATCHES], column], &tops, None).map_err(|_| StillnessError::NoTime)?;
    let level = fit.coefficients[0];
    let slope = fit.coefficients[1];
    let line = |t: f64| mean + level + slope * (t - middle_s);
    let about: Vec<f64> = (0..n).map(|k| values[k] - line(time_s[k])).collect();
    let left = residual(&about, each).map_err(|_| StillnessError::TooFew { found })?;
    let factor = correlation_factor(&fit.residuals);
    let u_slope = (fit.residual_variance * fit.unscaled_covariance[(1, 1)] * factor).sqrt();
    let dof = (fit.dof as f64 / factor).max(1.0);
    Ok(Stillness {
        mean: Estimate { value: mean, ..left.mean },
        noise: left.rms,
        drift_per_s: Estimate { value: slope, u: u_slope, dof, n },
    })
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{RngCore, SeedableRng};

    use super::*;

    /// A seeded record of 4000 samples at 1 kHz: level, drift and white noise.
    fn record(seed: u64, drift: f64) -> (Vec<f64>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut uniform = || (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
        let time: Vec<f64> = (0..4000).map(|k| 50.0 + f64::from(k) / 1000.0).collect();
        let values = time
            .iter()
            .map(|t| {
                let normal = (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
                7.0 + drift * (t - 52.0) + 0.3 * normal
            })
            .collect();
        (time, values)
    }

    #[test]
    fn level_noise_and_drift_come_back_within_their_uncertainties() {
        let mut outside = [0; 3];
        let mut ratios = [const { Vec::new() }; 3];
        for seed in 0..40 {
            let (time, values) = record(seed, 0.05);
            let found = stillness(&time, &values).expect("a record");
            for (k, (estimate, truth)) in
                [(found.mean, 7.0), (found.noise, 0.3), (found.drift_per_s, 0.05)].into_iter().enumerate()
            {
                let off = (estimate.value - truth).abs();
                assert!(off < 6.0 * estimate.u, "seed {seed}, {k}: {estimate:?}");
                outside[k] += usize::from(off > 2.2 * estimate.u);
            }
            // White noise: σ/√n, σ/√(2n), σ·√12/(T·√n).
            let white =
                [0.3 / 4000_f64.sqrt(), 0.3 / 8000_f64.sqrt(), 0.3 * 12_f64.sqrt() / 4.0 / 4000_f64.sqrt()];
            for (ratios, (estimate, white)) in
                ratios.iter_mut().zip([found.mean, found.noise, found.drift_per_s].into_iter().zip(white))
            {
                ratios.push(estimate.u / white);
            }
        }
        for ratios in &mut ratios {
            ratios.sort_by(f64::total_cmp);
            let middle = ratios[20];
            assert!((0.9..1.3).contains(&middle), "u over that of white noise: {ratios:?}");
        }
        assert!(outside.iter().all(|&n| n <= 7), "{outside:?} of 40 beyond 2.2 u");
    }

    #[test]
    fn a_drift_is_no_noise() {
        let (time, values) = record(3, 1.0);
        let found = stillness(&time, &values).expect("a record");
        assert!((found.noise.value - 0.3).abs() < 0.02, "{found:?}");
        assert!((found.drift_per_s.value - 1.0).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn what_stands_perfectly_still_has_neither_noise_nor_drift() {
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        let found = stillness(&time, &[2.5; 100]).expect("a record");
        assert_eq!((found.mean.value, found.mean.u), (2.5, 0.0));
        assert_eq!((found.noise.value, found.drift_per_s.value), (0.0, 0.0));
    }

    #[test]
    fn what_is_no_record_gives_none() {
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(stillness(&time[..63], &[1.0; 63]), Err(StillnessError::TooFew { found: 63 }));
        assert_eq!(stillness(&time, &[1.0; 99]), Err(StillnessError::Length { expected: 100, found: 99 }));
        let mut holed = vec![1.0; 100];
        holed[5] = f64::INFINITY;
        assert_eq!(stillness(&time, &holed), Err(StillnessError::NotFinite { index: 5 }));
        assert_eq!(stillness(&[4.0; 100], &[1.0; 100]), Err(StillnessError::NoTime));
    }
}
