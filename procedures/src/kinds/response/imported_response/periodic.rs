//! Responses of a periodic record: exact command, lines, distortion at lines that are not excited.

use std::f64::consts::TAU;
use std::ops::Range;

use analysis::estimate::Estimate;
use analysis::frf::{C64, Frf};
use analysis::periodic::{
    Channel, DetectionLine, Drift, LineKind, PeriodicError, Windows, errors_in_variables, fast, spectra_with,
    times_jw, transient,
};

use super::answer::Answer;
use super::{Record, Response};
use crate::log::Rows;
use crate::measurement::Evidence;
use crate::reason::{Reason, ResponseReason};

/// Periods that a variance needs.
const LEAST_PERIODS: usize = 3;
/// Jitter of the rows, in steps, that still is a constant rate.
const JITTER: f64 = 0.05;
/// Smallest amplitude of the input at an excited line, in parts of its largest.
const LEAST_INPUT: f64 = 1e-3;
/// Smallest amplitude of the input in standard deviations of its mean.
const LEAST_INPUT_SD: f64 = 3.0;
/// Relative standard deviation from which on a line says nothing.
const MOST_DEVIATION: f64 = 0.5;
/// Largest distance of a line from its place on the grid, in lines.
const OFF_GRID: f64 = 1e-6;

/// The periods of a record.
pub(super) struct Periods<'a> {
    rows: &'a Rows,
    keys: &'a Record,
    rate_hz: f64,
    length: usize,
    kept: Range<usize>,
    rest: usize,
    /// Bins of the excited lines.
    bins: Vec<usize>,
}

impl<'a> Periods<'a> {
    /// Finds the periods in the rows of one segment.
    pub(super) fn new(rows: &'a Rows, within: &Range<usize>, keys: &'a Record) -> Result<Self, Reason> {
        let time_s = &rows.time_s[within.clone()];
        let count = time_s.len();
        if count < 2 {
            return Err(ResponseReason::NoImportedRecord { rows: count }.into());
        }
        let first_s = time_s[0];
        let span_s = time_s[count - 1] - time_s[0];
        let step_s = span_s / (count - 1) as f64;
        let uneven = |k: &usize| (time_s[*k] - first_s - *k as f64 * step_s).abs() > JITTER * step_s;
        if let Some(row) = (0..count).find(uneven) {
            return Err(ResponseReason::Uneven { row: row + 1, step_s }.into());
        }
        // Times are whole nanoseconds: their rounding must not make a whole period a broken one.
        let samples = keys.period_s / step_s;
        let doubt = samples * (2e-9 / span_s + 1e-9);
        if (samples - samples.round()).abs() > doubt || samples.round() < 2.0 {
            return Err(PeriodicError::NonIntegerWindow {
                window_s: keys.period_s,
                sample_rate_hz: step_s.recip(),
                samples,
            }
            .into());
        }
        let length = samples.round() as usize;
        let periods = count / length;
        let dropped = keys.dropped as usize;
        if periods < dropped + LEAST_PERIODS {
            return Err(ResponseReason::ShortRecord {
                least: LEAST_PERIODS,
                length,
                dropped,
                samples: count,
            }
            .into());
        }
        let kept = within.start + dropped * length..within.start + periods * length;
        let rate_hz = length as f64 / keys.period_s;
        Ok(Self { rows, keys, rate_hz, length, kept, rest: count % length, bins: bins(keys)? })
    }

    fn hz(&self, bin: usize) -> f64 {
        bin as f64 / self.keys.period_s
    }

    fn kept(&self, name: &str) -> Result<&[f64], Reason> {
        let column = self.rows.column(name).ok_or_else(|| {
            let topic = self.rows.topic.name.clone();
            let known = self.rows.topic.channels.iter().map(|c| c.name.clone()).collect();
            ResponseReason::NoChannelOf { topic, channel: name.to_owned(), known }
        })?;
        Ok(&column[self.kept.clone()])
    }

