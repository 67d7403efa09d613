//! Whether friction is the same in both directions and at all angles, of a point that ran.

use analysis::angle_map::period_means;
use analysis::estimate::Estimate;
use analysis::peaks::deviation_by_median;
use analysis::uncertainty::{Component, combine};

use super::point::Finding;
use super::{DIRECTIONS, UNEVENNESS};
use crate::axis::TorqueScale;
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;

const ESTIMATOR: &str = "hysteresis-evenness/1";

/// Cogging periods below which a point says nothing of how even friction is over the angle: their scatter would rest on fewer than
/// five degrees of freedom.
const LEAST_PERIODS: usize = 6;

/// Difference by direction and unevenness over the angle, under the conditions of the point's friction, or with the reason
/// why that has no value; nothing of a static map and of currents, and no unevenness of a span of a few periods.
pub(super) fn measure(finding: &Finding, friction: &Measurement, scale: TorqueScale) -> Vec<Measurement> {
    if finding.static_map || friction.kind != Q::Torque {
        return Vec::new();
    }
    let one = |name: &str, kind: Q, found: Option<Estimate>| {
        let mut m = Measurement {
            point: friction.point.clone(),
            conditions: friction.conditions.clone(),
            excluded: friction.excluded.clone(),
            evidence: friction.evidence.clone(),
            inconclusive: friction.inconclusive.clone(),
            ..Measurement::new(name, &friction.axis, kind, found, ESTIMATOR)
        };
        friction.angles_rad.into_iter().for_each(|angles_rad| m.set_angles(angles_rad));
        m
    };
    let known = finding.friction.as_ref();
    let mut all =
        vec![one(DIRECTIONS, Q::Torque, known.map(|friction| difference(finding, friction, scale)))];
    if known.is_none() || finding.half_sum.torque_nm.len() >= LEAST_PERIODS {
        all.push(one(UNEVENNESS, Q::Ratio, known.map(|friction| unevenness(finding, friction))));
    }
    all
}

/// Half the sum of both directions has the scatter of half their difference.
fn difference(finding: &Finding, friction: &Estimate, scale: TorqueScale) -> Estimate {
    let halves = &finding.half_sum.torque_nm;
    let value = (halves.iter().sum::<f64>() / halves.len().max(1) as f64).abs();
    let spread = combine(&[
        Component { u: friction.u, dof: friction.dof },
        Component::known(finding.quantum_u),
        scale.of_torque(value),
    ]);
    Estimate { value, u: spread.u, dof: spread.dof, n: friction.n }
}

/// The largest mean over one cogging period. Its uncertainty is the scatter of the periods, of which half lie within the middle
/// half of them: what a spot adds is no scatter.
fn unevenness(finding: &Finding, friction: &Estimate) -> Estimate {
    let periods = finding.half_sum.torque_nm.len().max(1);
    let bins = finding.forward.effort.len() / periods;
    let both = finding.forward.effort.iter().zip(&finding.reverse.effort);
    let local: Vec<f64> = both.map(|(forward, reverse)| 0.5 * (forward - reverse)).collect();
    let means = period_means(&local, bins.max(1));
    let largest = means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let scatter = deviation_by_median(&means);
    let dof = (periods as f64 - 1.0).max(1.0);
    Estimate { value: largest / friction.value - 1.0, u: scatter / friction.value, dof, n: friction.n }
}
