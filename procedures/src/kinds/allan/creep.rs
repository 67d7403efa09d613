//! The least count of an encoder, from what it shows.

use std::f64::consts::TAU;

use super::plan::CREEP;
use super::{BITS, RESOLUTION};
use crate::analysis::allan::quantum_of;
use crate::axis::Axes;
use crate::case::Case;
use crate::log::{Rows, Window};
use crate::measurement::{Estimate, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

const ESTIMATOR: &str = "least-count/1";
/// Fewest steps that were seen.
const LEAST_STEPS: usize = 50;

pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let found = least_count(case, window, axes);
    let measurement = |name: &str, kind: Q| match &found {
        Ok((step, evidence)) => {
            let turn = |step_rad: f64| (TAU / step_rad).log2();
            let bits = Estimate { value: turn(step.value), u: step.u / step.value / 2.0_f64.ln(), ..*step };
            let estimate = if kind == Q::Count { bits } else { *step };
            let flags = vec![format!("{} steps seen, {:.4} urad the least", step.n, 1e6 * step.value)];
            let from = vec![evidence.clone()];
            Measurement {
                flags,
                evidence: from,
                ..Measurement::new(name, &case.axis, kind, Some(estimate), ESTIMATOR)
            }
        }
        Err(reason) => Measurement::inconclusive(name, &case.axis, kind, ESTIMATOR, reason.clone()),
    };
    let both = [measurement(RESOLUTION, Q::Angle), measurement(BITS, Q::Count)];
    PointResult {
        point: case.point.clone(),
        measurements: both.map(|m| Measurement { point: Some(case.point.clone()), ..m }).into(),
        inconclusive: found.as_ref().err().cloned(),
        ..PointResult::default()
    }
}

fn least_count(case: &Case, window: &Window, axes: &Axes) -> Result<(Estimate, Evidence), String> {
    let topic = format!("/{}", case.axis);
    let rows: &Rows = window.rows(&topic).ok_or_else(|| format!("the log has no topic {topic}"))?;
    // Counts as the drive sends them: the angle of a row may be a mean over several ticks.
    let name = "position_counts";
    let counts = rows.column(name).ok_or_else(|| format!("{topic} has no channel {name}"))?;
    let count_rad = axes.get(&case.axis).map_or(0.0, |limits| limits.encoder_quantum_rad);
    let creep = case.segments.iter().position(|s| s.label == CREEP);
    let span = window.segments.iter().find(|s| Some(s.segment) == creep).ok_or("the creep did not run")?;
    let part = rows.range(span.start_s, span.end_s);
    let angle: Vec<f64> = counts[part].iter().map(|count| count * count_rad).collect();
    let steps = angle.windows(2).filter(|a| a[0] != a[1]).count();
    if steps < LEAST_STEPS {
        return Err(format!(
            "the encoder showed {steps} steps, at least {LEAST_STEPS} are needed: it does not follow"
        ));
    }
    let value = quantum_of(&angle)
        .ok_or("steps of the encoder are no multiples of one count: it is finer than its noise")?;
    // What rounding of the log leaves of a step.
    let size = angle.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    let estimate = Estimate { value, u: 2.0 * f64::EPSILON * size.max(value), dof: f64::INFINITY, n: steps };
    let channels = vec![format!("{topic} {name}")];
    Ok((estimate, Evidence { file: String::new(), channels, t0_s: span.start_s, t1_s: span.end_s }))
}
