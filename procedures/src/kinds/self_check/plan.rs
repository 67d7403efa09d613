//! One point, in which nothing moves.

use super::keys::Keys;
use crate::axis::Axes;
use crate::case::{Case, Mode, Segment, Then};
use crate::diagnostic::Diagnostic;

/// Label of the stretch that is evaluated.
pub(super) const REST: &str = "rest";
/// An axis whose drive was just enabled may still sag under its load.
const SETTLE_S: f64 = 1.5;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    if axes.get(axis).is_none() {
        let known = axes.names().collect::<Vec<_>>().join(", ");
        return Err(vec![Diagnostic::new(format!("the rig has no axis `{axis}` (it has {known})"))]);
    }
    let pose = |name: &str| match name {
        "az" => keys.azimuth_rad,
        "el" => keys.elevation_rad,
        _ => 0.0,
    };
    let rest = Segment { then: Then::Stop, ..Segment::hold(REST, Mode::Torque, keys.duration_s) };
    Ok(vec![Case {
        point: REST.to_owned(),
        axis: axis.to_owned(),
        start_pose_rad: axes.names().map(|name| (name.to_owned(), pose(name))).collect(),
        segments: vec![Segment::hold("settle", Mode::Torque, SETTLE_S), rest],
        open_loop: true,
        logs_payload_fully: true,
        ..Case::default()
    }])
}
