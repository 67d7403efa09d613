//! Unbalance and spring of the procedure, from the point that separates them best.

use analysis::estimate::Estimate;
use analysis::gravity::{Gravity, HalfSum, MOST_INFLATION, unbalance_of_poses};
use analysis::uncertainty::{Component, combine};

use super::measurands::{SPRING, STIFFNESS, UNBALANCE};
use super::numbers::Valid;
use crate::axis::AxisLimits;
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;

/// Fastest point that counts (director study, erratum E23): 10 deg/s, with a margin for the last digit.
pub(super) const FASTEST_RAD_PER_S: f64 = 10.001 * std::f64::consts::PI / 180.0;
/// Whole cogging periods that a point needs.
const LEAST_PERIODS: usize = 6;
/// Estimators and versions.
const ESTIMATOR: &str = "gravity-spring/1";
const POSES_ESTIMATOR: &str = "opposite-poses/1";

/// A point with its fit.
pub(super) struct Chosen<'a, 'b> {
    pub(super) point: &'a Valid<'b>,
    pub(super) half_sum: HalfSum,
    pub(super) fit: Gravity,
}

/// The point at ≤ 10 °/s with the least variance inflation; the slower of equals (to 1 %).
pub(super) fn choose<'a, 'b>(points: &'a [Valid<'b>]) -> Option<Chosen<'a, 'b>> {
    let mut best: Option<Chosen<'a, 'b>> = None;
    for point in points {
        let slow = point.velocity_rad_per_s.is_some_and(|v| v <= FASTEST_RAD_PER_S * 1.05)
            && point.requested("velocity").is_some_and(|v| v <= FASTEST_RAD_PER_S);
        let half_sum = point.half_sum();
        if !slow || point.kind != Q::Torque || half_sum.torque_nm.len() < LEAST_PERIODS {
            continue;
        }
        let Ok(fit) = Gravity::new(&half_sum) else { continue };
        let better = |b: &Chosen<'_, '_>| fit.inflation_factor() < 0.99 * b.fit.inflation_factor();
        if best.as_ref().is_none_or(better) {
            best = Some(Chosen { point, half_sum, fit });
        }
    }
    best
}

/// Unbalance, spring torque and stiffness, or why not.
pub(super) fn measure(axis: &str, limits: &AxisLimits, chosen: Option<&Chosen<'_, '_>>) -> Vec<Measurement> {
    let names = [(UNBALANCE, Q::Torque), (SPRING, Q::Torque), (STIFFNESS, Q::Stiffness)];
    let none = |reason: &str| -> Vec<Measurement> {
        names.map(|(name, kind)| Measurement::inconclusive(name, axis, kind, ESTIMATOR, reason)).to_vec()
    };
    let Some(chosen) = chosen else {
        return none(&format!("no valid point at ≤ 10 deg/s with {LEAST_PERIODS} whole cogging periods"));
    };
    let fit = &chosen.fit;
    let inflation = fit.inflation_factor();
    if inflation > MOST_INFLATION {
        let reason = format!(
            "unbalance (cos θ) and spring (θ) cannot be told apart on this span: variance inflation {inflation:.1} above {MOST_INFLATION:.0}"
        );
        return none(&reason).into_iter().map(|m| described(m, chosen)).collect();
    }
    values(axis, limits, chosen, names)
}

/// The three values of a fit that stands.
fn values(
    axis: &str,
    limits: &AxisLimits,
    chosen: &Chosen<'_, '_>,
    names: [(&str, Q); 3],
) -> Vec<Measurement> {
    let fit = &chosen.fit;
    let [unbalance, u_unbalance] = fit.unbalance_nm();
    let [stiffness, u_stiffness] = fit.stiffness_nm_per_rad();
    let [angle, spring, u_spring] = fit.largest_spring(limits.travel_rad);
    let values = [(unbalance.abs(), u_unbalance), (spring, u_spring), (stiffness, u_stiffness)];
    let mut all: Vec<Measurement> = names
        .into_iter()
        .zip(values)
        .map(|((name, kind), (value, u))| {
            let quantum = if kind == Q::Torque { chosen.point.quantum_u } else { 0.0 };
            let spread = combine(&[
                Component { u, dof: fit.dof_count() },
                Component::known(quantum),
                Component::known(chosen.point.scale_u_ratio * value.abs()),
            ]);
            let n = chosen.half_sum.torque_nm.len();
            let estimate = Estimate { value, u: spread.u, dof: spread.dof, n };
            described(Measurement::new(name, axis, kind, Some(estimate), ESTIMATOR), chosen)
        })
        .collect();
    for measurement in &mut all[..2] {
        if measurement.value.is_some_and(|value| value <= 2.0 * measurement.u) {
            measurement.flags.push("zero within U".to_owned());
        }
    }
    all[1].flags.push(format!("largest at {}", Q::Angle.format(angle)));
    all
}

/// Unbalance from two opposite poses at the same velocity, if there are any.
pub(super) fn measure_poses(axis: &str, points: &[Valid<'_>]) -> Option<Measurement> {
    let turned = |p: &&Valid<'_>| p.requested("pose").is_some_and(|pose| pose != 0.0);
    let slow = |p: &&Valid<'_>| p.requested("velocity").is_some_and(|v| v <= FASTEST_RAD_PER_S);
    let opposite = points.iter().filter(slow).find(turned)?;
    let velocity = opposite.requested("velocity");
    let pose =
        points.iter().find(|p| p.requested("velocity") == velocity && p.requested("pose") == Some(0.0))?;
    let (mut here, mut there) = (pose.half_sum(), opposite.half_sum());
    let periods = here.torque_nm.len().min(there.torque_nm.len());
    for sum in [&mut here, &mut there] {
        // Both spans are cut to as many periods about their middle.
        let skip = (sum.torque_nm.len() - periods) / 2;
        for column in [&mut sum.angle_rad, &mut sum.cosine_ratio, &mut sum.torque_nm] {
            column.drain(..skip);
            column.truncate(periods);
        }
    }
    let [value, u, dof] = unbalance_of_poses(&here, &there).ok()?;
    let spread = combine(&[
        Component { u, dof },
        Component::known(pose.quantum_u),
        Component::known(pose.scale_u_ratio * value.abs()),
    ]);
    let estimate = Estimate { value: value.abs(), u: spread.u, dof: spread.dof, n: 2 * periods };
    let mut all = Measurement::new(UNBALANCE, axis, Q::Torque, Some(estimate), POSES_ESTIMATOR);
    all.conditions = pose.conditions.iter().filter(|c| c.name == "velocity").cloned().collect();
    all.evidence = pose.evidence.iter().chain(opposite.evidence).cloned().collect();
    all.flags.push("half the difference of two opposite poses".to_owned());
    Some(all)
}

fn described(mut measurement: Measurement, chosen: &Chosen<'_, '_>) -> Measurement {
    measurement.point = Some(chosen.point.name.to_owned());
    measurement.conditions = chosen.point.conditions.to_vec();
    measurement.evidence = chosen.point.evidence.to_vec();
    measurement.flags.push(format!("variance inflation {:.1}", chosen.fit.inflation_factor()));
    measurement
}
