//! Delay between two records of the same signal.

use std::f64::consts::{PI, TAU};

use super::input::{InputError, check_values};
use super::{DelayError, Includes};
use crate::frf::C64;

/// Least samples of a record.
const LEAST_SAMPLES: usize = 64;
/// Least normalised correlation.
const LEAST_CORRELATION: f64 = 0.1;
/// Least segments of the cross spectrum.
const SEGMENTS: usize = 8;
/// Part of the segments of a Hann window at half overlap that counts as independent.
const INDEPENDENT: f64 = 0.947;

/// Frequencies that carry signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// From, Hz.
    pub from_hz: f64,
    /// To, Hz; below half the sampling rate.
    pub to_hz: f64,
}

/// Delay of one record behind another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossDelay {
    /// Delay, s; positive where the second record is late.
    pub delay_s: f64,
    /// Standard uncertainty of `delay_s`, s.
    pub u_s: f64,
    /// Whole samples of it.
    pub lag_samples: i64,
    /// Normalised correlation at the whole samples; negative where one record is inverted.
    pub correlation: f64,
    /// χ² of the phases over degrees of freedom: far above 1 where the path is more than a delay.
    pub misfit: f64,
    /// What the delay holds.
    pub includes: Includes,
}

/// Whole samples from the largest cross correlation, the rest from the phase of the cross spectrum in a band (a parabola
/// through three samples of the correlation is biased by percents of a sample).
///
/// Records are equally long and sampled together at `sample_rate_hz`; lags up to `most_lag_s` either way. The phase runs
/// through 0 at 0 Hz (through π if inverted), weights γ²/(1 − γ²) (Carter, *Proc. IEEE* 75, 236, 1987).
///
/// # Errors
/// Records that are none, or that do not resemble each other.
pub fn cross_correlation(
    first: &[f64],
    second: &[f64],
    sample_rate_hz: f64,
    band: Band,
    most_lag_s: f64,
) -> Result<CrossDelay, DelayError> {
    check(first, second, sample_rate_hz, band, most_lag_s)?;
    let most = ((most_lag_s * sample_rate_hz).ceil() as usize).min(first.len() / 2);
    let first = centred(first);
    let second = centred(second);
    let (lag, correlation) = whole_lag(&first, &second, most);
    if correlation.abs() < LEAST_CORRELATION {
        return Err(DelayError::Unlike { found: correlation, least: LEAST_CORRELATION });
    }
    let overlap = first.len() - lag.unsigned_abs() as usize;
    let [early, late] = [(-lag).max(0) as usize, lag.max(0) as usize];
    let spectra = Spectra::new(&first[early..early + overlap], &second[late..late + overlap]);
    let (rest_s, u_s, misfit) =
        spectra.slope(sample_rate_hz, band, correlation < 0.0).ok_or(DelayError::NoFit)?;
    Ok(CrossDelay {
        delay_s: lag as f64 / sample_rate_hz + rest_s,
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
    let setting = |name, found: f64, fine: bool, expected| {
        fine.then_some(()).ok_or(InputError::Setting { name, found, expected })
    };
    setting("sample_rate_hz", rate_hz, rate_hz.is_finite() && rate_hz > 0.0, "a positive number")?;
    setting("most_lag_s", most_lag_s, most_lag_s.is_finite() && most_lag_s >= 0.0, "zero or more")?;
    setting("from_hz", band.from_hz, band.from_hz >= 0.0, "zero or more")?;
    let inside = band.to_hz > band.from_hz && band.to_hz <= 0.5 * rate_hz;
    setting("to_hz", band.to_hz, inside, "above from_hz, at most half the sampling rate")
}

fn centred(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|v| v - mean).collect()
}

/// Lag of the largest correlation by size, and that correlation.
fn whole_lag(first: &[f64], second: &[f64], most: usize) -> (i64, f64) {
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
    // Both ends of a real signal's spectrum are real.
    let end = cross.len() - 1;
    (cross[0].im, cross[end].im) = (0.0, 0.0);
    let mut correlation = back.make_output_vec();
    back.process(&mut cross, &mut correlation).expect("buffers are made by the plan");
    let most = most as i64;
    let correlated = |lag: i64| correlation[lag.rem_euclid(n as i64) as usize] / n as f64;
    let lag =
        (-most..=most).max_by(|a, b| correlated(*a).abs().total_cmp(&correlated(*b).abs())).unwrap_or(0);
    let power = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    let both = (power(first) * power(second)).sqrt();
    (lag, if both > 0.0 { correlated(lag) / both } else { 0.0 })
}

/// Averaged spectra of two aligned records.
struct Spectra {
    cross: Vec<C64>,
    first: Vec<f64>,
    second: Vec<f64>,
    length: usize,
    segments: usize,
}

impl Spectra {
    /// Welch's method: Hann windows of 1024 samples at half overlap, shorter ones where the records hold fewer than eight.
    fn new(first: &[f64], second: &[f64]) -> Self {
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

    /// Slope of the phase through the origin, its uncertainty, χ² over degrees of freedom.
    fn slope(&self, sample_rate_hz: f64, band: Band, inverted: bool) -> Option<(f64, f64, f64)> {
        let averages = (INDEPENDENT * self.segments as f64).max(1.0);
        let mut along = 0.0;
        let mut square = 0.0;
        let mut count = 0.0;
        let mut chi2 = 0.0;
        let lines: Vec<[f64; 3]> = (1..self.length / 2)
            .map(|k| (k, k as f64 * sample_rate_hz / self.length as f64))
            .filter(|(_, hz)| (band.from_hz..=band.to_hz).contains(hz))
            .filter_map(|(k, hz)| {
                let coherence = self.cross[k].norm_sqr() / (self.first[k] * self.second[k]);
                let coherence = coherence.clamp(0.0, 1.0 - 1e-12);
                let weight = 2.0 * averages * coherence / (1.0 - coherence);
                let sign = if inverted { -1.0 } else { 1.0 };
                weight.is_finite().then(|| [TAU * hz, (sign * self.cross[k]).arg(), weight])
            })
            .collect();
        for [omega, phase, weight] in &lines {
            along -= weight * omega * phase;
            square += weight * omega * omega;
            count += 1.0;
        }
        let slope = along / square;
        for [omega, phase, weight] in &lines {
            chi2 += weight * (phase + omega * slope).powi(2);
        }
        // A Hann window makes neighbouring lines depend on each other: 1.5 lines of noise bandwidth, and amplitude
        // correlations 2/3 and 1/6 whose squares double the variance of a mean of lines: 1 + 2·(4/9 + 1/36) = 35/18.
        let widening = 35.0 / 18.0;
        let misfit = chi2 / (count - 1.0);
        let u = (widening * misfit.max(1.0) / square).sqrt();
        (count > 2.0 && slope.is_finite() && u.is_finite()).then_some((slope, u, misfit))
    }
}
