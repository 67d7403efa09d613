//! Response from one sine at a time: stepped, or swept slowly.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::error::{PeriodicError, alive, positive, within_range};
use super::ratio::excited;
use crate::excitation::{HIGHEST_RATIO, Sweep, expected_peak_error};
use crate::frf::{C64, Frf, Line};
use crate::least_squares::LinearFit;

/// Largest η at which the envelope of a sweep is read: the peak is then low by 0.6 %.
const HIGHEST_ETA: f64 = 0.1;
/// Periods from which on amplitude and phase are let bend within the fit: fewer hold no bend that matters, and do not
/// tell it from the sine.
const PERIODS_THAT_BEND: f64 = 4.0;
/// Fewest samples for the three parameters of a sine.
const FEWEST_SAMPLES: usize = 8;

/// How a sweep is demodulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demodulation {
    /// Natural frequency of the least damped mode in the band, Hz.
    pub natural_hz: f64,
    /// Damping ratio of the resonance.
    pub zeta: f64,
    /// Periods of the local frequency that each line is fitted over.
    pub periods: f64,
}

/// Response at one frequency of a stepped sine, after it has settled: amplitudes of input and output by three-parameter
/// least squares (cosine, sine, offset; IEEE 1057, §4.1.4) over the whole periods that the record holds, counted from
/// its end. A period need not be a whole number of samples.
///
/// The variance is that of white residuals of both channels, taken as independent; harmonics count as noise.
///
/// # Errors
/// [`PeriodicError::TooFast`], [`PeriodicError::TooShort`] below one period or 8 samples,
/// [`PeriodicError::MissingReference`], [`PeriodicError::Length`], [`PeriodicError::Constant`],
/// [`PeriodicError::NotFinite`], [`PeriodicError::NotPositive`], [`PeriodicError::TooLarge`].
pub fn stepped_line(
    input: &[f64],
    output: &[f64],
    sample_rate_hz: f64,
    frequency_hz: f64,
) -> Result<Line, PeriodicError> {
    positive("sample rate, Hz", sample_rate_hz)?;
    positive("frequency, Hz", frequency_hz)?;
    same_length(input, output)?;
    let limit_hz = HIGHEST_RATIO * sample_rate_hz;
    if frequency_hz > limit_hz {
        return Err(PeriodicError::TooFast { frequency_hz, limit_hz });
    }
    let period = sample_rate_hz / frequency_hz;
    let whole = (input.len() as f64 / period + 1e-9).floor();
    let samples = ((whole * period).round() as usize).min(input.len());
    let least = (period.ceil() as usize).max(FEWEST_SAMPLES);
    if whole < 1.0 || samples < FEWEST_SAMPLES {
        let what = "samples at one frequency";
        return Err(PeriodicError::TooShort { what, expected: least - 1, found: input.len() });
    }
    let from = input.len() - samples;
    let phase = |i: usize| TAU * (i as f64 / period).fract();
    line(&input[from..], &output[from..], frequency_hz, &columns(samples, &phase))
}

