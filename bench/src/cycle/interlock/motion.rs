//! Interlocks on how the axis moves, and on whether it could still be stopped.

use super::{Interlock, View, above, below};
use crate::model::stopping::REST_RAD_PER_S;

/// An axis that does the opposite of what its torque says is a runaway after this time (safety.md: runaway).
const RUNAWAY_S: f64 = 0.020;
/// Outward slower than this, two counts per millisecond, nothing moves out of a soft limit.
const CREEP_RAD_PER_S: f64 = 2e-4;

pub(crate) const RUNAWAY: Interlock = Interlock {
    name: "runaway",
    doc: "For 20 ms the axis has become faster against a torque that is clearly above breakaway: a sign is wrong.",
    unit: "s",
    shared: false,
    steerable: false,
    check: |v| above(v.memory.runaway_s(), RUNAWAY_S),
};

pub(crate) const BOUNDS_OF_DISPLACEMENT: Interlock = Interlock {
    name: "bounds of displacement",
    doc: "The axis is farther from where it was enabled than this point allows.",
    unit: "rad",
    shared: false,
    // What goes where it was not sent is not known to obey.
    steerable: false,
    check: |v| above(v.memory.displacement_rad().abs(), v.bounds?.displacement_rad),
};

pub(crate) const BOUNDS_OF_SPEED: Interlock = Interlock {
    name: "bounds of speed",
    doc: "The axis turns faster than this point allows.",
    unit: "rad/s",
    shared: false,
    steerable: false,
    check: |v| above(v.actuals.velocity_rad_per_s.abs(), v.bounds?.speed_rad_per_s),
};

pub(crate) const POSITION: Interlock = Interlock {
    name: "position",
    doc: "The axis is outside its soft limits and not on its way back.",
    unit: "rad",
    shared: false,
    steerable: true,
    check: position,
};

pub(crate) const BRAKING_CURVE: Interlock = Interlock {
    name: "braking curve",
    doc: "The angle that a stop needs from this speed, and the angle by which the axis is behind its command, are more than \
          is left to the soft limit.",
    unit: "rad",
    shared: false,
    steerable: true,
    check: braking_curve,
};

pub(crate) const RESTRICTED_ZONE: Interlock = Interlock {
    name: "restricted zone",
    doc: "No axis could stop in front of a restricted zone of this point.",
    unit: "rad",
    shared: true,
    steerable: true,
    check: |v| v.zone,
};

pub(crate) const COAST_CURVE: Interlock = Interlock {
    name: "coast curve",
    doc: "Without torque the axis would meet the end of its travel with more energy than the end stops take.",
    unit: "J",
    shared: false,
    steerable: true,
    check: coast_curve,
};

pub(crate) const VELOCITY: Interlock = Interlock {
    name: "velocity",
    doc: "The axis turns faster than the rig allows.",
    unit: "rad/s",
    shared: false,
    steerable: true,
    check: |v| above(v.actuals.velocity_rad_per_s.abs(), v.guard.max_velocity_rad_per_s),
};

pub(crate) const ACCELERATION: Interlock = Interlock {
    name: "acceleration",
    doc: "The encoder's rate changes faster than the rig allows (smoothed over 4 ms).",
    unit: "rad/s^2",
    shared: false,
    steerable: true,
    check: |v| above(v.memory.acceleration_rad_per_s2().abs(), v.guard.max_acceleration_rad_per_s2),
};

pub(crate) const FOLLOWING_ERROR: Interlock = Interlock {
    name: "following error",
    doc: "The axis does not follow the reference of its position loop.",
    unit: "rad",
    shared: false,
    steerable: true,
    check: |v| {
        let error_rad = v.following_error_rad?.abs();
        above(error_rad, v.guard.max_following_error_rad).filter(|_| v.expects_operation)
    },
};

fn position(view: &View<'_>) -> Option<(f64, f64)> {
    let [low, high] = view.guard.stop.soft_limits_rad;
    let at = view.actuals.position_rad;
    let rate = view.actuals.velocity_rad_per_s;
    // On the way back inside, or at rest on the limit, there is nothing that a stop would make better.
    let harmless = |inward: f64| inward >= -CREEP_RAD_PER_S && at.is_finite();
    match (below(at, low), above(at, high)) {
        (Some(trip), _) => (!harmless(rate)).then_some(trip),
        (None, Some(trip)) => (!harmless(-rate)).then_some(trip),
        (None, None) => None,
    }
}

fn braking_curve(view: &View<'_>) -> Option<(f64, f64)> {
    let at = view.actuals.position_rad;
    let rate = view.actuals.velocity_rad_per_s;
    if rate.abs() <= REST_RAD_PER_S {
        return None;
    }
    let stop = &view.guard.stop;
    let deceleration = view.memory.deceleration_rad_per_s2(view.guard);
    // What brakes already goes on to brake; but no more of it is counted on than a stop may be.
    let acceleration = (view.memory.acceleration_rad_per_s2() * rate.signum()).max(-deceleration);
    let needed_rad = stop.controlled_from(rate, acceleration, deceleration).angle_rad;
    // A command that the axis is behind would still be followed.
    let behind_rad = (view.following_error_rad.unwrap_or(0.0) * rate.signum()).max(0.0);
    above(needed_rad + behind_rad, stop.room_rad(at, rate))
}

fn coast_curve(view: &View<'_>) -> Option<(f64, f64)> {
    let at = view.actuals.position_rad;
    let rate = view.actuals.velocity_rad_per_s;
    let stop = &view.guard.stop;
    let allowed_j = view.guard.stop.end_stop_energy_j;
    // The bound leaves out viscous friction: it costs little, and is enough wherever the stops take a full blow.
    above(stop.coast_energy_bound_j(at, rate), allowed_j)?;
    let impact = stop.coast(at, rate).impact?;
    above(impact.energy_j, allowed_j)
}
