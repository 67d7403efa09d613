//! The list of interlocks. A new one is a row here and a test beside it.

use super::{Interlock, View, operates};

/// Every interlock, in the order of first-out among those that trip in the same tick.
pub const INTERLOCKS: &[Interlock] = &[
    Interlock {
        name: "bus",
        doc: "Three exchanges in a row, or five in a hundred, without a frame or with a wrong working counter.",
        unit: "exchanges",
        shared: true,
        steerable: false,
        check: |v| match (v.bad_exchanges_in_row, v.bad_exchanges_in_100) {
            (row, _) if row >= 3 => Some((f64::from(row), 3.0)),
            (_, hundred) if hundred >= 5 => Some((f64::from(hundred), 5.0)),
            _ => None,
        },
    },
    Interlock {
        name: "stale data",
        doc: "The newest sample of the axis is older than the rig allows.",
        unit: "s",
        shared: false,
        steerable: false,
        check: |v| above(v.age_s, v.guard.stale_after_s),
    },
    Interlock {
        name: "missed cycles",
        doc: "The loop missed more periods in a row than the rig allows.",
        unit: "periods",
        shared: true,
        steerable: true,
        check: |v| above(f64::from(v.missed_periods), f64::from(v.max_missed_periods)),
    },
    Interlock {
        name: "drive state",
        doc: "A drive that must follow commands left operation enabled (statusword seen, 0027h expected).",
        unit: "hex",
        shared: false,
        steerable: false,
        check: |v| {
            let left = v.expects_operation && !operates(v.actuals);
            left.then(|| (f64::from(v.actuals.statusword), f64::from(0x0027_u16)))
        },
    },
    Interlock {
        name: "rate feedback",
        doc: "The velocity loop of the axis has had no valid sample for too long.",
        unit: "s",
        shared: true,
        steerable: true,
        check: |v| above(v.feedback_age_s, v.guard.stale_after_s).filter(|_| v.expects_operation),
    },
    Interlock {
        name: "rate disagreement",
        doc: "Gyro and encoder do not agree on the rate of the axis: one of them is wrong, or wired wrongly.",
        unit: "rad/s",
        shared: false,
        steerable: false,
        check: |v| {
            let seen = v.feedback_disagreement_rad_per_s.abs();
            above(seen, DISAGREEMENT_RAD_PER_S).filter(|_| v.expects_operation)
        },
    },
    Interlock {
        name: "position",
        doc: "The axis is outside its soft limits and not on its way back.",
        unit: "rad",
        shared: false,
        steerable: true,
        check: position,
    },
    Interlock {
        name: "braking curve",
        doc: "The angle that a stop needs from this speed is more than is left to the soft limit.",
        unit: "rad",
        shared: false,
        steerable: true,
        check: braking_curve,
    },
    Interlock {
        name: "velocity",
        doc: "The axis turns faster than the rig allows.",
        unit: "rad/s",
        shared: false,
        steerable: true,
        check: |v| above(v.actuals.velocity_rad_per_s.abs(), v.guard.max_velocity_rad_per_s),
    },
    Interlock {
        name: "torque",
        doc: "The drive shows more torque than the rig allows (2 % for its own ripple).",
        unit: "N*m",
        shared: false,
        steerable: true,
        check: |v| above(v.actuals.torque_nm.abs(), 1.02 * v.guard.max_torque_nm),
    },
    Interlock {
        name: "temperature",
        doc: "The heat sink is hotter than the rig allows.",
        unit: "degC",
        shared: false,
        steerable: true,
        check: |v| above(v.actuals.heat_sink_degc, v.guard.max_heat_sink_degc),
    },
    Interlock {
        name: "bus voltage",
        doc: "The DC link is outside its band.",
        unit: "V",
        shared: true,
        steerable: true,
        check: bus_voltage,
    },
];

/// Ten times what bending and the difference of their delays make at full torque.
const DISAGREEMENT_RAD_PER_S: f64 = 0.04;

/// Trips above the limit, and on what is not a number.
fn above(seen: f64, limit: f64) -> Option<(f64, f64)> {
    (seen > limit || seen.is_nan()).then_some((seen, limit))
}

/// Trips below the limit, and on what is not a number.
fn below(seen: f64, limit: f64) -> Option<(f64, f64)> {
    (seen < limit || seen.is_nan()).then_some((seen, limit))
}

/// Slower than this an axis counts as resting for the interlocks of position.
const REST_RAD_PER_S: f64 = 1e-3;

fn position(view: &View<'_>) -> Option<(f64, f64)> {
    let [low, high] = view.guard.stop.soft_limits_rad;
    let (at, rate) = (view.actuals.position_rad, view.actuals.velocity_rad_per_s);
    // On the way back inside, or at rest on the limit, there is nothing that a stop would make better.
    let harmless = |inward: f64| inward >= -REST_RAD_PER_S && at.is_finite();
    match (below(at, low), above(at, high)) {
        (Some(trip), _) => (!harmless(rate)).then_some(trip),
        (None, Some(trip)) => (!harmless(-rate)).then_some(trip),
        (None, None) => None,
    }
}

fn braking_curve(view: &View<'_>) -> Option<(f64, f64)> {
    let (at, rate) = (view.actuals.position_rad, view.actuals.velocity_rad_per_s);
    if rate.abs() <= REST_RAD_PER_S {
        return None;
    }
    let stop = &view.guard.stop;
    above(stop.controlled(rate).angle_rad, stop.room_rad(at, rate))
}

fn bus_voltage(view: &View<'_>) -> Option<(f64, f64)> {
    let [low, high] = view.guard.bus_voltage_v;
    below(view.actuals.bus_v, low).or_else(|| above(view.actuals.bus_v, high))
}