    /// Amplitudes of a channel, period × line; the reference is mended, with the count of samples that differed.
    fn amplitudes(&self, name: &str, bins: &[usize]) -> Result<(Vec<Vec<C64>>, usize), Reason> {
        let recorded = self.kept(name)?;
        let mended = match &self.keys.reference {
            Some(reference) if reference == name => Some(repeated(name, recorded, self.length)?),
            _ => None,
        };
        let samples = mended.as_ref().map_or(recorded, |(samples, _)| samples.as_slice());
        let periods = samples.len() / self.length;
        let starts = (0..periods).map(|p| p * self.length).collect();
        let windows = Windows { sample_rate_hz: self.rate_hz, length: self.length, starts };
        let grid_hz: Vec<f64> = bins.iter().map(|&bin| self.hz(bin)).collect();
        let channel = Channel { name, samples };
        let mut found = spectra_with(&windows, &grid_hz, &[channel], &[], Drift::Level)?;
        Ok((found.remove(0), mended.map_or(0, |(_, differing)| differing)))
    }

    /// Amplitudes of the output with sign and derivative.
    fn output(&self, response: &Response, bins: &[usize]) -> Result<(Vec<Vec<C64>>, usize), Reason> {
        let (mut periods, differing) = self.amplitudes(&response.output, bins)?;
        if response.reversed {
            periods.iter_mut().flatten().for_each(|v| *v = -*v);
        }
        Ok((periods, differing))
    }

    /// One response.
    pub(super) fn answer(&self, response: &Response) -> Result<Answer, Reason> {
        let input = response.input.as_deref().unwrap_or(&self.keys.input);
        let mut answer = Answer::default();
        if let Some(reference) = &self.keys.reference {
            // Also where it is not the input: a reference that does not repeat makes the period doubtful.
            let (_, differing) = repeated(reference, self.kept(reference)?, self.length)?;
            let reason = format!(
                "{reference}: differs from the other periods; replaced by the median over the periods"
            );
            answer.exclude(differing, "samples", reason);
        }
        let frequencies_hz: Vec<f64> = self.bins.iter().map(|&bin| self.hz(bin)).collect();
        let (u, _) = self.amplitudes(input, &self.bins)?;
        let (y, _) = self.output(response, &self.bins)?;
        held(input, &frequencies_hz, &u)?;
        let frf = errors_in_variables(&frequencies_hz, &u, &y)?;
        let frf = times_jw(&frf, response.derivative)?;
        let (lines, hollow): (Frf, Frf) =
            frf.into_iter().partition(|l| l.variance.sqrt() <= MOST_DEVIATION * l.value.norm());
        if lines.is_empty() {
            return Err(ResponseReason::NotFollowing {
                output: response.output.clone(),
                input: input.to_owned(),
            }
            .into());
        }
        answer.exclude(self.kept.start, "samples", format!("transient: first {} periods", self.keys.dropped));
        answer.exclude(self.rest, "samples", "after the last whole period".to_owned());
        answer.exclude(hollow.len(), "lines", format!("relative standard deviation above {MOST_DEVIATION}"));
        (answer.lines, answer.hollow) = (lines, hollow);
        let settled = transient(&y)?;
        if !settled.is_settled() {
            answer.flags.push(format!(
                "first period kept differs by {:.2} % from the others: transient or drift",
                100.0 * settled.difference_ratio
            ));
        }
        answer.distortion = self.distortion(input, response)?;
        answer.evidence = self.evidence(&[input, &response.output]);
        Ok(answer)
    }

