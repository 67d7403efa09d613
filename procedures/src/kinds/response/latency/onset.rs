//! Transport by onset: steps of torque in the rows of the loop, and steps that the bench hears of itself.

use std::ops::Range;

use analysis::delay::{Band, Onset, OnsetShape, Step, cross_correlation, half_rise, step_onset};
use analysis::estimate::Estimate;
use analysis::uncertainty::{Component, combine, mean_of_repeats, rectangular_u};

use super::conclude::{evidence, measurement, us};
use super::fit::Columns;
use super::plan::STEP_S;
use super::{BY_ONSET, ECHO, JITTER};
use crate::axis::AxisLimits;
use crate::case::Case;
use crate::log::Window;
use crate::measurement::{Exclusion, Measurement, PointResult};
use crate::reason::{Reason, ResponseReason};
use crate::trace::{Plot, Scale, Series, Style};

/// Samples from which the time constant is fitted, about.
const ENOUGH: usize = 1500;
/// Most steps for that.
const MOST_STEPS: usize = 8;
/// The current is looked at until this long after half of its rise; later the loops around it answer.
const AFTER_RISE_S: f64 = 1.5e-3;
/// And for this many samples at the least.
const LEAST_AFTER: usize = 6;

/// Onsets of many steps.
pub(super) struct Onsets {
    pub(super) delay_s: f64,
    /// Standard uncertainty from the scatter of the steps.
    pub(super) u_s: f64,
    pub(super) time_constant_s: f64,
    /// Onset of each step alone.
    pub(super) each_s: Vec<f64>,
    /// What the noise of the current alone scatters an onset by, standard deviation.
    noise_s: f64,
}

/// A variance beyond that of the noise by more of its standard deviations stands out, and its root has the linear uncertainty.
const STANDS_OUT: f64 = 2.0;

impl Onsets {
    /// Standard deviation of the delay between the steps, without what the noise scatters, and its uncertainty: that of a
    /// variance of so many steps, to the side that reaches farther where noise could hide a jitter or be taken for one.
    pub(super) fn jitter(&self) -> Option<Estimate> {
        let n = self.each_s.len();
        let (_, mean) = mean_of_repeats(&self.each_s)?;
        let variance = mean.u * mean.u * n as f64;
        let own = (variance - self.noise_s * self.noise_s).max(0.0);
        let u_variance = variance * (2.0 / mean.dof).sqrt();
        let value = own.sqrt();
        let [up, down] = [(own + u_variance).sqrt() - value, value - (own - u_variance).max(0.0).sqrt()];
        let u = if own > STANDS_OUT * u_variance { 0.5 * u_variance / value } else { up.max(down) };
        Some(Estimate { value, u, dof: mean.dof, n })
    }
}

