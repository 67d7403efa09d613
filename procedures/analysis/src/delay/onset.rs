//! Delay from a step command to the first movement.

use super::input::{InputError, check_values};
use super::{DelayError, Includes};

/// Least samples of a repeat before the command, and after it.
const LEAST_SAMPLES: usize = 4;
/// Standard deviations that count as movement.
const THRESHOLD: f64 = 5.0;
/// A ramp is fitted up to this part of the rise.
const RAMP_PART: f64 = 0.7;
/// Time constants tried, ascending by equal factors.
const CONSTANTS: usize = 24;
/// Shrinkings of a golden section.
const SHRINKINGS: usize = 36;

/// One repeat.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Sample times since the command, s: ascending, some before 0. Dithered between the repeats, or nothing is gained.
    pub since_command_s: Vec<f64>,
    /// Samples.
    pub value: Vec<f64>,
}

/// How the signal leaves its rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OnsetShape {
    /// Linearly, as an integrator does. Fitted over the first 70 % of the rise.
    Ramp,
    /// As 1 − exp(−t/T) of a lag.
    Exponential {
        /// T, s; fitted if `None`.
        time_constant_s: Option<f64>,
    },
}

/// Delay to the onset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onset {
    /// Delay, s.
    pub delay_s: f64,
    /// Standard uncertainty of `delay_s`, s: jackknife over the repeats; a sample's width/√12 with one repeat.
    pub u_s: f64,
    /// Repeats less one.
    pub dof: f64,
    /// Time constant that was given or fitted, s.
    pub time_constant_s: Option<f64>,
    /// What a threshold alone would have said (mean over the repeats), s: late by threshold over slope and half a sample.
    pub threshold_s: f64,
    /// What the delay holds.
    pub includes: Includes,
}

/// Fits rest, onset and rise to all repeats at once (samples of dithered repeats interleave) and reads the onset.
///
/// # Errors
/// Repeats that are none, or nothing that moves.
pub fn step_onset(repeats: &[Step], shape: OnsetShape) -> Result<Onset, DelayError> {
    if repeats.is_empty() {
        return Err(InputError::TooFew { found: 0, least: 1 }.into());
    }
    if let OnsetShape::Exponential { time_constant_s: Some(found) } = shape
        && !(found.is_finite() && found > 0.0)
    {
        return Err(
            InputError::Setting { name: "time_constant_s", found, expected: "a positive number" }.into()
        );
    }
    let prepared: Vec<Prepared> =
        repeats.iter().enumerate().map(|(k, r)| Prepared::new(k, r, shape)).collect::<Result<_, _>>()?;
    let all: Vec<&Prepared> = prepared.iter().collect();
    let (delay_s, time_constant_s) = pooled(&all, shape).ok_or(DelayError::NoFit)?;
    let n = prepared.len() as f64;
    let threshold_s = prepared.iter().map(|p| p.threshold_s).sum::<f64>() / n;
    let u_s = if prepared.len() > 1 {
        let without = |k: usize| {
            let rest: Vec<&Prepared> =
                (0..prepared.len()).filter(|i| *i != k).map(|i| &prepared[i]).collect();
            pooled(&rest, shape).map(|(delay, _)| delay)
        };
        let values: Vec<f64> =
            (0..prepared.len()).map(without).collect::<Option<_>>().ok_or(DelayError::NoFit)?;
        let mean = values.iter().sum::<f64>() / n;
        ((n - 1.0) / n * values.iter().map(|v| (v - mean).powi(2)).sum::<f64>()).sqrt()
    } else {
        prepared[0].period_s / 12_f64.sqrt()
    };
    let includes = Includes::TransportToOnset;
    Ok(Onset { delay_s, u_s, dof: n - 1.0, time_constant_s, threshold_s, includes })
}

/// First of two samples from `from` on that are more than half way from the rest to the end of a step.
pub fn half_rise(values: &[f64], from: usize, [rest, end]: [f64; 2]) -> Option<usize> {
    let beyond = |k: usize| (values[k] - rest) / (end - rest) > 0.5;
    (from..values.len().saturating_sub(1)).find(|&k| beyond(k) && beyond(k + 1))
}

/// A repeat from rest 0 to end 1, cut to what is fitted.
struct Prepared {
    time_s: Vec<f64>,
    value: Vec<f64>,
    threshold_s: f64,
    /// First sample of two beyond half of the rise: the step has begun by then, whatever noise met the threshold before.
    half_s: f64,
    period_s: f64,
}

