//! One point: friction with its pedigree, and what `conclude` needs of half-sum and cogging.

use analysis::cogging::Spectrum;
use analysis::estimate::Estimate;
use analysis::gravity::HalfSum;
use analysis::uncertainty::{Component, combine};

use super::measurands::{FRICTION, FRICTION_CURRENT};
use super::record::Record;
use super::sweep::Sweep;
use super::{dynamic, numbers, pictures, plan, static_map};
use crate::axis::Axes;
use crate::case::Case;
use crate::log::Window;
use crate::measurement::{Condition, Evidence, Exclusion, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

/// Estimator and version of friction.
const ESTIMATOR: &str = "hysteresis-friction/1";

/// What the rows of one point say, in torque or current.
#[derive(Debug, Default)]
pub(super) struct Finding {
    pub(super) achieved_rad_per_s: Option<f64>,
    /// Type A only; or why there is none.
    pub(super) friction: Option<Estimate>,
    pub(super) trouble: Option<String>,
    pub(super) half_sum: HalfSum,
    pub(super) spectrum: Option<Spectrum>,
    /// Whether the spectrum is that of a static map.
    pub(super) static_map: bool,
    /// Whether only one direction was recorded.
    pub(super) one_sided: bool,
    /// What the drive's quantum leaves in a mean.
    pub(super) quantum_u: f64,
    /// Largest relative error of J·α at the cogging order.
    pub(super) gain_error_ratio: f64,
    /// Half the sum of the means of both directions.
    pub(super) offset: Option<f64>,
    /// Angle, effort of each direction, for the picture.
    pub(super) forward: [Vec<f64>; 2],
    pub(super) reverse: [Vec<f64>; 2],
    pub(super) excluded: Vec<Exclusion>,
    pub(super) flags: Vec<String>,
    pub(super) evidence: Vec<Evidence>,
}

/// Analyses one point.
pub(super) fn analyse(_sweep: &Sweep, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    let Some(limits) = axes.get(&case.axis) else {
        result.inconclusive = Some(format!("the plan has no axis {}", case.axis));
        return result;
    };
    let record = match Record::new(&case.axis, window, limits) {
        Ok(record) => record,
        Err(reason) => {
            let mut none = Measurement::inconclusive(FRICTION, &case.axis, Q::Torque, ESTIMATOR, &reason);
            none.point = Some(case.point.clone());
            none.conditions = conditions(case, None);
            result.measurements.push(none);
            result.inconclusive = Some(reason);
            return result;
        }
    };
    let strokes = case.segments.iter().any(|s| s.label == plan::STROKES);
    let finding = if strokes {
        dynamic::find(case, window, &record, limits)
    } else {
        static_map::find(case, window, &record, limits)
    };
    result.measurements.push(friction(case, &record, &finding));
    result.excluded.clone_from(&finding.excluded);
    result.inconclusive =
        finding.trouble.clone().filter(|_| finding.friction.is_none() && !finding.one_sided);
    result.plots.extend(pictures::hysteresis_loop(case, record.kind, &finding));
    numbers::pack(&mut result.numbers, &record, &finding);
    result
}

/// Friction of the point: type A with quantum and torque constant.
fn friction(case: &Case, record: &Record<'_>, finding: &Finding) -> Measurement {
    let name = if record.kind == Q::Torque { FRICTION } else { FRICTION_CURRENT };
    let mut measurement = match finding.friction {
        Some(estimate) => {
            let spread = combine(&[
                own_spread(finding, &estimate),
                Component::known(record.scale_u_ratio * estimate.value.abs()),
            ]);
            let estimate = Estimate { u: spread.u, dof: spread.dof, ..estimate };
            Measurement::new(name, &case.axis, record.kind, Some(estimate), ESTIMATOR)
        }
        None => {
            let reason = finding.trouble.clone().unwrap_or_else(|| "no steady sliding".to_owned());
            Measurement::inconclusive(name, &case.axis, record.kind, ESTIMATOR, reason)
        }
    };
    measurement.point = Some(case.point.clone());
    measurement.conditions = conditions(case, finding.achieved_rad_per_s);
    measurement.flags.clone_from(&finding.flags);
    measurement.excluded.clone_from(&finding.excluded);
    measurement.evidence.clone_from(&finding.evidence);
    measurement
}

/// Spread of a point without what all points share.
pub(super) fn own_spread(finding: &Finding, estimate: &Estimate) -> Component {
    combine(&[Component { u: estimate.u, dof: estimate.dof }, Component::known(finding.quantum_u)])
}

/// What was asked for, with the velocity that was reached.
fn conditions(case: &Case, achieved_rad_per_s: Option<f64>) -> Vec<Condition> {
    case.requested
        .iter()
        .map(|request| Condition {
            name: request.name.clone(),
            requested: request.value,
            achieved: if request.name == "velocity" { achieved_rad_per_s } else { Some(request.value) },
            kind: request.kind,
        })
        .collect()
}