    fn distortion(&self, input: &str, response: &Response) -> Result<Option<Found>, Reason> {
        let Some([from_hz, to_hz]) = self.keys.detection_hz else { return Ok(None) };
        let period_s = self.keys.period_s;
        let inside =
            (from_hz * period_s - OFF_GRID).ceil() as usize..=(to_hz * period_s + OFF_GRID).floor() as usize;
        let mut bins: Vec<usize> = inside.filter(|bin| *bin > 0).chain(self.bins.iter().copied()).collect();
        bins.sort_unstable();
        bins.dedup();
        let (u, _) = self.amplitudes(input, &bins)?;
        let (mut y, _) = self.output(response, &bins)?;
        for period in &mut y {
            for (value, &bin) in period.iter_mut().zip(&bins) {
                *value *= C64::new(0.0, TAU * self.hz(bin)).powi(response.derivative);
            }
        }
        let lines: Vec<(usize, f64, bool)> =
            bins.iter().map(|&bin| (bin, self.hz(bin), self.bins.contains(&bin))).collect();
        find(&lines, &u, &y).map(Some)
    }

    fn evidence(&self, channels: &[&str]) -> Vec<Evidence> {
        let time_s = &self.rows.time_s[self.kept.clone()];
        let (Some(&t0_s), Some(&t1_s)) = (time_s.first(), time_s.last()) else { return Vec::new() };
        let channels = channels.iter().map(|name| format!("{} {name}", self.rows.topic.name)).collect();
        vec![Evidence::new(channels, [t0_s, t1_s])]
    }
}

/// Bins of the excited lines.
fn bins(keys: &Record) -> Result<Vec<usize>, Reason> {
    let [from_hz, to_hz] = keys.lines_hz;
    let whole = |what: &'static str, hz: f64| -> Result<usize, Reason> {
        let bin = hz * keys.period_s;
        if (bin - bin.round()).abs() > OFF_GRID || bin.round() < 1.0 {
            return Err(ResponseReason::OffGrid { what, hz, step_hz: keys.period_s.recip(), bin }.into());
        }
        Ok(bin.round() as usize)
    };
    let from = whole("from", from_hz)?;
    let to = whole("to", to_hz)?;
    let step = keys.step_hz.map_or(Ok(1), |hz| whole("step", hz))?;
    Ok((from..=to).step_by(step).collect())
}

/// Refuses an input that does not hold a line.
fn held(name: &str, frequencies_hz: &[f64], u: &[Vec<C64>]) -> Result<(), Reason> {
    let periods = u.len() as f64;
    let mean = |l: usize| u.iter().map(|w| w[l]).sum::<C64>() / periods;
    let largest = (0..frequencies_hz.len()).map(|l| mean(l).norm()).fold(0.0, f64::max);
    for (l, frequency_hz) in frequencies_hz.iter().enumerate() {
        let middle = mean(l);
        let scatter = u.iter().map(|w| (w[l] - middle).norm_sqr()).sum::<f64>();
        let sd = (scatter / (periods * (periods - 1.0))).sqrt();
        let expected = (LEAST_INPUT * largest).max(LEAST_INPUT_SD * sd);
        if middle.norm() <= expected {
            return Err(ResponseReason::WeakInput {
                input: name.to_owned(),
                frequency_hz: *frequency_hz,
                expected,
                found: middle.norm(),
            }
            .into());
        }
    }
    Ok(())
}

/// Departure from the other periods that counts, in parts of the rms.
const DIFFERS: f64 = 1e-6;
/// Share of samples that may differ before the reference counts as not periodic.
const MOST: f64 = 0.01;

/// One period of the reference over and over, and how many samples of the record differed from it.
///
/// `values` are whole periods of `length` samples; each place of the period takes the median over the periods.
///
/// # Errors
/// A sample is not finite, or the reference does not repeat.
fn repeated(name: &str, values: &[f64], length: usize) -> Result<(Vec<f64>, usize), Reason> {
    let periods = values.len() / length;
    if let Some(sample) = values.iter().position(|v| !v.is_finite()) {
        return Err(ResponseReason::SampleNotFinite { channel: name.to_owned(), sample }.into());
    }
    let one: Vec<f64> = (0..length)
        .map(|i| {
            let mut at: Vec<f64> = (0..periods).map(|p| values[p * length + i]).collect();
            at.sort_by(f64::total_cmp);
            at[(periods - 1) / 2]
        })
        .collect();
    let rms = (one.iter().map(|v| v * v).sum::<f64>() / length as f64).sqrt();
    let differing =
        values.iter().enumerate().filter(|(i, v)| (**v - one[i % length]).abs() > DIFFERS * rms).count();
    if differing as f64 > MOST * values.len() as f64 {
        let share = 100.0 * differing as f64 / values.len() as f64;
        return Err(ResponseReason::NotRepeating { reference: name.to_owned(), percent: share }.into());
    }
    Ok((one.iter().copied().cycle().take(values.len()).collect(), differing))
}