/// Response at given frequencies from one sweep (sample 0 is its start) by synchronous demodulation: around the time
/// that the sweep passes a frequency, input and output are fitted by cos ψ, sin ψ and an offset with the sweep's own
/// phase ψ(t). Over four periods and more amplitude and phase may bend by a square of time, and count in the middle:
/// else a wide mode is averaged over what the sweep passes meanwhile (8 periods at ζ = 0.05 and η = 0.1: −0.6 % of the
/// peak on top of that of the speed).
///
/// Faster than η = 0.1 past the mode the envelope is no longer the response (see [`expected_peak_error`]), and
/// [`fft_ratio`](super::fft_ratio) must be used.
///
/// # Errors
/// [`PeriodicError::SweepTooFast`], [`PeriodicError::TooShort`] where the sweep or the record does not cover the
/// periods around a frequency; those of [`stepped_line`].
pub fn demodulate(
    sweep: &Sweep,
    input: &[f64],
    output: &[f64],
    sample_rate_hz: f64,
    frequencies_hz: &[f64],
    settings: Demodulation,
) -> Result<Frf, PeriodicError> {
    positive("sample rate, Hz", sample_rate_hz)?;
    positive("natural frequency, Hz", settings.natural_hz)?;
    positive("damping ratio", settings.zeta)?;
    positive("periods to fit over", settings.periods)?;
    same_length(input, output)?;
    sweep.check(sample_rate_hz)?;
    let eta = sweep.eta(settings.zeta, settings.natural_hz);
    if eta > HIGHEST_ETA * (1.0 + 1e-9) {
        let expected_error_percent = expected_peak_error(eta)
            .map_or_else(|| "more than −10 %".to_owned(), |e| format!("about {:.1} %", 100.0 * e));
        return Err(PeriodicError::SweepTooFast { eta, limit: HIGHEST_ETA, expected_error_percent });
    }
    frequencies_hz
        .iter()
        .map(|&frequency_hz| {
            positive("frequency, Hz", frequency_hz)?;
            let half_s = 0.5 * settings.periods / frequency_hz;
            let middle_s = sweep.passes_s(frequency_hz);
            let from = ((middle_s - half_s) * sample_rate_hz).round();
            let to = ((middle_s + half_s) * sample_rate_hz).round();
            let last = (sweep.duration_s * sample_rate_hz).min(input.len() as f64);
            if !(from >= 0.0 && to <= last) || to - from < FEWEST_SAMPLES as f64 {
                let found = (last - from).clamp(0.0, to - from) as usize;
                let what = "samples of the sweep around a frequency";
                return Err(PeriodicError::TooShort { what, expected: (to - from) as usize, found });
            }
            let from = from as usize;
            let to = to as usize;
            let phase = |i: usize| sweep.phase_rad((from + i) as f64 / sample_rate_hz);
            let mut columns = columns(to - from, &phase);
            if settings.periods >= PERIODS_THAT_BEND && to - from > 2 * FEWEST_SAMPLES {
                let centre = middle_s * sample_rate_hz - from as f64;
                columns.extend(bends(&columns, centre));
            }
            line(&input[from..to], &output[from..to], frequency_hz, &columns)
        })
        .collect()
}

fn same_length(input: &[f64], output: &[f64]) -> Result<(), PeriodicError> {
    if input.len() == output.len() {
        return Ok(());
    }
    Err(PeriodicError::Length { channel: "output".to_owned(), expected: input.len(), found: output.len() })
}

/// Cosine, sine and offset.
fn columns(samples: usize, phase_rad: &dyn Fn(usize) -> f64) -> Vec<Vec<f64>> {
    let samples_of = |f: fn(f64) -> f64| (0..samples).map(|i| f(phase_rad(i))).collect();
    vec![samples_of(f64::cos), samples_of(f64::sin), vec![1.0; samples]]
}

/// Cosine and sine that grow with time and with its square from a centre (in samples) on.
fn bends(columns: &[Vec<f64>], centre: f64) -> Vec<Vec<f64>> {
    let half = 0.5 * columns[0].len() as f64;
    let grown = |column: &Vec<f64>, power: i32| {
        column.iter().enumerate().map(|(i, v)| v * ((i as f64 - centre) / half).powi(power)).collect()
    };
    [1, 2].into_iter().flat_map(|power| columns[..2].iter().map(move |c| grown(c, power))).collect()
}

/// Ratio of the sines that fit best; cosine and sine are the first columns.
fn line(
    input: &[f64],
    output: &[f64],
    frequency_hz: f64,
    columns: &[Vec<f64>],
) -> Result<Line, PeriodicError> {
    alive("input", input, 0)?;
    alive("output", output, 0)?;
    let fit = |values: &[f64]| {
        LinearFit::new(columns, values, None).map_err(|_| PeriodicError::Indistinct { frequency_hz })
    };
    let u = fit(input)?;
    let y = fit(output)?;
    let amplitude = |f: &LinearFit| C64::new(f.coefficients[0], -f.coefficients[1]);
    let variance = |f: &LinearFit| {
        let covariance: DMatrix<f64> = f.covariance();
        covariance[(0, 0)] + covariance[(1, 1)]
    };
    let found = amplitude(&u).norm();
    let expected = 1e-12 * input.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if found <= expected {
        return Err(PeriodicError::MissingReference { frequency_hz, expected, found });
    }
    excited(frequency_hz, amplitude(&u))?;
    let value = amplitude(&y) / amplitude(&u);
    let spread = (variance(&y) + value.norm_sqr() * variance(&u)) / amplitude(&u).norm_sqr();
    within_range("response", value.norm_sqr() + spread + amplitude(&u).norm_sqr())?;
    Ok(Line { frequency_hz, value, variance: spread, dof: 0.5 * y.dof as f64, coherence: None })
}
