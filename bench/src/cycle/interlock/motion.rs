//! Interlocks on how the axis moves, and on whether it could still be stopped.

use super::{Interlock, View, above, below};
use crate::model::stopping::REST_RAD_PER_S;

/// Time after which an axis that accelerates against its torque counts as a runaway (safety.md: runaway).
const RUNAWAY_S: f64 = 0.020;
/// An axis outside a soft limit that moves outward slower than this (two counts per millisecond) counts as standing.
const CREEP_RAD_PER_S: f64 = 2e-4;

pub(crate) const RUNAWAY: Interlock = Interlock {
    name: "runaway",
    doc: "For 20 ms the axis has accelerated against a torque that is clearly above breakaway: a sign is wrong.",
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
    // An axis that went where no command sent it may not obey the command to stop either.
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
    doc: "The angle that a stop from this speed needs, plus the angle by which the axis lags its command, \
          exceeds the distance to the soft limit.",
    unit: "rad",
    shared: false,
    steerable: true,
    check: braking_curve,
};

pub(crate) const RESTRICTED_ZONE: Interlock = Interlock {
    name: "restricted zone",
    doc: "Neither axis could stop any more before it enters a restricted zone of this point.",
    unit: "rad",
    shared: true,
    steerable: true,
    check: |v| v.zone,
};

pub(crate) const COAST_CURVE: Interlock = Interlock {
    name: "coast curve",
    doc: "Without torque the axis would hit the end of its travel with more energy than the end stops absorb.",
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
    check: |v| above(v.actuals.velocity_rad_per_s.abs(), v.guard.safety.trip_velocity_rad_per_s),
};

pub(crate) const ACCELERATION: Interlock = Interlock {
    name: "acceleration",
    doc: "The encoder's rate changes faster than the rig allows (smoothed over 4 ms).",
    unit: "rad/s^2",
    shared: false,
    steerable: true,
    check: |v| above(v.memory.acceleration_rad_per_s2().abs(), v.guard.safety.trip_acceleration_rad_per_s2),
};

pub(crate) const FOLLOWING_ERROR: Interlock = Interlock {
    name: "following error",
    doc: "The axis does not follow the reference of its position loop.",
    unit: "rad",
    shared: false,
    steerable: true,
    check: |v| {
        let error_rad = v.following_error_rad?.abs();
        above(error_rad, v.guard.safety.max_following_error_rad).filter(|_| v.expects_operation)
    },
};

fn position(view: &View<'_>) -> Option<(f64, f64)> {
    let [low_rad, high_rad] = view.guard.stop.soft_limits_rad;
    let position_rad = view.actuals.position_rad;
    let velocity_rad_per_s = view.actuals.velocity_rad_per_s;
    // A stop helps neither an axis on its way back inside nor one at rest outside. A position that is not finite trips.
    let needs_stop = |outward_rad_per_s: f64| {
        let stands_or_returns = outward_rad_per_s <= CREEP_RAD_PER_S;
        !(stands_or_returns && position_rad.is_finite())
    };
    match (below(position_rad, low_rad), above(position_rad, high_rad)) {
        (Some(trip), _) => needs_stop(-velocity_rad_per_s).then_some(trip),
        (None, Some(trip)) => needs_stop(velocity_rad_per_s).then_some(trip),
        (None, None) => None,
    }
}

fn braking_curve(view: &View<'_>) -> Option<(f64, f64)> {
    let position_rad = view.actuals.position_rad;
    let velocity = view.actuals.velocity_rad_per_s;
    if velocity.abs() <= REST_RAD_PER_S {
        return None;
    }
    let stop = &view.guard.stop;
    let deceleration = view.memory.deceleration_rad_per_s2(view.guard);
    // Positive in the direction of motion. Until a stop sets in, the axis keeps its acceleration. If it brakes already, no
    // more braking is counted on than a stop may rely on.
    let acceleration = (view.memory.acceleration_rad_per_s2() * velocity.signum()).max(-deceleration);
    let stopping_rad = stop.controlled_from(velocity, acceleration, deceleration).angle_rad;
    // An axis that lags behind its reference still moves by this lag before it stops.
    let lag_rad = (view.following_error_rad.unwrap_or(0.0) * velocity.signum()).max(0.0);
    above(stopping_rad + lag_rad, stop.room_rad(position_rad, velocity))
}

fn coast_curve(view: &View<'_>) -> Option<(f64, f64)> {
    let position_rad = view.actuals.position_rad;
    let velocity_rad_per_s = view.actuals.velocity_rad_per_s;
    let stop = &view.guard.stop;
    let allowed_j = stop.end_stop_energy_j;
    // A cheap upper bound first: it neglects viscous friction. The coast is computed in full only where this bound is not
    // enough.
    above(stop.coast_energy_bound_j(position_rad, velocity_rad_per_s), allowed_j)?;
    let impact = stop.coast(position_rad, velocity_rad_per_s).impact?;
    above(impact.energy_j, allowed_j)
}