/// What the lines that are not excited hold.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found {
    /// Odd distortion over the output at excited lines; `None` without such lines or where it is no more than noise.
    pub(super) odd: Option<Estimate>,
    /// Even distortion over the output at excited lines; `None` as for odd.
    pub(super) even: Option<Estimate>,
    /// Noise of the mean at those lines, the same way, odd and even.
    pub(super) noise_ratio: [f64; 2],
    /// rms amplitude of the output's mean over the excited, odd and even lines, nothing taken off.
    pub(super) rms: [f64; 3],
}

/// `lines`: bin, frequency in Hz, whether it is excited; amplitudes are period × line.
pub(super) fn find(lines: &[(usize, f64, bool)], u: &[Vec<C64>], y: &[Vec<C64>]) -> Result<Found, Reason> {
    let kind = |&(bin, hz, excited): &(usize, f64, bool)| match (excited, bin % 2) {
        (true, _) => (hz, LineKind::Excited),
        (false, 1) => (hz, LineKind::Odd),
        (false, _) => (hz, LineKind::Even),
    };
    let kinds: Vec<(f64, LineKind)> = lines.iter().map(kind).collect();
    let found = fast(&kinds, u, y)?;
    let rms = [LineKind::Excited, LineKind::Odd, LineKind::Even].map(|kind| rms_of(&kinds, y, kind));
    let linear = rms[0] * rms[0];
    let level_of = |kind| level(&found.lines, kind, linear);
    let noise = |kind: LineKind| {
        let own: Vec<f64> = found.lines.iter().filter(|l| l.kind == kind).map(|l| l.variance).collect();
        if own.is_empty() { 0.0 } else { (own.iter().sum::<f64>() / own.len() as f64 / linear).sqrt() }
    };
    Ok(Found {
        odd: level_of(LineKind::Odd),
        even: level_of(LineKind::Even),
        noise_ratio: [noise(LineKind::Odd), noise(LineKind::Even)],
        rms,
    })
}

fn rms_of(kinds: &[(f64, LineKind)], y: &[Vec<C64>], kind: LineKind) -> f64 {
    let own: Vec<f64> = (0..kinds.len())
        .filter(|&l| kinds[l].1 == kind)
        .map(|l| (y.iter().map(|w| w[l]).sum::<C64>() / y.len() as f64).norm_sqr())
        .collect();
    if own.is_empty() { 0.0 } else { (own.iter().sum::<f64>() / own.len() as f64).sqrt() }
}

/// rms of the levels with the noise taken off. The power |level|² of a line of noise v varies by 2v|level|² − v²
/// (non-central χ² of two), which carries over to the root.
fn level(lines: &[DetectionLine], kind: LineKind, linear: f64) -> Option<Estimate> {
    let own: Vec<&DetectionLine> = lines.iter().filter(|l| l.kind == kind).collect();
    let n = own.len() as f64;
    let power = own.iter().map(|l| l.level.norm_sqr() - l.variance).sum::<f64>() / n;
    let spread = |l: &&DetectionLine| {
        let v = l.variance;
        (2.0 * v * l.level.norm_sqr() - v * v).max(v * v)
    };
    let power_u = own.iter().map(spread).sum::<f64>().sqrt() / n;
    let stands = !own.is_empty() && power > 3.0 * power_u && linear > 0.0;
    stands.then(|| {
        let value = (power / linear).sqrt();
        Estimate { value, u: 0.5 * value * power_u / power, dof: f64::INFINITY, n: own.len() }
    })
}
