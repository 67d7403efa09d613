//! Points: a run up to speed, and a stop from there.

use super::keys::{Keys, Way};
use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Condition, Fence, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned::limits_of;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{ProfileLimits, Stimulus};

/// Label of the run.
const RUN: &str = "run";
/// Share of the largest acceleration.
const ACCELERATION_SHARE: f64 = 0.8;
/// Time at constant speed before the stop.
const STEADY_S: f64 = 0.3;
/// Beyond the profile's own duration a segment may last this much longer.
const SPARE_S: f64 = 0.5;

/// Each manner in both directions.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let limits = limits_of(axis, axes)?;
    let each =
        keys.ways.iter().flat_map(|&way| [1.0, -1.0].map(|ahead| case(keys, way, ahead, axis, limits, axes)));
    Ok(each.collect())
}

fn case(keys: &Keys, way: Way, ahead: f64, axis: &str, limits: &AxisLimits, axes: &Axes) -> Case {
    let [low, high] = keys.span_rad;
    let (start_rad, target_rad) = if ahead > 0.0 { (low, high) } else { (high, low) };
    let speed = if way == Way::TorqueOff { keys.torque_off_rad_per_s } else { keys.speed_rad_per_s };
    let acceleration_rad_per_s2 = ACCELERATION_SHARE * limits.max_acceleration_rad_per_s2;
    let segment = match way {
        Way::SoftLimit => {
            let profile = ProfileLimits {
                velocity_rad_per_s: speed,
                acceleration_rad_per_s2,
                jerk_rad_per_s3: limits.max_jerk_rad_per_s3,
            };
            let stimulus = Stimulus::Move { target_rad, limits: profile };
            let at_most_s = stimulus.duration_s(start_rad).unwrap_or(0.0) + SPARE_S;
            Segment { stimulus, then: Then::Stop, ..Segment::hold(RUN, Mode::Position, at_most_s) }
        }
        Way::QuickStop | Way::TorqueOff => {
            let stimulus = Stimulus::Cruise {
                from_rad_per_s: 0.0,
                velocity_rad_per_s: ahead * speed,
                acceleration_rad_per_s2,
            };
            let then = if way == Way::QuickStop { Then::QuickStop } else { Then::TorqueOff };
            // The stop begins where the way is over that speeding up and a steady run take.
            let ramp_s = speed / acceleration_rad_per_s2;
            let until = Some(Condition::Displacement { above_rad: speed * (0.5 * ramp_s + STEADY_S) });
            let at_most_s = ramp_s + STEADY_S + SPARE_S;
            Segment { stimulus, then, until, ..Segment::hold(RUN, Mode::Velocity, at_most_s) }
        }
    };
    let rest = |limits: &AxisLimits| {
        let [low, high] = limits.soft_limits_rad;
        0.0_f64.max(low).min(high)
    };
    let mut start_pose_rad = axes.pose(|axis| rest(&axis.limits));
    start_pose_rad.insert(axis.to_owned(), start_rad);
    // Behind the axis the limit is the rig's own: it starts outside its fence.
    let [own_low, own_high] = limits.soft_limits_rad;
    let fence_rad = if ahead > 0.0 { [own_low, keys.fence_rad[1]] } else { [keys.fence_rad[0], own_high] };
    let fence = Fence { bench_rad: [(axis.to_owned(), fence_rad)].into(), ..Fence::default() };
    let value = ahead * speed;
    Case {
        point: format!("{}, velocity={}", way.name(), Q::AngularVelocity.format(value)),
        axis: axis.to_owned(),
        requested: vec![Request { name: "velocity".to_owned(), value, kind: Q::AngularVelocity }],
        start_pose_rad,
        segments: vec![segment],
        fence: (way == Way::SoftLimit).then_some(fence),
        ..Case::default()
    }
}
