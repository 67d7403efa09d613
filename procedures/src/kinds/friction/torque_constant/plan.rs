//! The points: pulled towards growing angle, pulled towards falling angle, driven.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use super::keys::Keys;
use crate::axis::{Axes, AxisLimits};
use crate::case::{Bounds, Case, Condition, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::friction::hysteresis::Strokes;
use crate::kinds::position::positioned::limits_of;
use crate::pull::Pull;
use crate::quantity::QuantityKind as Q;

/// Label of the time before the pull.
pub(super) const ZERO: &str = "zero";
/// Label of the pull.
pub(super) const PULL: &str = "pull";
/// Whole cogging periods that a pull must show; two more are left for its beginning and its end.
pub(super) const LEAST_PERIODS: f64 = 4.0;

const DEGREE: f64 = PI / 180.0;
/// A drive is in operation so long after a point's power-up at the latest, and the gauge is then read this long.
const POWER_UP_S: f64 = 4.0;
const ZERO_S: f64 = 1.5;
/// A pull may take this many times as long as planned.
const PATIENCE: f64 = 2.0;
/// Beyond its way somebody goes on by this until the rope is slack.
const SLACK_RAD: f64 = DEGREE;
/// Beyond that, and above this many times the velocity, the point trips.
const BOUND_RAD: f64 = 3.0 * DEGREE;
const BOUND_RATIO: f64 = 3.0;
/// The driven strokes turn this far outside the pulled ones.
const OUTSIDE_RAD: f64 = 2.0 * DEGREE;
/// Acceleration of the driven strokes at their turns.
const TURN_RAD_PER_S2: f64 = 10.0 * DEGREE;
/// Torque limit that the drive is given while somebody pulls, over expected static friction: it moves nothing, and the noise of
/// the current stays below it.
const LIMIT_RATIO: f64 = 0.04;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let limits = limits_of(axis, axes)?;
    let least = (LEAST_PERIODS + 1.0) * TAU / limits.cogging_orders_per_rev;
    if keys.way_rad < least {
        let message = format!("`way` {} contains too few cogging periods", Q::Angle.format(keys.way_rad));
        return Err(vec![Diagnostic::new(message).help(format!("at least {}", Q::Angle.format(least)))]);
    }
    let half = keys.way_rad / 2.0 + OUTSIDE_RAD;
    let strokes = Strokes {
        velocity_rad_per_s: keys.velocity_rad_per_s,
        span_rad: [keys.pose_rad - half, keys.pose_rad + half],
        cycles: 1,
        acceleration_rad_per_s2: Some(TURN_RAD_PER_S2.min(limits.max_acceleration_rad_per_s2)),
    };
    let mut cases = vec![pulled(keys, 1.0, axis, limits, axes), pulled(keys, -1.0, axis, limits, axes)];
    for driven in strokes.plan(axis, axes)? {
        let start_pose_rad = poses(keys, axis, axes, keys.pose_rad);
        cases.push(Case { point: "driven".to_owned(), start_pose_rad, ..driven });
    }
    Ok(cases)
}

/// Where all axes stand before a point.
fn poses(keys: &Keys, axis: &str, axes: &Axes, own_rad: f64) -> BTreeMap<String, f64> {
    let pose_rad = |name: &str| if name == axis { own_rad } else { keys.other_pose_rad };
    axes.names().map(|name| (name.to_owned(), pose_rad(name))).collect()
}

fn pulled(keys: &Keys, sign: f64, axis: &str, limits: &AxisLimits, axes: &Axes) -> Case {
    let rate = sign * keys.velocity_rad_per_s;
    let begins_s = POWER_UP_S + ZERO_S;
    let lasts_s = PATIENCE * keys.way_rad / keys.velocity_rad_per_s;
    let pull = Segment {
        until: Some(Condition::Displacement { above_rad: keys.way_rad }),
        ..Segment::hold(PULL, Mode::Torque, begins_s + lasts_s)
    };
    let rest = Segment { then: Then::Stop, ..Segment::hold("rest", Mode::Torque, 1.5) };
    let way = if sign > 0.0 { "growing" } else { "falling" };
    Case {
        point: format!("pulled, {way} angle"),
        axis: axis.to_owned(),
        requested: vec![Request { name: "velocity".to_owned(), value: rate, kind: Q::AngularVelocity }],
        start_pose_rad: poses(keys, axis, axes, keys.pose_rad - sign * keys.way_rad / 2.0),
        segments: vec![Segment::hold(ZERO, Mode::Torque, ZERO_S), pull, rest],
        open_loop: true,
        torque_limit_nm: Some(LIMIT_RATIO * limits.expected_static_friction_nm),
        bounds: Some(Bounds {
            displacement_rad: keys.way_rad + SLACK_RAD + BOUND_RAD,
            speed_rad_per_s: BOUND_RATIO * keys.velocity_rad_per_s,
        }),
        pull: Some(Pull {
            rate_rad_per_s: rate,
            begins_s,
            way_rad: keys.way_rad + SLACK_RAD / 2.0,
            at_most_nm: keys.pull_nm,
        }),
        ..Case::default()
    }
}
