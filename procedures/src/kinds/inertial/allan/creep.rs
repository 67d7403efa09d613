//! The least count of an encoder, from what it shows.

use std::f64::consts::TAU;

use analysis::allan::quantum_of;
use analysis::estimate::Estimate;

use super::keys::CREEP;
use super::{BITS, RESOLUTION};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::inertial::nearest;
use crate::log::{Rows, Window};
use crate::measurement::{Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{InertialReason, Reason};

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
            let flags = vec![format!("{} steps seen, smallest {:.4} urad", step.n, 1e6 * step.value)];
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

fn least_count(case: &Case, window: &Window, axes: &Axes) -> Result<(Estimate, Evidence), Reason> {
    let topic = format!("/{}", case.axis);
    let rows: &Rows = window.topic(&topic)?;
    let counts = rows.channel("position_counts")?;
    let limits = axes.limits(&case.axis)?;
    let span = window.segment(case, CREEP)?;
    let part = rows.range(span.start_s, span.end_s);
    let mut shown = vec![0.0];
    for pair in counts[part].windows(2) {
        shown.push(shown[shown.len() - 1] + nearest(pair[1] - pair[0], limits.encoder_quantum_rad));
    }
    let steps = shown.windows(2).filter(|a| a[0] != a[1]).count();
    if steps < LEAST_STEPS {
        return Err(InertialReason::FewSteps { steps, least: LEAST_STEPS }.into());
    }
    let count = quantum_of(&shown);
    let count = count.ok_or(InertialReason::NoQuantum)?;
    // Whole counts of a known angle: exact.
    let estimate =
        Estimate { value: count * limits.encoder_quantum_rad, u: 0.0, dof: f64::INFINITY, n: steps };
    let channels = vec![format!("{topic} position_counts")];
    Ok((estimate, Evidence::new(channels, [span.start_s, span.end_s])))
}