/// A step from its rest until shortly after its rise; `None` if it has none.
pub(super) fn cut(step: Step) -> Option<Step> {
    let t = &step.since_command_s;
    let y = &step.value;
    let quiet = t.partition_point(|t| *t < 0.0);
    let tail = &y[y.len() - (y.len().saturating_sub(quiet)).div_ceil(5)..];
    if quiet == 0 || tail.is_empty() {
        return None;
    }
    let risen = half_rise(y, quiet, [mean(&y[..quiet]), mean(tail)])?;
    let last = t.partition_point(|at| *at <= t[risen] + AFTER_RISE_S).max(risen + LEAST_AFTER).min(t.len());
    Some(Step { since_command_s: t[..last].to_vec(), value: y[..last].to_vec() })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard deviation of a median over that of a mean, for normal scatter: √(π/2).
const MEDIAN_RATIO: f64 = 1.2533;

/// Fits onset and time constant to steps that are cut: each alone, because a delay that jitters would smear a fit to all.
pub(super) fn onsets(steps: &[Step]) -> Result<Onsets, Reason> {
    let longest = steps.iter().map(|s| s.value.len()).max().ok_or(ResponseReason::NoStep)?;
    let few = (ENOUGH / longest.max(1)).clamp(1, MOST_STEPS);
    let alone = |step: &Step, time_constant_s| {
        step_onset(std::slice::from_ref(step), OnsetShape::Exponential { time_constant_s })
            .map_err(Reason::from)
    };
    let some = steps.iter().step_by(steps.len().div_ceil(few));
    let mut constants: Vec<f64> = some
        .map(|step| {
            alone(step, None)?.time_constant_s.ok_or_else(|| Reason::from(ResponseReason::NoTimeConstant))
        })
        .collect::<Result<_, _>>()?;
    constants.sort_by(f64::total_cmp);
    let time_constant_s = constants[constants.len() / 2];
    let found: Vec<Onset> =
        steps.iter().map(|step| alone(step, Some(time_constant_s))).collect::<Result<_, _>>()?;
    let each_s: Vec<f64> = found.iter().map(|onset| onset.delay_s).collect();
    let mut sorted_s = each_s.clone();
    sorted_s.sort_by(f64::total_cmp);
    let delay_s = sorted_s[sorted_s.len() / 2];
    let u_s = mean_of_repeats(&each_s).map_or(found[0].u_s, |(_, c)| MEDIAN_RATIO * c.u);
    let noise_s = noise_s(steps, &each_s, time_constant_s);
    Ok(Onsets { delay_s, u_s, time_constant_s, each_s, noise_s })
}

/// Standard deviation of the onset of one step by the noise of its rest, all steps together: what white noise leaves of it
/// where rest and height are fitted beside it (inverse Fisher information).
fn noise_s(steps: &[Step], onsets_s: &[f64], time_constant_s: f64) -> f64 {
    let of_step = |(step, &onset_s): (&Step, &f64)| {
        let t = &step.since_command_s;
        let quiet = t.partition_point(|t| *t < 0.0);
        let (rest, noise) = mean_of_repeats(&step.value[..quiet])?;
        let variance = noise.u * noise.u * quiet as f64;
        let height = step.value.last()? - rest;
        let mut information = nalgebra::Matrix3::<f64>::zeros();
        for since_s in t.iter().map(|t| t - onset_s) {
            let left = if since_s > 0.0 { (-since_s / time_constant_s).exp() } else { 1.0 };
            let slope = if since_s > 0.0 { -height / time_constant_s * left } else { 0.0 };
            let row = nalgebra::Vector3::new(slope, 1.0 - left, 1.0);
            information += row * row.transpose();
        }
        Some(variance * information.try_inverse()?[(0, 0)])
    };
    let all: Vec<f64> = steps.iter().zip(onsets_s).filter_map(of_step).collect();
    (all.iter().sum::<f64>() / all.len().max(1) as f64).sqrt()
}

/// Rest before a step.
const BEFORE_S: f64 = 3e-3;
/// A step is looked for until shortly before the next.
const AFTER_S: f64 = 0.9 * STEP_S;
/// Steps and samples share the grid of ticks, so no two steps show another phase: an onset between two samples is known by
/// the shape of the rise alone, to 0.1 of a period (bound; ours).
const GRID_RATIO: f64 = 0.1;
/// Least number of steps.
const LEAST_STEPS: usize = 4;
/// Classes of the histogram.
const CLASSES: usize = 15;

pub(super) fn analyse_steps(
    case: &Case,
    window: &Window,
    limits: &AxisLimits,
) -> Result<PointResult, Reason> {
    let columns = Columns::new(&case.axis, window)?;
    let edges = edges(columns.excitation);
    let rows: Vec<Range<usize>> =
        edges.iter().filter_map(|&row| around(&columns, row, limits.loop_rate_hz)).collect();
    let (limited, rows): (Vec<_>, Vec<_>) =
        rows.into_iter().partition(|rows| columns.is_limited(rows.clone(), limits));
    let level_v = columns.level_v(rows.iter().cloned(), limits);
    let steps: Vec<Step> =
        rows.into_iter().filter_map(|rows| cut(step(&columns, rows, limits.loop_rate_hz))).collect();
    if steps.len() < LEAST_STEPS {
        return Err(ResponseReason::FewSteps {
            shown: steps.len(),
            steps: edges.len(),
            least: LEAST_STEPS,
            limited: limited.len(),
        }
        .into());
    }
    let found = onsets(&steps)?;
    let n = steps.len();
    let grid_s = rectangular_u(GRID_RATIO / limits.loop_rate_hz);
    let jitter = found.jitter().ok_or(ResponseReason::SingleStep)?;
    // What the shape of single rises is off by may differ from step to step.
    let bound = Component { u: grid_s, dof: f64::INFINITY };
    let spread = combine(&[Component { u: jitter.u, dof: jitter.dof }, bound]);
    let jitter = Estimate { u: spread.u, dof: spread.dof, ..jitter };
    let onset = Estimate { value: found.delay_s, u: found.u_s.hypot(grid_s), dof: f64::INFINITY, n };
    let flags = vec![format!(
        "time constant {:.1} us fitted; commands and samples lie on ticks of {:.0} us",
        us(found.time_constant_s),
        us(1.0 / limits.loop_rate_hz)
    )];
    let from = evidence(window, &format!("/{}", case.axis), &["excitation", "current_a"]);
    let with = |name: &str, estimate: Estimate, flags: Vec<String>| Measurement {
        evidence: from.clone(),
        ..measurement(name, case, level_v, estimate, flags)
    };
    let noise =
        vec![format!("scatter due to the noise of the current, {:.1} us, subtracted", us(found.noise_s))];
    let exclusion = |count: usize, reason: String| Exclusion { count, of: "steps".to_owned(), reason };
    let left_out = [
        exclusion(edges.len() - n - limited.len(), "no whole record around them".to_owned()),
        exclusion(limited.len(), ResponseReason::Limited.to_string()),
    ];
    Ok(PointResult {
        point: case.point.clone(),
        measurements: vec![with(BY_ONSET, onset, flags), with(JITTER, jitter, noise)],
        plots: vec![histogram(&found)],
        excluded: left_out.into_iter().filter(|e| e.count > 0).collect(),
        ..PointResult::default()
    })
}

/// Rows in which the excitation changes.
fn edges(excitation: &[f64]) -> Vec<usize> {
    (1..excitation.len()).filter(|&k| excitation[k] != excitation[k - 1]).collect()
}

/// Rows from shortly before an edge, `None` where some are missing.
fn around(columns: &Columns<'_>, edge: usize, rate_hz: f64) -> Option<Range<usize>> {
    let before = before(rate_hz);
    let after = (AFTER_S * rate_hz).round() as usize;
    let rows = edge.checked_sub(before)?..edge + after;
    if rows.end > columns.time_s.len() {
        return None;
    }
    let lasts_s = (rows.len() - 1) as f64 / rate_hz;
    let took_s = columns.time_s[rows.end - 1] - columns.time_s[rows.start];
    ((took_s - lasts_s).abs() <= 0.5 / rate_hz).then_some(rows)
}

/// Rows before an edge.
fn before(rate_hz: f64) -> usize {
    (BEFORE_S * rate_hz).round() as usize
}

/// The current in the rows around an edge.
fn step(columns: &Columns<'_>, rows: Range<usize>, rate_hz: f64) -> Step {
    let command_s = columns.time_s[rows.start + before(rate_hz)];
    // The row of the command itself is still at rest, and so are those before.
    let since_command_s = columns.time_s[rows.clone()].iter().map(|t| t - command_s).collect();
    Step { since_command_s, value: columns.current_a[rows].to_vec() }
}

/// Onsets of the single steps.
fn histogram(found: &Onsets) -> Plot {
    let (low, high) =
        found.each_s.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| (l.min(*s), h.max(*s)));
    let width = ((high - low) / CLASSES as f64).max(1e-7);
    let mut counts = vec![0.0; CLASSES];
    for s in &found.each_s {
        counts[(((s - low) / width) as usize).min(CLASSES - 1)] += 1.0;
    }
    let centres: Vec<f64> = (0..CLASSES).map(|k| us(low + (k as f64 + 0.5) * width)).collect();
    let series =
        Series::new("steps", Style::Histogram, centres, counts).with_u(vec![us(0.5 * width); CLASSES]);
    Plot {
        series: vec![series],
        ..Plot::new(
            "onset-histogram",
            "Onset of the current after a step of the command",
            Scale::linear("onset", "us"),
            Scale::linear("steps", "1"),
        )
    }
}

