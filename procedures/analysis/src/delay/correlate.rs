//! Delay between two records of the same signal: cross-correlation, refined by the phase of the cross spectrum.

use std::f64::consts::{PI, TAU};

use super::input::{InputError, check_values};
use super::{DelayError, Includes};
use crate::frf::C64;

/// Fewest samples of a record.
const LEAST_SAMPLES: usize = 64;
/// Least normalised correlation, by absolute value, with which the records count as the same signal.
const LEAST_CORRELATION: f64 = 0.1;
/// Fewest segments over which the cross spectrum is averaged.
const SEGMENTS: usize = 8;
/// Independent averages per segment, for Hann windows with 50 % overlap.
const INDEPENDENT: f64 = 0.947;

/// Frequency band that carries signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Lower end, Hz.
    pub from_hz: f64,
    /// Upper end, Hz; at most half the sampling rate.
    pub to_hz: f64,
}

/// Delay of one record behind another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossDelay {
    /// Delay, s; positive where the second record lags the first.
    pub delay_s: f64,
    /// Standard uncertainty of `delay_s`, s.
    pub u_s: f64,
    /// Lag of the largest correlation in whole samples, with the sign of `delay_s`.
    pub lag_samples: i64,
    /// Normalised correlation at `lag_samples`, −1…1; negative where one record is inverted.
    pub correlation: f64,
    /// χ² of the phases per degree of freedom: far above 1 where the path between the records is more than a delay.
    pub misfit: f64,
    /// Which delays of the path are part of `delay_s`.
    pub includes: Includes,
}

/// Delay of the record `second` behind the record `first`.
///
/// The whole samples come from the largest cross-correlation, the remaining fraction of a sample from the slope of the
/// cross spectrum's phase in `band`. A parabola through three samples of the correlation would be biased by percents of
/// a sample.
///
/// The records are equally long and sampled together at `sample_rate_hz`. Lags up to `most_lag_s` are searched in both
/// directions. The phase line passes through 0 at 0 Hz, or through π if one record is inverted; its points are weighted
/// by γ²/(1 − γ²) (Carter, *Proc. IEEE* 75, 236, 1987).
///
/// # Errors
/// Records or settings that are not usable, records that do not resemble each other, or no fit of the phase.
pub fn cross_correlation(
    first: &[f64],
    second: &[f64],
    sample_rate_hz: f64,
    band: Band,
    most_lag_s: f64,
) -> Result<CrossDelay, DelayError> {
    check(first, second, sample_rate_hz, band, most_lag_s)?;
    // At least half of each record overlaps the other.
    let most_lag = ((most_lag_s * sample_rate_hz).ceil() as usize).min(first.len() / 2);
    let first = centred(first);
    let second = centred(second);
    let (lag, correlation) = whole_lag(&first, &second, most_lag);
    if correlation.abs() < LEAST_CORRELATION {
        return Err(DelayError::Unlike { found: correlation, least: LEAST_CORRELATION });
    }
    let overlap = first.len() - lag.unsigned_abs() as usize;
    // Both records are cut to their overlap, so that less than a sample of delay is left between them.
    let [first_start, second_start] = [(-lag).max(0) as usize, lag.max(0) as usize];
    let aligned_first = &first[first_start..first_start + overlap];
    let aligned_second = &second[second_start..second_start + overlap];
    let spectra = Spectra::new(aligned_first, aligned_second);
    let (remaining_s, u_s, misfit) =
        spectra.slope(sample_rate_hz, band, correlation < 0.0).ok_or(DelayError::NoFit)?;
    Ok(CrossDelay {
        delay_s: lag as f64 / sample_rate_hz + remaining_s,
        u_s,
        lag_samples: lag,
        correlation,
        misfit,
        includes: Includes::WholePhaseSlope,
    })
}

fn check(first: &[f64], second: &[f64], rate_hz: f64, band: Band, most_lag_s: f64) -> Result<(), InputError> {
    if first.len() < LEAST_SAMPLES {
        return Err(InputError::TooFew { found: first.len(), least: LEAST_SAMPLES });
    }
    check_values(first, first.len())?;
    check_values(second, first.len())?;
    let require = |name, found: f64, is_valid: bool, expected| {
        if is_valid { Ok(()) } else { Err(InputError::Setting { name, found, expected }) }
    };
    require("sample_rate_hz", rate_hz, rate_hz.is_finite() && rate_hz > 0.0, "a positive number")?;
    require("most_lag_s", most_lag_s, most_lag_s.is_finite() && most_lag_s >= 0.0, "zero or more")?;
    require("from_hz", band.from_hz, band.from_hz >= 0.0, "zero or more")?;
    let is_in_range = band.to_hz > band.from_hz && band.to_hz <= 0.5 * rate_hz;
    require("to_hz", band.to_hz, is_in_range, "above from_hz, at most half the sampling rate")
}

fn centred(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|v| v - mean).collect()
}

