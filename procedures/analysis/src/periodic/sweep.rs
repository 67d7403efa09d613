//! Response from whole sweeps by the ratio of transforms.

use std::ops::RangeInclusive;

use super::error::{PeriodicError, alive, positive};
use super::ratio::errors_in_variables;
use crate::frf::{C64, Frf, Line};

/// Smallest input at a line, in parts of its largest in the band.
const LEAST_INPUT: f64 = 1e-6;
/// Part of the record at its end that shows whether the plant has come to rest.
const TAIL: usize = 50;

/// Response from sweeps.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepResponse {
    /// All lines of the transform in the band. From one sweep the variance is not known: infinite, no degree of
    /// freedom; from several it is that of their scatter.
    pub frf: Frf,
    /// rms of the output's last 2 % over that of the whole record, both about the first sample (the rest that the
    /// record begins at, whatever offset the sensor has), the worst record: what is far above the noise says that the
    /// ring-down is cut, and the response wrong by about as much.
    pub ring_down_ratio: f64,
}

/// Ŷ/Û of whole records that begin at rest and hold the sweep **and** its ring-down: free of the error of a fast
/// sweep, because nothing leaks when a transient record begins and ends at rest. Repeats (records of one length with
/// the same sweep at the same sample) are averaged with errors in both channels ([`errors_in_variables`]).
///
/// # Errors
/// [`PeriodicError::TooFew`] without a record or a line; [`PeriodicError::Length`], [`PeriodicError::Constant`],
/// [`PeriodicError::NotFinite`], [`PeriodicError::NotPositive`]; [`PeriodicError::MissingReference`] at a line that
/// the sweep does not reach.
pub fn fft_ratio(
    inputs: &[&[f64]],
    outputs: &[&[f64]],
    sample_rate_hz: f64,
    band_hz: &RangeInclusive<f64>,
) -> Result<SweepResponse, PeriodicError> {
    positive("sample rate, Hz", sample_rate_hz)?;
    let length = check(inputs, outputs)?;
    let step_hz = sample_rate_hz / length as f64;
    let lines: Vec<usize> =
        (1..length.div_ceil(2)).filter(|&k| band_hz.contains(&(k as f64 * step_hz))).collect();
    if lines.is_empty() {
        return Err(PeriodicError::TooFew { what: "lines in the band", expected: 1, found: 0 });
    }
    let frequencies_hz: Vec<f64> = lines.iter().map(|&k| k as f64 * step_hz).collect();
    let u: Vec<Vec<C64>> = inputs.iter().map(|v| transform(v, &lines)).collect();
    let y: Vec<Vec<C64>> = outputs.iter().map(|v| transform(v, &lines)).collect();
    excited(&frequencies_hz, &u)?;
    let frf = if inputs.len() > 1 {
        errors_in_variables(&frequencies_hz, &u, &y)?
    } else {
        let line = |(l, &f): (usize, &f64)| {
            let value = y[0][l] / u[0][l];
            Line { frequency_hz: f, value, variance: f64::INFINITY, dof: 0.0, coherence: None }
        };
        frequencies_hz.iter().enumerate().map(line).collect()
    };
    let ring_down_ratio = outputs.iter().map(|v| ring_down(v)).fold(0.0, f64::max);
    Ok(SweepResponse { frf, ring_down_ratio })
}

fn check(inputs: &[&[f64]], outputs: &[&[f64]]) -> Result<usize, PeriodicError> {
    let expected = inputs.first().map_or(0, |v| v.len());
    if expected < 2 * TAIL {
        return Err(PeriodicError::TooShort { what: "samples a sweep", expected: 2 * TAIL, found: expected });
    }
    if inputs.len() != outputs.len() {
        let channel = "records of the output".to_owned();
        return Err(PeriodicError::Length { channel, expected: inputs.len(), found: outputs.len() });
    }
    for (name, records) in [("input", inputs), ("output", outputs)] {
        for (i, values) in records.iter().enumerate() {
            let channel = format!("{name} of sweep {i}");
            if values.len() != expected {
                return Err(PeriodicError::Length { channel, expected, found: values.len() });
            }
            alive(&channel, values, 0)?;
        }
    }
    Ok(expected)
}

fn transform(values: &[f64], lines: &[usize]) -> Vec<C64> {
    let plan = fourier::forward(values.len());
    let mut spectrum = plan.make_output_vec();
    plan.process(&mut values.to_vec(), &mut spectrum).expect("the plan has the record's length");
    lines.iter().map(|&k| spectrum[k]).collect()
}

fn excited(frequencies_hz: &[f64], u: &[Vec<C64>]) -> Result<(), PeriodicError> {
    for lines in u {
        let expected = LEAST_INPUT * lines.iter().map(|v| v.norm()).fold(0.0, f64::max);
        if let Some((&frequency_hz, v)) = frequencies_hz.iter().zip(lines).find(|(_, v)| v.norm() <= expected)
        {
            return Err(PeriodicError::MissingReference { frequency_hz, expected, found: v.norm() });
        }
    }
    Ok(())
}

fn ring_down(values: &[f64]) -> f64 {
    let level = values.first().copied().unwrap_or_default();
    let largest = values.iter().map(|v| (v - level).abs()).fold(0.0, f64::max);
    if largest <= 0.0 {
        return 0.0;
    }
    let rms =
        |v: &[f64]| (v.iter().map(|x| ((x - level) / largest).powi(2)).sum::<f64>() / v.len() as f64).sqrt();
    rms(&values[values.len() - values.len() / TAIL..]) / rms(values)
}