const TOPIC: &str = "/fsm";
/// Longest delay looked for.
const MOST_LAG_S: f64 = 0.02;
/// Band of the sequence, in parts of the loop rate.
const BAND_RATIO: [f64; 2] = [0.01, 0.4];

pub(super) fn analyse_echo(case: &Case, window: &Window, limits: &AxisLimits) -> Result<PointResult, Reason> {
    let rows = window.rows(TOPIC).filter(|rows| rows.time_s.len() > 1);
    let rows = rows.ok_or(ResponseReason::NoLoopBack { topic: TOPIC })?;
    let column = |name: &str| rows.channel(name);
    let rate_hz = limits.loop_rate_hz;
    let gap = rows.time_s.windows(2).position(|t| (t[1] - t[0] - 1.0 / rate_hz).abs() > 0.1 / rate_hz);
    if let Some(row) = gap {
        return Err(ResponseReason::Gap { topic: TOPIC, row }.into());
    }
    let band = Band { from_hz: BAND_RATIO[0] * rate_hz, to_hz: BAND_RATIO[1] * rate_hz };
    let found = cross_correlation(column("echo_out_v")?, column("echo_in_v")?, rate_hz, band, MOST_LAG_S);
    let found = found?;
    let n = rows.time_s.len();
    // Written and read in the same tick: whatever comes within a tick is seen in the next.
    let u = found.u_s.hypot(1.0 / rate_hz / 12.0_f64.sqrt());
    let estimate = Estimate { value: found.delay_s, u, dof: f64::INFINITY, n };
    let flags = vec![
        format!("{:.3} exchanges, correlation {:.3}", found.delay_s * rate_hz, found.correlation),
        "excluding half a sample of hold".to_owned(),
    ];
    let mut echo = measurement(ECHO, case, None, estimate, flags);
    echo.evidence = evidence(window, TOPIC, &["echo_out_v", "echo_in_v"]);
    Ok(PointResult { point: case.point.clone(), measurements: vec![echo], ..PointResult::default() })
}
