//! The points: one at rest, one for each axis that creeps.

use std::collections::BTreeMap;

use super::keys::Keys;
use crate::axis::Axes;
use crate::case::{Case, Mode, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::optics::frames;
use crate::kinds::position::positioned::gimbal_for;
use crate::stimulus::{ProfileLimits, Stimulus};

/// Label of the segment that is evaluated.
pub(super) const STILL: &str = "still";
pub(super) const CREEP: &str = "creep";
const SETTLE: &str = "settle";
const SETTLE_S: f64 = 2.0;
/// Way and time of a creep: 50 counts of 26 bit a second.
const CREEP_RAD: f64 = 100e-6;
const CREEP_S: f64 = 20.0;
/// The creep reaches its velocity within this time.
const RISE_S: f64 = 1.0;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    gimbal_for("allan", axes)?;
    let unknown = |name: &str| {
        let known = axes.names().collect::<Vec<_>>().join(", ");
        Diagnostic::new(format!("the rig has no axis `{name}` (it has {known})"))
    };
    let named = keys.creep.iter().map(String::as_str).chain([axis]);
    let mistakes: Vec<Diagnostic> = named.filter(|name| axes.get(name).is_none()).map(unknown).collect();
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    let still = Segment { then: Then::Stop, ..Segment::hold(STILL, Mode::Position, keys.duration_s) };
    let rest = case(keys, axes, axis, STILL.to_owned(), still);
    let pose_rad = pose(keys, axes);
    let pose = |name: &str| pose_rad.get(name).copied().unwrap_or(0.0);
    let creeps =
        keys.creep.iter().map(|name| case(keys, axes, name, format!("{CREEP} {name}"), creep(pose(name))));
    Ok([rest].into_iter().chain(creeps).collect())
}

/// Whether a case is there for its encoder.
pub(super) fn is_creep(case: &Case) -> bool {
    case.segments.last().is_some_and(|segment| segment.label == CREEP)
}

fn pose(keys: &Keys, axes: &Axes) -> BTreeMap<String, f64> {
    frames::poses(axes, [keys.azimuth_rad, keys.elevation_rad])
}

fn case(keys: &Keys, axes: &Axes, axis: &str, point: String, last: Segment) -> Case {
    Case {
        point,
        axis: axis.to_owned(),
        start_pose_rad: pose(keys, axes),
        segments: vec![Segment::hold(SETTLE, Mode::Position, SETTLE_S), last],
        logs_payload_fully: true,
        ..Case::default()
    }
}

fn creep(from_rad: f64) -> Segment {
    let velocity = CREEP_RAD / CREEP_S;
    let limits = ProfileLimits {
        velocity_rad_per_s: velocity,
        acceleration_rad_per_s2: velocity / RISE_S,
        jerk_rad_per_s3: velocity / RISE_S / RISE_S,
    };
    Segment {
        stimulus: Stimulus::Move { target_rad: from_rad + CREEP_RAD, limits },
        then: Then::Stop,
        ..Segment::hold(CREEP, Mode::Position, CREEP_S + 4.0 * RISE_S)
    }
}