/// Lag in whole samples at which the correlation is largest by absolute value, and the normalised correlation there.
///
/// A positive lag means that `second` lags `first`. Lags from −`most` to `most` samples are searched.
fn whole_lag(first: &[f64], second: &[f64], most: usize) -> (i64, f64) {
    // Padded with zeros, so that the circular correlation does not wrap around within the lags searched.
    let n = (first.len() + most).next_power_of_two();
    let forward = fourier::forward(n);
    let back = fourier::inverse(n);
    let transform = |values: &[f64]| {
        let mut padded = values.to_vec();
        padded.resize(n, 0.0);
        let mut lines = forward.make_output_vec();
        forward.process(&mut padded, &mut lines).expect("buffers are made by the plan");
        lines
    };
    let mut cross: Vec<C64> =
        transform(first).iter().zip(transform(second)).map(|(a, b)| a.conj() * b).collect();
    // Real signals have real lines at 0 Hz and at half the sampling rate. Rounding must not leave an imaginary part there:
    // the inverse transform would report an error.
    let end = cross.len() - 1;
    (cross[0].im, cross[end].im) = (0.0, 0.0);
    let mut correlation = back.make_output_vec();
    back.process(&mut cross, &mut correlation).expect("buffers are made by the plan");
    let most = most as i64;
    // Negative lags stand at the end of the circular correlation.
    let correlation_at = |lag: i64| correlation[lag.rem_euclid(n as i64) as usize] / n as f64;
    let lag = (-most..=most)
        .max_by(|a, b| correlation_at(*a).abs().total_cmp(&correlation_at(*b).abs()))
        .unwrap_or(0);
    let energy = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    let norm = (energy(first) * energy(second)).sqrt();
    (lag, if norm > 0.0 { correlation_at(lag) / norm } else { 0.0 })
}

/// Cross spectrum and power spectra of two aligned records, each summed over the segments.
struct Spectra {
    /// Conjugate of the first record's spectrum times that of the second: its phase is negative where the second lags.
    cross: Vec<C64>,
    first: Vec<f64>,
    second: Vec<f64>,
    /// Samples of a segment.
    length: usize,
    /// Number of segments.
    segments: usize,
}

impl Spectra {
    /// Welch's method with Hann windows of 1024 samples and 50 % overlap. The windows are shorter where the records would
    /// hold fewer than [`SEGMENTS`] of them.
    fn new(first: &[f64], second: &[f64]) -> Self {
        // Even, so that a segment has a line at half the sampling rate and can be halved for the overlap.
        let length = (2 * first.len() / (SEGMENTS + 1)).min(1024) / 2 * 2;
        let forward = fourier::forward(length);
        let window: Vec<f64> = (0..length).map(|i| (PI * i as f64 / length as f64).sin().powi(2)).collect();
        let count = length / 2 + 1;
        let mut spectra = Self {
            cross: vec![C64::default(); count],
            first: vec![0.0; count],
            second: vec![0.0; count],
            length,
            segments: 0,
        };
        let transform = |values: &[f64]| {
            let mut windowed: Vec<f64> = values.iter().zip(&window).map(|(v, w)| v * w).collect();
            let mut lines = forward.make_output_vec();
            forward.process(&mut windowed, &mut lines).expect("buffers are made by the plan");
            lines
        };
        for start in (0..=first.len() - length).step_by(length / 2) {
            let a = transform(&first[start..start + length]);
            let b = transform(&second[start..start + length]);
            for k in 0..count {
                spectra.cross[k] += a[k].conj() * b[k];
                spectra.first[k] += a[k].norm_sqr();
                spectra.second[k] += b[k].norm_sqr();
            }
            spectra.segments += 1;
        }
        spectra
    }

    /// Delay left between the records, s, its standard uncertainty, s, and χ² per degree of freedom.
    ///
    /// The delay τ is the negative slope of a line through the origin, phase = −ωτ. The phase needs no unwrapping: less
    /// than a sample of delay is left.
    fn slope(&self, sample_rate_hz: f64, band: Band, inverted: bool) -> Option<(f64, f64, f64)> {
        let averages = (INDEPENDENT * self.segments as f64).max(1.0);
        // Sums of the regression through the origin.
        let mut weighted_product = 0.0;
        let mut weighted_square = 0.0;
        let mut count = 0.0;
        let mut chi2 = 0.0;
        let lines: Vec<[f64; 3]> = (1..self.length / 2)
            .map(|k| (k, k as f64 * sample_rate_hz / self.length as f64))
            .filter(|(_, hz)| (band.from_hz..=band.to_hz).contains(hz))
            .filter_map(|(k, hz)| {
                let coherence = self.cross[k].norm_sqr() / (self.first[k] * self.second[k]);
                let coherence = coherence.clamp(0.0, 1.0 - 1e-12);
                // Reciprocal of the variance of the phase, 1/rad².
                let weight = 2.0 * averages * coherence / (1.0 - coherence);
                let sign = if inverted { -1.0 } else { 1.0 };
                weight.is_finite().then(|| [TAU * hz, (sign * self.cross[k]).arg(), weight])
            })
            .collect();
        for [omega, phase, weight] in &lines {
            weighted_product -= weight * omega * phase;
            weighted_square += weight * omega * omega;
            count += 1.0;
        }
        let delay_s = weighted_product / weighted_square;
        for [omega, phase, weight] in &lines {
            chi2 += weight * (phase + omega * delay_s).powi(2);
        }
        // A Hann window makes neighbouring lines depend on each other: 1.5 lines of noise bandwidth, and amplitude
        // correlations 2/3 and 1/6 whose squares double the variance of a mean of lines: 1 + 2·(4/9 + 1/36) = 35/18.
        let widening = 35.0 / 18.0;
        let misfit = chi2 / (count - 1.0);
        let u_s = (widening * misfit.max(1.0) / weighted_square).sqrt();
        (count > 2.0 && delay_s.is_finite() && u_s.is_finite()).then_some((delay_s, u_s, misfit))
    }
}
