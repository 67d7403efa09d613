//! The points of a mirror impedance procedure: the gimbal holds, the analyser sweeps one axis of the mirror.

use super::keys::Keys;
use crate::axis::Axes;
use crate::case::{Case, Mode, Request, Segment};
use crate::device::Task;
use crate::diagnostic::Diagnostic;
use crate::kinds::optics::frames;
use crate::quantity::QuantityKind as Q;

/// Label of the sweep.
pub(super) const SWEEP: &str = "sweep";
/// Condition of a point.
pub(super) const LEVEL: &str = "level";
/// Label of the rest before it.
const SETTLE: &str = "settle";
const SETTLE_S: f64 = 0.25;

/// One point an axis of the mirror.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    frames::check_axes("fsm-impedance", axis, axes)?;
    let case = |mirror_axis: &str| {
        let task = Task::Impedance {
            axis: mirror_axis.to_owned(),
            level_v_ptp: keys.level_v,
            from_hz: keys.range_hz[0],
            to_hz: keys.range_hz[1],
            points: keys.points,
        };
        let sweep = Segment { task: Some(task), ..Segment::hold(SWEEP, Mode::Position, keys.at_most_s) };
        Case {
            point: format!("{mirror_axis} impedance"),
            axis: axis.to_owned(),
            requested: vec![Request { name: LEVEL.to_owned(), value: keys.level_v, kind: Q::Voltage }],
            start_pose_rad: frames::poses(axes, [keys.azimuth_rad, keys.elevation_rad]),
            segments: vec![Segment::hold(SETTLE, Mode::Position, SETTLE_S), sweep],
            ..Case::default()
        }
    };
    Ok(keys.mirror_axes.iter().map(|(name, _)| case(name)).collect())
}

/// Axis of the mirror that a case sweeps.
pub(super) fn mirror_axis(case: &Case) -> &str {
    let tasks = case.segments.iter().filter_map(|s| s.task.as_ref());
    tasks
        .filter_map(|task| if let Task::Impedance { axis, .. } = task { Some(axis.as_str()) } else { None })
        .next()
        .unwrap_or("")
}
