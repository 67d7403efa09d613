//! Transport by onset: steps of torque in the rows of the loop.

use std::ops::Range;

use analysis::delay::Step;
use analysis::estimate::Estimate;

use super::plan::STEP_S;
use super::response::{Columns, LIMITED};
use super::result::{evidence, measurement, us};
use super::steps::{Onsets, cut, onsets};
use super::{BY_ONSET, JITTER};
use crate::axis::AxisLimits;
use crate::case::Case;
use crate::log::Window;
use crate::measurement::{Exclusion, Measurement, PointResult};
use crate::trace::{Plot, Scale, Series, Style};

/// Rest before a step.
const BEFORE_S: f64 = 3e-3;
/// A step is looked for until shortly before the next.
const AFTER_S: f64 = 0.9 * STEP_S;
/// Steps and samples share the grid of ticks, so no two steps show another phase: an onset between two samples is known by
/// the shape of the rise alone, to 0.1 of a period (bound; estimators.md row 12).
const GRID_RATIO: f64 = 0.1;
/// Least number of steps.
const LEAST_STEPS: usize = 4;
/// Classes of the histogram.
const CLASSES: usize = 15;

pub(super) fn analyse(case: &Case, window: &Window, limits: &AxisLimits) -> Result<PointResult, String> {
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
        return Err(format!(
            "{} of {} steps show in the current, at least {LEAST_STEPS} are needed{}",
            steps.len(),
            edges.len(),
            if limited.is_empty() {
                String::new()
            } else {
                format!("; {} left out, {LIMITED}", limited.len())
            }
        ));
    }
    let found = onsets(&steps)?;
    let jitter_s = found.jitter_s().ok_or("a single step has no spread")?;
    let n = steps.len();
    let dof = (n - 1) as f64;
    let grid_s = GRID_RATIO / limits.loop_rate_hz / 3.0_f64.sqrt();
    let onset = Estimate { value: found.delay_s, u: found.u_s.hypot(grid_s), dof: f64::INFINITY, n };
    let jitter = Estimate { value: jitter_s, u: jitter_s / (2.0 * dof).sqrt(), dof, n };
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
    let noise = vec!["noise of the current included".to_owned()];
    let left_out =
        [(edges.len() - n - limited.len(), "no whole record around them"), (limited.len(), LIMITED)];
    let exclusion = |(count, reason): (usize, &str)| {
        let of = "steps".to_owned();
        let reason = reason.to_owned();
        (count > 0).then_some(Exclusion { count, of, reason })
    };
    Ok(PointResult {
        point: case.point.clone(),
        measurements: vec![with(BY_ONSET, onset, flags), with(JITTER, jitter, noise)],
        plots: vec![histogram(&found)],
        excluded: left_out.into_iter().filter_map(exclusion).collect(),
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
