//! The points: a target that stands until it is tracked, then moves as it likes; bounds hold the axes.

use super::keys::{Keys, Loops};
use crate::axis::{Axes, Gimbal};
use crate::case::{Bounds, Case, Condition, Mode, Segment, Then, Tracks};
use crate::diagnostic::Diagnostic;
use crate::kinds::optics::frames::poses;
use crate::kinds::position::positioned::{ELEVATION, gimbal_for, outside, request};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{ProfileLimits, Stimulus};
use crate::target::Target;

/// Label of the segment in which the trackers take the target up.
pub(super) const ACQUIRE: &str = "acquire";
/// Label of the one in which the target begins to move.
pub(super) const SETTLE: &str = "settle";
/// Label of the one that is evaluated.
pub(super) const TRACK: &str = "track";

/// From the middle of the course to where the target stands: slower than the bounds of the point.
const APPROACH: ProfileLimits =
    ProfileLimits { velocity_rad_per_s: 0.1, acceleration_rad_per_s2: 0.2, jerk_rad_per_s3: 2.0 };
/// The trackers must have had their target for so long.
const LOCKED_S: f64 = 0.5;
/// Longest wait for that.
const ACQUIRE_S: f64 = 8.0;
/// Power-up, and the rest that ends the approach.
const POWER_UP_S: f64 = 4.0;
/// What the bounds leave beyond half of the span: 3 deg.
const BOUND_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// Ten times the rate of the rail target (0.674 deg/s), and half as much again as the approach.
const BOUND_RAD_PER_S: f64 = 0.15;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let Gimbal { outer, inner } = gimbal_for("track", axes)?;
    if axis != outer.name {
        let message = format!("`track` begins with `axis = \"{}\"`, not `{axis}`", outer.name);
        return Err(vec![Diagnostic::new(message).help("both axes follow the target in every point")]);
    }
    let places = keys.span_rad.iter().filter_map(|&at| outside("azimuth", at, &outer.name, &outer.limits));
    let heights =
        keys.elevations_rad.iter().filter_map(|&at| outside("elevation", at, &inner.name, &inner.limits));
    let mistakes: Vec<Diagnostic> = places.chain(heights).collect();
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    let each = |elevation: f64| keys.loops.iter().map(move |&loops| case(keys, loops, elevation, axis, axes));
    Ok(keys.elevations_rad.iter().flat_map(|&elevation| each(elevation)).collect())
}

/// A point. The outer axis is moved to the target; the inner one follows it, too.
fn case(keys: &Keys, loops: Loops, elevation_rad: f64, axis: &str, axes: &Axes) -> Case {
    let [low, high] = keys.span_rad;
    let middle_rad = 0.5 * (low + high);
    let approach = approach(middle_rad, keys.azimuth_rad);
    let stands_s = POWER_UP_S + approach.at_most_s;
    let mut segments = vec![approach];
    segments.extend(tracked(keys, loops));
    let elevation = Q::Angle.format(elevation_rad);
    Case {
        point: format!("{}, {}, elevation={elevation}", keys.target.word(), loops.name()),
        axis: axis.to_owned(),
        requested: vec![request(ELEVATION, elevation_rad, Q::Angle)],
        start_pose_rad: poses(axes, [middle_rad, elevation_rad]),
        segments,
        bounds: Some(Bounds {
            displacement_rad: 0.5 * (high - low) + BOUND_RAD,
            speed_rad_per_s: BOUND_RAD_PER_S,
        }),
        target: Some(Target { course: keys.target, azimuth_rad: keys.azimuth_rad, elevation_rad, stands_s }),
        // Frames come up to 200 times a second: each must be seen.
        logs_payload_fully: true,
        ..Case::default()
    }
}

fn approach(from_rad: f64, target_rad: f64) -> Segment {
    let stimulus = Stimulus::Move { target_rad, limits: APPROACH };
    let at_most_s = stimulus.duration_s(from_rad).unwrap_or(0.0) + 0.5;
    Segment { stimulus, then: Then::Hold, ..Segment::hold("approach", Mode::Position, at_most_s) }
}

/// Acquisition, the time in which the target sets off, and the record.
fn tracked(keys: &Keys, loops: Loops) -> [Segment; 3] {
    let mode = if loops.coarse() { Mode::Track } else { Mode::Position };
    let off_load = keys.off_load && loops == Loops::Both;
    let tracks = Some(Tracks { others: loops.coarse(), fine: loops.fine(), off_load });
    let segment = |label: &str, at_most_s| Segment { tracks, ..Segment::hold(label, mode, at_most_s) };
    let until = Some(Condition::Locked { for_s: LOCKED_S });
    [
        Segment { until, ..segment(ACQUIRE, ACQUIRE_S) },
        segment(SETTLE, keys.settle_s),
        Segment { then: Then::Stop, ..segment(TRACK, keys.duration_s) },
    ]
}

/// The loops of a planned point.
pub(super) fn loops_of(case: &Case) -> Loops {
    let track = case.segments.iter().find(|s| s.label == TRACK);
    match track.map(|s| (s.mode == Mode::Track, s.is_fine())) {
        Some((true, true)) => Loops::Both,
        Some((false, _)) => Loops::Fine,
        _ => Loops::Coarse,
    }
}
