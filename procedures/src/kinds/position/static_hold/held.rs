//! An axis that its loop holds: noise and drift of position and torque.

use analysis::estimate::Estimate;
use analysis::stillness::stillness;
use analysis::uncertainty::{Component, combine};

use super::plan::HELD;
use super::{DRIFT, ESTIMATOR, MEASURANDS, MOVEMENT, NOISE, TORQUE, TORQUE_NOISE};
use crate::axis::Axes;
use crate::case::Case;
use crate::log::{Rows, Window};
use crate::measurement::{Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{PositionReason, Reason};
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> PointResult {
    match measured(case, window, axes) {
        Ok((measurements, plot)) => PointResult { measurements, plots: vec![plot], ..PointResult::of(case) },
        Err(reason) => {
            let own: Vec<_> =
                MEASURANDS.iter().filter(|m| m.name != MOVEMENT).map(|m| (m.name, m.kind)).collect();
            PointResult::without(case, &own, ESTIMATOR, reason).under(&conditions(case, None))
        }
    }
}

/// The pose, asked for and reached.
pub(super) fn conditions(case: &Case, achieved: Option<f64>) -> Vec<Condition> {
    Condition::reached(case, |_| achieved)
}

/// Rows of the axis, and when a segment began and ended.
pub(super) fn rows_of<'a>(
    case: &Case,
    window: &'a Window,
    label: &str,
) -> Result<(&'a Rows, [f64; 2]), Reason> {
    let topic = format!("/{}", case.axis);
    let rows = window.topic(&topic)?;
    let span = window.segment(case, label)?;
    let settling = |s: &&crate::log::SegmentSpan| {
        case.segments.get(s.segment).is_some_and(|segment| segment.label == "settle")
    };
    let settled = window.segments.iter().find(settling);
    if settled.is_none_or(|s| s.ended_by != crate::log::EndedBy::Condition) {
        return Err(PositionReason::NotAtRest.into());
    }
    Ok((rows, [span.start_s, span.end_s]))
}

/// A column of an axis' rows.
pub(super) fn column<'a>(rows: &'a Rows, name: &str) -> Result<&'a [f64], Reason> {
    Ok(rows.channel(name)?)
}

fn measured(case: &Case, window: &Window, axes: &Axes) -> Result<(Vec<Measurement>, Plot), Reason> {
    let limits = axes.limits(&case.axis)?;
    let constant = limits.torque_constant().ok_or(PositionReason::NoTorqueConstant)?;
    let (rows, [start_s, end_s]) = rows_of(case, window, HELD)?;
    let range = rows.range(start_s, end_s);
    let time = &rows.time_s[range.clone()];
    let angle = &column(rows, "position_rad")?[range.clone()];
    let torque: Vec<f64> = column(rows, "current_a")?[range].iter().map(|a| constant * a).collect();
    let position = stillness(time, angle).map_err(PositionReason::PositionAtRest)?;
    let effort = stillness(time, &torque).map_err(PositionReason::TorqueAtRest)?;
    let uniform = |quantum: f64| Component::known(quantum / 12_f64.sqrt());
    let scale = limits.torque_scale();
    let fine = uniform(limits.encoder_quantum_rad);
    let coarse = uniform(limits.torque_ratio() * limits.torque_quantum_nm);
    let reached = position.mean.value;
    let measurement = |name: &str, kind, estimate: Estimate, known: &[Component]| {
        let own = Component { u: estimate.u, dof: estimate.dof };
        let spread = combine(&[&[own], known].concat());
        let estimate = Estimate { u: spread.u, dof: spread.dof, ..estimate };
        let channel = if kind == Q::Torque { "current_a" } else { "position_rad" };
        Measurement {
            point: Some(case.point.clone()),
            conditions: conditions(case, Some(reached)),
            evidence: evidence(rows, channel, [start_s, end_s]),
            ..Measurement::new(name, &case.axis, kind, Some(estimate), ESTIMATOR)
        }
    };
    let mean = effort.mean.value;
    let all = vec![
        measurement(NOISE, Q::Angle, position.noise, &[fine]),
        measurement(DRIFT, Q::AngularVelocity, position.drift_per_s, &[]),
        measurement(TORQUE, Q::Torque, effort.mean, &[coarse, scale.of_torque(mean)]),
        measurement(TORQUE_NOISE, Q::Torque, effort.noise, &[scale.share(effort.noise.value, mean)]),
    ];
    Ok((all, picture(case, time, angle, reached)))
}

/// Where the numbers come from.
pub(super) fn evidence(rows: &Rows, channel: &str, [t0_s, t1_s]: [f64; 2]) -> Vec<Evidence> {
    let channels = vec![format!("{} {channel}", rows.topic.name)];
    vec![Evidence::new(channels, [t0_s, t1_s])]
}

/// Position less the place it is about, over time.
pub(super) fn picture(case: &Case, time_s: &[f64], angle_rad: &[f64], about_rad: f64) -> Plot {
    const URAD: f64 = 1e6;
    let start_s = time_s.first().copied().unwrap_or(0.0);
    let since: Vec<f64> = time_s.iter().map(|t| t - start_s).collect();
    let off: Vec<f64> = angle_rad.iter().map(|a| URAD * (a - about_rad)).collect();
    let plot = Plot::new(
        case.point.replace([' ', ',', '=', '/'], "-"),
        format!("Position: {}", case.point),
        Scale::linear("time", "s"),
        Scale::linear("position", "urad"),
    );
    Plot { series: vec![Series::thinned(case.axis.clone(), Style::Line, [&since, &off], MAX_POINTS)], ..plot }
}