impl Prepared {
    fn new(repeat: usize, step: &Step, shape: OnsetShape) -> Result<Self, DelayError> {
        let t = &step.since_command_s;
        let y = &step.value;
        check_values(t, t.len())?;
        check_values(y, t.len())?;
        if let Some(k) = t.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(InputError::NotAscending { index: k + 1 }.into());
        }
        let quiet = t.partition_point(|t| *t < 0.0);
        if quiet.min(t.len() - quiet) < LEAST_SAMPLES {
            let found = quiet.min(t.len() - quiet);
            return Err(InputError::TooFew { found, least: LEAST_SAMPLES }.into());
        }
        let rest = y[..quiet].iter().sum::<f64>() / quiet as f64;
        let sd = (y[..quiet].iter().map(|v| (v - rest).powi(2)).sum::<f64>() / (quiet - 1) as f64).sqrt();
        let tail = &y[y.len() - (y.len() - quiet).div_ceil(5).max(2)..];
        let rise = tail.iter().sum::<f64>() / tail.len() as f64 - rest;
        let moved = |k: usize| (y[k] - rest) * rise.signum() > (THRESHOLD * sd).max(1e-9 * rise.abs());
        let first = (quiet..t.len() - 1).find(|&k| moved(k) && moved(k + 1) && rise.abs() > THRESHOLD * sd);
        let first = first.ok_or(DelayError::NoOnset { repeat })?;
        let end = match shape {
            OnsetShape::Ramp => (first + 2)
                .max((first..t.len()).find(|&k| (y[k] - rest) / rise > RAMP_PART).unwrap_or(t.len())),
            OnsetShape::Exponential { .. } => t.len(),
        };
        let half = half_rise(y, first, [rest, rest + rise]).unwrap_or(first);
        let value = y[..end.min(t.len())].iter().map(|v| (v - rest) / rise).collect();
        Ok(Self {
            time_s: t[..end.min(t.len())].to_vec(),
            value,
            threshold_s: t[first],
            half_s: t[half],
            period_s: (t[t.len() - 1] - t[0]) / (t.len() - 1) as f64,
        })
    }
}

/// Onset and time constant over all repeats.
fn pooled(repeats: &[&Prepared], shape: OnsetShape) -> Option<(f64, Option<f64>)> {
    let latest = repeats.iter().map(|p| p.threshold_s).fold(f64::NEG_INFINITY, f64::max);
    let period = repeats.iter().map(|p| p.period_s).sum::<f64>() / repeats.len() as f64;
    let half_s = repeats.iter().map(|p| p.half_s).fold(f64::NEG_INFINITY, f64::max);
    let range = [latest - 6.0 * period, half_s.max(latest + period)];
    let best = |rise: &dyn Fn(f64) -> f64| least(range, 60, &|onset| cost(repeats, onset, rise));
    match shape {
        OnsetShape::Ramp => best(&|t| t / period).map(|(onset, _)| (onset, None)),
        OnsetShape::Exponential { time_constant_s: Some(lag) } => {
            best(&|t| 1.0 - (-t / lag).exp()).map(|(onset, _)| (onset, Some(lag)))
        }
        OnsetShape::Exponential { time_constant_s: None } => {
            let longest = repeats.iter().map(|p| p.time_s[p.time_s.len() - 1] - latest).fold(0.0, f64::max);
            let range = [(0.05 * period).ln(), longest.max(period).ln()];
            let of =
                |ln: f64| best(&|t: f64| 1.0 - (-t / ln.exp()).exp()).map_or(f64::INFINITY, |(_, cost)| cost);
            let (ln, _) = least(range, CONSTANTS, &of)?;
            best(&|t| 1.0 - (-t / ln.exp()).exp()).map(|(onset, _)| (onset, Some(ln.exp())))
        }
    }
}

/// What remains after the best rest and amplitude for an onset.
fn cost(repeats: &[&Prepared], onset_s: f64, rise: &dyn Fn(f64) -> f64) -> f64 {
    let [mut n, mut x1, mut x2, mut y1, mut y2, mut xy] = [0.0; 6];
    for (t, y) in repeats.iter().flat_map(|p| p.time_s.iter().zip(&p.value)) {
        let x = if *t > onset_s { rise(t - onset_s) } else { 0.0 };
        n += 1.0;
        x1 += x;
        x2 += x * x;
        y1 += y;
        y2 += y * y;
        xy += x * y;
    }
    let xx = x2 - x1 * x1 / n;
    let yy = y2 - y1 * y1 / n;
    let both = xy - x1 * y1 / n;
    if xx > 0.0 && both > 0.0 { yy - both * both / xx } else { yy }
}

/// Where a function is least, and how little: grid, then golden section.
fn least([from, to]: [f64; 2], count: usize, of: &dyn Fn(f64) -> f64) -> Option<(f64, f64)> {
    let time = |i: usize| from + (to - from) * i as f64 / count as f64;
    let values: Vec<f64> = (0..=count).map(|i| of(time(i))).collect();
    let best = (0..=count).min_by(|a, b| values[*a].total_cmp(&values[*b]))?;
    let mut low = time(best.saturating_sub(1));
    let mut high = time((best + 1).min(count));
    let ratio = 0.5 * (5_f64.sqrt() - 1.0);
    for _ in 0..SHRINKINGS {
        let left = high - ratio * (high - low);
        let right = low + ratio * (high - low);
        if of(left) < of(right) { high = right } else { low = left }
    }
    let middle = 0.5 * (low + high);
    let found = of(middle);
    found.is_finite().then_some((middle, found))
}
