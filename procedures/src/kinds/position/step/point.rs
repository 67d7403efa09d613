//! One point: responses of both directions, averaged and read.

use analysis::estimate::Estimate;
use analysis::step::{StepResponse, StepSettings, step_response};

use super::keys::LEAST_REPEATS;
use super::plan::{BACK, STEP, THERE};
use super::{ALL, EXCESS, FINAL, OVERSHOOT, RISE, SETTLING, pictures};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::position::positioned::{self, FLOOR_RAD, Record};
use crate::log::Window;
use crate::measurement::{Measurement, PointResult};
use crate::reason::{PositionReason, Reason};

pub(super) const ESTIMATOR: &str = "step-response/1";
pub(super) const SETTINGS: StepSettings = StepSettings { band_ratio: 0.02, tail_s: 0.5, floor: FLOOR_RAD };
/// The place before a step is the mean over this time.
const BEFORE_S: f64 = 0.2;

/// What the steps of one direction come to.
pub(super) struct Way {
    pub(super) label: &'static str,
    pub(super) time_s: Vec<f64>,
    pub(super) mean_rad: Vec<f64>,
    pub(super) found: StepResponse,
}

pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> Result<PointResult, Reason> {
    let record = Record::new(&case.axis, window)?;
    let height_rad = case.requested(STEP).ok_or(PositionReason::NoHeight)?;
    let ways = [way(THERE, case, window, &record)?, way(BACK, case, window, &record)?];
    let span_s =
        [window.segments.first().map_or(0.0, |s| s.start_s), window.segments.last().map_or(0.0, |s| s.end_s)];
    let evidence = record.evidence(&["position_rad", "position_setpoint_rad"], span_s);
    let conditions = positioned::conditions(case, window, axes);
    let measured = ALL.iter().map(|&(name, kind)| {
        let worst = worst(name, height_rad, &ways);
        let mut conditions = conditions.clone();
        let height = conditions.iter_mut().find(|c| c.name == STEP);
        height.into_iter().for_each(|c| c.achieved = Some(ways[worst.1].found.final_value.abs()));
        Measurement {
            point: Some(case.point.clone()),
            conditions,
            evidence: evidence.clone(),
            flags: flags(name, &ways[worst.1]),
            ..Measurement::new(name, &case.axis, kind, Some(worst.0), ESTIMATOR)
        }
    });
    Ok(PointResult {
        point: case.point.clone(),
        measurements: measured.collect(),
        plots: pictures::of(case, &ways, height_rad),
        ..PointResult::default()
    })
}

fn way(label: &'static str, case: &Case, window: &Window, record: &Record<'_>) -> Result<Way, Reason> {
    let spans = Record::spans(case, window, label);
    if spans.len() < LEAST_REPEATS as usize {
        return Err(PositionReason::TooFewSteps { steps: spans.len(), label, least: LEAST_REPEATS }.into());
    }
    let shortest_s = spans.iter().map(|s| s.end_s - s.start_s).fold(f64::INFINITY, f64::min);
    let rows = record.range(spans[0].start_s, spans[0].end_s);
    let count = rows.len().saturating_sub(2);
    let grid: Vec<f64> = (0..count).map(|k| shortest_s * k as f64 / (count + 1) as f64).collect();
    let mut repeats = Vec::new();
    for span in &spans {
        let before = record
            .mean_rad(span.start_s - BEFORE_S, span.start_s)
            .ok_or(PositionReason::RowsMissingAroundStep)?;
        let places = record
            .places_rad(grid.iter().map(|t| span.start_s + t))
            .ok_or(PositionReason::RowsMissingAroundStep)?;
        repeats.push(places.iter().map(|place| place - before).collect::<Vec<f64>>());
    }
    let targets = |k: usize| match case.segments[k].stimulus {
        crate::stimulus::Stimulus::Step { target_rad } => Some(target_rad),
        _ => None,
    };
    let start = case.start_pose_rad.get(&case.axis).copied().unwrap_or(0.0);
    let there = case.segments.iter().position(|s| s.label == THERE).and_then(targets).unwrap_or(start);
    let height = if label == THERE { there - start } else { start - there };
    let all: Vec<&[f64]> = repeats.iter().map(Vec::as_slice).collect();
    let found = step_response(&grid, &all, height, &SETTINGS)
        .map_err(|error| PositionReason::StepNotRead { label, error })?;
    let n = repeats.len() as f64;
    let mean_rad = (0..count).map(|k| repeats.iter().map(|r| r[k]).sum::<f64>() / n).collect();
    Ok(Way { label, time_s: grid, mean_rad, found })
}

/// The estimate of the worse direction, and which it is.
fn worst(name: &str, height_rad: f64, ways: &[Way; 2]) -> (Estimate, usize) {
    let measurement = |way: &Way| {
        let r = &way.found;
        let (value, u) = match name {
            RISE => (r.rise_s, r.rise_u_s),
            SETTLING => (r.settling_s, r.settling_u_s),
            OVERSHOOT => (r.overshoot, r.overshoot_u),
            EXCESS => (r.overshoot - r.threshold, r.overshoot_u),
            _ => (r.final_value.abs() / height_rad, r.final_u / height_rad),
        };
        let scatters = [OVERSHOOT, EXCESS].contains(&name);
        let dof = if scatters { r.overshoot_dof() } else { f64::INFINITY };
        Estimate { value, u, dof, n: r.repeats }
    };
    let there = measurement(&ways[0]);
    let back = measurement(&ways[1]);
    let bad = |e: &Estimate| if name == FINAL { (e.value - 1.0).abs() } else { e.value };
    if bad(&back) > bad(&there) { (back, 1) } else { (there, 0) }
}

fn flags(name: &str, way: &Way) -> Vec<String> {
    let urad = |rad: f64| format!("{:.2} urad", 1e6 * rad);
    let r = &way.found;
    match name {
        OVERSHOOT | EXCESS => vec![
            format!("steps `{}`", way.label),
            format!(
                "noise {} (1 sigma) at rest; counts as overshoot above {}",
                urad(r.noise),
                urad(r.threshold)
            ),
            format!("largest of a single step {}", urad(r.largest_overshoot)),
        ],
        _ => vec![format!("steps `{}`", way.label)],
    }
}
