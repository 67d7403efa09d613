//! An axis without torque: whether it stays where it is.

use analysis::estimate::Estimate;

use super::held::{column, conditions, evidence, picture, rows_of};
use super::keys::Keys;
use super::plan::{OFF, RELEASED, Way};
use super::{ESTIMATOR, MOVEMENT};
use crate::axis::Axes;
use crate::case::Case;
use crate::log::{EndedBy, Window};
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{PositionReason, Reason};

/// Share of the allowed movement that the second half of the time may add.
const CREEP_SHARE: f64 = 0.1;
/// Fewest rows in which something can be seen to stay.
const LEAST_ROWS: usize = 64;

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    measured(keys, case, window, axes).unwrap_or_else(|reason| {
        let all = [(MOVEMENT, Q::Angle)];
        PointResult::without(case, &all, ESTIMATOR, reason).under(&conditions(case, None))
    })
}

fn measured(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> Result<PointResult, Reason> {
    let limits = axes.limits(&case.axis)?;
    let off = Way::of(case) == Way::Off;
    if off && window.left.iter().any(|left| left.axis == case.axis && left.held) {
        return Err(PositionReason::TorqueKept.into());
    }
    let (rows, [start_s, end_s]) = rows_of(case, window, if off { OFF } else { RELEASED })?;
    let angle = column(rows, "position_rad")?;
    // Without a drive the point ends, and the axis is watched until it stands still for good.
    let range = if off { rows.range(end_s, f64::INFINITY) } else { rows.range(start_s, end_s) };
    let time = &rows.time_s[range.clone()];
    let angle = &angle[range];
    if angle.len() < LEAST_ROWS {
        return Err(PositionReason::TooFewReleased { rows: angle.len(), least: LEAST_ROWS }.into());
    }
    if let Some(k) = angle.iter().position(|a| !a.is_finite()) {
        return Err(PositionReason::ReleasedNoNumber { row: k }.into());
    }
    let from_rad = angle[0];
    let way = |part: &[f64], from: f64| part.iter().map(|a| (a - from).abs()).fold(0.0, f64::max);
    let value = way(angle, from_rad);
    let half = &angle[angle.len() / 2..];
    let caught = window.segments.iter().any(|span| {
        let released = case.segments.get(span.segment).is_some_and(|segment| segment.label == RELEASED);
        released && span.ended_by == EndedBy::Condition
    });
    let stays = value < keys.movement_rad && way(half, half[0]) < CREEP_SHARE * keys.movement_rad;
    let found = if caught {
        format!("SLID: held again after {}", Q::Angle.format(value))
    } else if stays {
        format!("holds itself within {}", Q::Angle.format(keys.movement_rad))
    } else {
        format!("MOVED: {} allowed", Q::Angle.format(keys.movement_rad))
    };
    let remark = format!("{}: the axis does not hold itself without torque ({found}).", case.point);
    let how = if off { "drive off" } else { "zero torque, drive on" };
    let lasted = time[time.len() - 1] - time[0];
    // Two readings of the encoder.
    let u = limits.encoder_quantum_rad / 6_f64.sqrt();
    let estimate = Estimate { value, u, dof: f64::INFINITY, n: angle.len() };
    let measurement = Measurement {
        point: Some(case.point.clone()),
        conditions: conditions(case, Some(from_rad)),
        flags: vec![found, format!("{how}, watched for {lasted:.1} s")],
        evidence: evidence(rows, "position_rad", [time[0], time[time.len() - 1]]),
        ..Measurement::new(MOVEMENT, &case.axis, Q::Angle, Some(estimate), ESTIMATOR)
    };
    Ok(PointResult {
        measurements: vec![measurement],
        plots: vec![picture(case, time, angle, from_rad)],
        remarks: if caught || !stays { vec![remark] } else { Vec::new() },
        ..PointResult::of(case)
    })
}
