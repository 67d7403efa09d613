//! The way out alone: a current probe on an oscilloscope, against the synchronisation signal.

use std::ops::Range;

use analysis::delay::Step;
use analysis::estimate::Estimate;

use super::OUT;
use super::Value;
use super::response::{Columns, LIMITED};
use super::result::{evidence, measurement, us};
use super::steps::{cut, onsets};
use crate::axis::AxisLimits;
use crate::case::Case;
use crate::log::Window;
use crate::measurement::{PointResult, Reduced};
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

const TOPIC: &str = "/scope";

/// Time from the command to the current, by a probe at the motor.
pub(super) struct WayOut {
    pub(super) delay_s: Value,
}

pub(super) fn analyse(case: &Case, window: &Window, limits: &AxisLimits) -> Result<PointResult, String> {
    let level_v = level_v(case, window, limits)?;
    let rows = window.rows(TOPIC).filter(|rows| !rows.time_s.is_empty());
    let rows = rows.ok_or_else(|| format!("the log has no rows of {TOPIC}: no oscilloscope was read"))?;
    let column = |name: &str| rows.channel(name);
    let [time, current, sync] = [column("time_s")?, column("current_a")?, column("sync_v")?];
    let records = records(time);
    let steps: Vec<Step> = records
        .iter()
        .filter_map(|r| step(&time[r.clone()], &current[r.clone()], &sync[r.clone()]))
        .filter_map(cut)
        .collect();
    if steps.is_empty() {
        return Err(format!(
            "none of {} records shows an edge of sync_v and a step of current_a",
            records.len()
        ));
    }
    let found = onsets(&steps)?;
    // Edge and onset are known to a sample of the oscilloscope.
    let period_s = (time[records[0].end - 1] - time[records[0].start]) / (records[0].len() - 1) as f64;
    let u_s = found.u_s.hypot(period_s / 12.0_f64.sqrt());
    let estimate = Estimate { value: found.delay_s, u: u_s, dof: f64::INFINITY, n: steps.len() };
    let flags = vec![
        format!("time constant {:.1} us at the motor", us(found.time_constant_s)),
        "from the tick that computes the command on: exchange included".to_owned(),
    ];
    let mut out = measurement(OUT, case, level_v, estimate, flags);
    out.evidence = evidence(window, TOPIC, &["time_s", "current_a", "sync_v"]);
    Ok(PointResult {
        point: case.point.clone(),
        measurements: vec![out],
        plots: vec![picture(&steps[0])],
        reduced: Reduced::to(WayOut { delay_s: Value { value: found.delay_s, u: u_s } }),
        ..PointResult::default()
    })
}

/// Height of the steps that the loop sent while the oscilloscope was ready, V; `None` where the log does not hold them.
///
/// # Errors
/// The drive was at a limit meanwhile.
fn level_v(case: &Case, window: &Window, limits: &AxisLimits) -> Result<Option<f64>, String> {
    let Ok(columns) = Columns::new(&case.axis, window) else { return Ok(None) };
    let row = |at_s: f64| columns.time_s.partition_point(|t| *t < at_s);
    let spans: Vec<Range<usize>> =
        window.segments.iter().map(|s| row(s.start_s)..row(s.end_s).max(row(s.start_s))).collect();
    match spans.iter().any(|rows| columns.is_limited(rows.clone(), limits)) {
        true => Err(LIMITED.to_owned()),
        false => Ok(columns.level_v(spans.into_iter(), limits)),
    }
}

/// Records one after the other: time falls where the next one begins.
fn records(time_s: &[f64]) -> Vec<std::ops::Range<usize>> {
    let inner = (1..time_s.len()).filter(|&k| time_s[k] <= time_s[k - 1]);
    let bounds: Vec<usize> = std::iter::once(0).chain(inner).chain([time_s.len()]).collect();
    bounds.windows(2).map(|b| b[0]..b[1]).filter(|r| r.len() > 1).collect()
}

/// The current since the rising edge of the synchronisation signal.
fn step(time_s: &[f64], current_a: &[f64], sync_v: &[f64]) -> Option<Step> {
    let highest = sync_v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = sync_v.iter().copied().fold(f64::INFINITY, f64::min);
    let level = 0.5 * (highest + lowest);
    let high = (1..sync_v.len()).find(|&k| sync_v[k - 1] < level && sync_v[k] >= level)?;
    let edge_s = 0.5 * (time_s[high - 1] + time_s[high]);
    let since_command_s = time_s.iter().map(|t| t - edge_s).collect();
    Some(Step { since_command_s, value: current_a.to_vec() })
}

fn picture(step: &Step) -> Plot {
    let ms: Vec<f64> = step.since_command_s.iter().map(|t| 1e3 * t).collect();
    Plot {
        series: vec![Series::thinned("current probe", Style::Line, [&ms, &step.value], MAX_POINTS)],
        ..Plot::new(
            "probe-step",
            "Current at the motor after a step of the command",
            Scale::linear("time since the command", "ms"),
            Scale::linear("current", "A"),
        )
    }
}
