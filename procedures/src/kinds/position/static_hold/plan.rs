//! The points: held, released, off, each at its poses.

use super::keys::Keys;
use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Condition, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned::limits_of;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{Profile, ProfileLimits, Stimulus};

/// Label of the segment in which the loop holds the axis.
pub(super) const HELD: &str = "held";
/// Label of the segment without torque.
pub(super) const RELEASED: &str = "released";
/// Label of the last segment before the drive is switched off.
pub(super) const OFF: &str = "off";

/// Every pose is approached from below, from so far away.
const APPROACH_RAD: f64 = std::f64::consts::PI / 180.0;
const APPROACH_RAD_PER_S: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Standing still (safety.md §2), for how long, and the longest wait for it.
const SETTLED: Condition = Condition::Settled { below_rad_per_s: 8.7e-4, for_s: 1.0 };
const SETTLE_S: f64 = 6.0;
/// An axis that was let go is held again for so long.
const ARREST_S: f64 = 0.5;

/// What a point does with the axis once the pose is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// The loop holds the axis.
    Held,
    /// The axis is without torque for a while.
    Released,
    /// The drive is switched off.
    Off,
}

impl Way {
    /// The way that a point was planned for.
    pub(super) fn of(case: &Case) -> Self {
        let all = &case.segments;
        match all {
            _ if all.iter().any(|segment| segment.mode == Mode::Torque) => Self::Released,
            _ if all.iter().any(|segment| segment.then == Then::TorqueOff) => Self::Off,
            _ => Self::Held,
        }
    }
}

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let limits = limits_of(axis, axes)?;
    let each = |poses: &[f64], label, last: fn(&Keys) -> Vec<Segment>| -> Vec<Case> {
        poses.iter().map(|&pose_rad| case(label, pose_rad, axis, limits, axes, last(keys))).collect()
    };
    Ok([
        each(&keys.held_rad, HELD, held),
        each(&keys.released_rad, RELEASED, released),
        each(&keys.off_rad, OFF, off),
    ]
    .concat())
}

fn held(keys: &Keys) -> Vec<Segment> {
    vec![Segment { then: Then::Stop, ..Segment::hold(HELD, Mode::Position, keys.hold_s) }]
}

fn released(keys: &Keys) -> Vec<Segment> {
    let release = Segment {
        until: Some(Condition::Displacement { above_rad: keys.catch_rad }),
        then: Then::Hold,
        ..Segment::hold(RELEASED, Mode::Torque, keys.release_s)
    };
    let arrest = Segment { then: Then::Stop, ..Segment::hold("arrest", Mode::Position, ARREST_S) };
    vec![release, arrest]
}

fn off(_keys: &Keys) -> Vec<Segment> {
    vec![Segment { then: Then::TorqueOff, ..Segment::hold(OFF, Mode::Position, ARREST_S) }]
}

fn case(
    label: &str,
    pose_rad: f64,
    axis: &str,
    limits: &AxisLimits,
    axes: &Axes,
    last: Vec<Segment>,
) -> Case {
    let start_rad = (pose_rad - APPROACH_RAD).max(limits.soft_limits_rad[0]);
    let velocity_rad_per_s = APPROACH_RAD_PER_S.min(limits.max_velocity_rad_per_s);
    let acceleration_rad_per_s2 = (5.0 * velocity_rad_per_s).min(limits.max_acceleration_rad_per_s2);
    let profile = ProfileLimits {
        velocity_rad_per_s,
        acceleration_rad_per_s2,
        jerk_rad_per_s3: (10.0 * acceleration_rad_per_s2).min(limits.max_jerk_rad_per_s3),
    };
    let at_most_s = 1.05 * Profile::new(pose_rad - start_rad, &profile).duration_s() + 0.5;
    let stimulus = Stimulus::Move { target_rad: pose_rad, limits: profile };
    let approach = Segment { stimulus, ..Segment::hold("approach", Mode::Position, at_most_s) };
    let settle = Segment { until: Some(SETTLED), ..Segment::hold("settle", Mode::Position, SETTLE_S) };
    // The other axes rest at zero, or at the nearest angle that their soft limits allow.
    let rest = |a: &AxisLimits| 0.0_f64.max(a.soft_limits_rad[0]).min(a.soft_limits_rad[1]);
    let mut start_pose_rad = axes.pose(|axis| rest(&axis.limits));
    start_pose_rad.insert(axis.to_owned(), start_rad);
    Case {
        point: format!("{label}, pose={}", Q::Angle.format(pose_rad)),
        axis: axis.to_owned(),
        requested: vec![Request { name: "pose".to_owned(), value: pose_rad, kind: Q::Angle }],
        start_pose_rad,
        segments: [approach, settle].into_iter().chain(last).collect(),
        ..Case::default()
    }
}
