//! One point, in which nothing moves.

use super::keys::Keys;
use crate::axis::Axes;
use crate::case::{Case, Mode, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::optics::frames;
use crate::kinds::position::positioned::limits_of;

/// Label of the stretch that is evaluated.
pub(super) const REST: &str = "rest";
/// An axis whose drive was just enabled may still sag under its load.
const SETTLE_S: f64 = 1.5;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    limits_of(axis, axes)?;
    let rest = Segment { then: Then::Stop, ..Segment::hold(REST, Mode::Torque, keys.duration_s) };
    Ok(vec![Case {
        point: REST.to_owned(),
        axis: axis.to_owned(),
        start_pose_rad: frames::poses(axes, [keys.azimuth_rad, keys.elevation_rad]),
        segments: vec![Segment::hold("settle", Mode::Torque, SETTLE_S), rest],
        open_loop: true,
        logs_payload_fully: true,
        ..Case::default()
    }])
}
