//! Error of an encoder within the pitches of its scale, by gyros, while the axis turns slowly.
//!
//! A scale is read by interpolation between its lines; offsets, unequal amplitudes and phase errors of the two signals
//! repeat with every pitch, one and two (and a distorted signal three) times a pitch (Heydemann, *Applied Optics* 20, 3382,
//! 1981). Gyros do not know the scale: what they turn less than the encoder and repeats with the pitch is its error.

use std::f64::consts::TAU;

use super::least_squares::{FitError, LinearFit};
use super::uncertainty::correlation_factor;
use crate::estimate::Estimate;

#[cfg(test)]
mod tests;

/// Periods a pitch that are looked for.
const HARMONICS: usize = 3;
/// A harmonic beyond the first counts from so many of its standard uncertainties on.
const SIGNIFICANT: f64 = 4.0;
/// Fewest pitches to turn through.
const LEAST_PITCHES: f64 = 4.0;
/// A harmonic must stay below this part of the sampling rate.
const BAND: f64 = 0.25;
/// Places within a pitch at which the error is looked at.
const PLACES: usize = 360;
/// Columns before the harmonics: the constant.
const OTHERS: usize = 1;
/// The axis turns steadily where the rate over the pitch around a sample is within this part of the median one: there the
/// scale error of the gyros is a constant, and their delay shows nothing.
const STEADY: f64 = 0.2;

/// Why there is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PitchError {
    /// The rates do not belong to the angles.
    #[error("expected {expected} rates for {angles} angles, found {found}")]
    Length {
        /// Angles.
        angles: usize,
        /// One rate fewer than angles.
        expected: usize,
        /// Rates found.
        found: usize,
    },
    /// The axis did not turn through a few pitches.
    #[error("the axis turned through {pitches:.1} pitches of its scale, at least {LEAST_PITCHES} are needed")]
    TooFew {
        /// Pitches.
        pitches: f64,
    },
    /// Pitches pass faster than the samples resolve.
    #[error("pitches pass at {pitches_hz:.1} Hz, above a quarter of the {sampling_hz:.0} samples a second")]
    TooFast {
        /// Pitches a second at the largest rate.
        pitches_hz: f64,
        /// Samples a second.
        sampling_hz: f64,
    },
    /// The motion does not determine it.
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// Largest error within a pitch, rad, zero to peak.
///
/// `turned_rad` is the angle that the encoder has turned through, at the ends of the samples (`period_s` apart, one more than
/// rates); `rate_rad_per_s` is the mean rate by the gyros about the same axis over each sample. `pitches_per_rev` of the scale.
/// Where the axis turns steadily, the difference of the rates is fitted by the differences of sines of the pitch over each
/// sample and a constant (bias, and scale error times rate); harmonics beyond the first that are lost in the noise are left out of
/// the peak.
///
/// # Errors
/// See [`PitchError`].
pub fn pitch_error(
    turned_rad: &[f64],
    rate_rad_per_s: &[f64],
    period_s: f64,
    pitches_per_rev: f64,
) -> Result<Estimate, PitchError> {
    let n = rate_rad_per_s.len();
    if turned_rad.len() != n + 1 || n < 2 {
        let expected = turned_rad.len().saturating_sub(1);
        return Err(PitchError::Length { angles: turned_rad.len(), expected, found: n });
    }
    let per_rad = pitches_per_rev / TAU;
    let [low, high] = turned_rad
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], a| [low.min(*a), high.max(*a)]);
    let pitches = (high - low) * per_rad;
    if pitches < LEAST_PITCHES || pitches.is_nan() {
        return Err(PitchError::TooFew { pitches });
    }
    let rates: Vec<f64> = turned_rad.windows(2).map(|a| (a[1] - a[0]) / period_s).collect();
    let pitches_hz = fast(&rates) * per_rad;
    let harmonics = (BAND / (pitches_hz * period_s)).min(HARMONICS as f64) as usize;
    if harmonics == 0 {
        return Err(PitchError::TooFast { pitches_hz, sampling_hz: 1.0 / period_s });
    }
    let steady = steady(turned_rad, pitches_hz * period_s);
    let pitches = steady.len() as f64 * period_s * pitches_hz;
    if pitches < LEAST_PITCHES {
        return Err(PitchError::TooFew { pitches });
    }
    let columns = columns(turned_rad, &steady, period_s, per_rad, harmonics);
    let less: Vec<f64> = steady.iter().map(|&k| rates[k] - rate_rad_per_s[k]).collect();
    let fit = LinearFit::new(&columns, &less, None)?;
    let wide = correlation_factor(&fit.residuals);
    Ok(peak(&fit, harmonics, wide))
}

/// Rate that the axis does not exceed in 99 % of the samples: single ones hold the noise of the encoder.
fn fast(rates: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = rates.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes[(99 * (sizes.len() - 1)) / 100]
}

/// Samples where the axis turns steadily; it turns through about `pitches` a sample.
fn steady(turned_rad: &[f64], pitches: f64) -> Vec<usize> {
    let half = (0.5 / pitches).ceil() as usize;
    let around = |k: usize| (turned_rad[k + 1 + half] - turned_rad[k - half]).abs();
    let known = half..turned_rad.len().saturating_sub(half + 1);
    let mut sizes: Vec<f64> = known.clone().map(around).collect();
    sizes.sort_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    known.filter(|&k| (around(k) - median).abs() <= STEADY * median).collect()
}

/// Columns of these samples.
fn columns(
    turned: &[f64],
    samples: &[usize],
    period_s: f64,
    per_rad: f64,
    harmonics: usize,
) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![1.0; samples.len()]];
    for harmonic in 1..=harmonics {
        let phase = |k: usize| TAU * harmonic as f64 * per_rad * turned[k];
        let difference = |wave: fn(f64) -> f64| -> Vec<f64> {
            samples.iter().map(|&k| (wave(phase(k + 1)) - wave(phase(k))) / period_s).collect()
        };
        columns.push(difference(f64::sin));
        columns.push(difference(f64::cos));
    }
    columns
}

/// The largest of the fitted error over a pitch.
fn peak(fit: &LinearFit, harmonics: usize, wide: f64) -> Estimate {
    let of_noise = fit.residual_variance * wide;
    let size = |h: usize| fit.coefficients[OTHERS + 2 * h].hypot(fit.coefficients[OTHERS + 2 * h + 1]);
    let u2 = |h: usize| {
        let place = OTHERS + 2 * h;
        0.5 * of_noise
            * (fit.unscaled_covariance[(place, place)] + fit.unscaled_covariance[(place + 1, place + 1)])
    };
    let counted: Vec<usize> =
        (0..harmonics).filter(|&h| h == 0 || size(h) > SIGNIFICANT * u2(h).sqrt()).collect();
    let error = |place: usize| -> f64 {
        let phase = TAU * place as f64 / PLACES as f64;
        counted
            .iter()
            .map(|&h| {
                let [sin, cos] = [fit.coefficients[OTHERS + 2 * h], fit.coefficients[OTHERS + 2 * h + 1]];
                let at = (h + 1) as f64 * phase;
                sin * at.sin() + cos * at.cos()
            })
            .sum()
    };
    let value = (0..PLACES).map(|place| error(place).abs()).fold(0.0, f64::max);
    let u = counted.iter().map(|&h| u2(h)).sum::<f64>().sqrt();
    Estimate { value, u, dof: (fit.dof as f64 / wide).max(1.0), n: fit.residuals.len() }
}
