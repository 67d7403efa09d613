//! Settings of a rig that are each in range and unsafe together. One rule is one row: what contradicts what, and why.

use procedures::axis::AxisLimits;
use procedures::quantity::QuantityKind as K;
use procedures::table::TableReader;

use super::safety::Written;
use crate::model::axis::{AxisGuard, VelocityFeedback};
use crate::model::safety::{SafeState, Safety};

/// Longest process-data watchdog of any rig, s (safety.md: device-side).
const LONGEST_WATCHDOG_S: f64 = 0.050;
/// Shortest, in ticks: one late frame must not stop the axis.
const SHORTEST_WATCHDOG_TICKS: f64 = 10.0;
/// Torque of the check of polarity over the static friction that is expected: breakaway and 20 %.
const POLARITY_MARGIN: f64 = 1.2;
/// Steps in which a travel is searched for a pose that friction holds.
const POSES: u32 = 720;

/// One axis as it was read.
pub(super) struct Settings<'a> {
    pub(super) limits: &'a AxisLimits,
    pub(super) safety: &'a Safety,
    /// Where the keys of the table stand.
    pub(super) written: &'a Written,
    pub(super) guard: &'a AxisGuard,
    pub(super) feedback: VelocityFeedback,
    pub(super) cycle_s: f64,
    pub(super) max_missed_periods: f64,
}

/// One rule.
struct Rule {
    /// Key that the mistake points at: of the axis, or of its table `safety`.
    key: &'static str,
    /// What is wrong, with both figures, where it is.
    broken: fn(&Settings<'_>) -> Option<String>,
    /// Why it is unsafe, and what to do.
    because: &'static str,
}

const RULES: &[Rule] = &[
    Rule {
        key: "soft-limits",
        broken: soft_limits_leave_the_travel,
        because: "choose soft limits inside `travel`: its ends are the mechanical stops",
    },
    Rule {
        key: "zero-tolerance",
        broken: zero_leaves_the_travel,
        because: "with a zero error of this size a soft limit may lie outside the travel: read the scale \
                  more accurately, or move the soft limits inwards",
    },
    Rule {
        key: "trip-velocity",
        broken: |s| {
            let trip = s.guard.safety.trip_velocity_rad_per_s;
            let max = s.limits.max_velocity_rad_per_s;
            not_above(K::AngularVelocity, "trip-velocity", trip, "max-velocity", max)
        },
        because: "a move at its own limit would trip: leave room for the overshoot of the velocity loop",
    },
    Rule {
        key: "trip-acceleration",
        broken: |s| {
            let trip = s.guard.safety.trip_acceleration_rad_per_s2;
            let stop = s.guard.stop.deceleration_rad_per_s2;
            not_above(K::AngularAcceleration, "trip-acceleration", trip, "braking-deceleration", stop)
        },
        because: "every stop would trip a second time, and a second trip ends the controlled stop",
    },
    Rule {
        key: "braking-deceleration",
        broken: more_than_the_motor_gives,
        because: "a stop that relies on torque the motor does not have ends in the end stop; friction \
                  helps, but it is not guaranteed",
    },
    Rule {
        key: "braking-deceleration",
        broken: |s| {
            let stop = s.guard.stop.deceleration_rad_per_s2;
            let plan = s.limits.max_acceleration_rad_per_s2;
            let found = |a| K::AngularAcceleration.format(a);
            (stop < plan).then(|| {
                let stop = found(stop);
                let plan = found(plan);
                format!("`braking-deceleration` {stop} is below `max-acceleration` {plan}")
            })
        },
        because: "a planned move would brake later than the braking curve allows: every fast move would trip",
    },
    Rule {
        key: "trip-velocity",
        broken: no_room_to_stop,
        because: "lower `trip-velocity`, or raise `braking-deceleration`",
    },
    Rule {
        key: "process-data-watchdog",
        broken: watchdog_out_of_reach,
        because: "if it is shorter than 10 ticks, a late frame stops the axis; if it is longer than 50 ms, \
                  the axis runs on uncontrolled",
    },
    Rule {
        key: "process-data-watchdog",
        broken: |s| {
            let gap_s = s.max_missed_periods * s.cycle_s;
            (gap_s > s.safety.watchdog_s).then(|| {
                let gap = K::Time.format(gap_s);
                let watchdog = K::Time.format(s.safety.watchdog_s);
                format!(
                    "`max-missed-periods` allows {gap} without a frame, but `process-data-watchdog` is \
                     {watchdog}"
                )
            })
        },
        because: "the drive would stop the axis before the bench trips: allow fewer missed periods",
    },
    Rule {
        key: "polarity-torque",
        broken: polarity_torque_of_no_use,
        because: "it must break the axis away (1.2 times the expected friction) and stay within the torque \
                  of the drive",
    },
    Rule {
        key: "least-static-friction",
        broken: |s| {
            let least = s.safety.friction.static_nm;
            let expected = s.limits.expected_static_friction_nm;
            more_than("least-static-friction", least, "expected-static-friction", expected)
        },
        because: "a guaranteed minimum cannot exceed the expected value",
    },
    Rule {
        key: "least-running-friction",
        broken: |s| {
            let friction = &s.safety.friction;
            more_than(
                "least-running-friction",
                friction.coulomb_nm,
                "least-static-friction",
                friction.static_nm,
            )
        },
        because: "running friction cannot exceed static friction: one of the two values is wrong",
    },
    Rule {
        key: "continuous-torque",
        broken: |s| {
            more_than(
                "continuous-torque",
                s.safety.continuous_torque_nm,
                "max-torque",
                s.limits.max_torque_nm,
            )
        },
        because: "an overload of the motor would never be detected",
    },
    Rule {
        key: "max-rate-disagreement",
        broken: |s| {
            let none =
                s.feedback == VelocityFeedback::Gyro && s.safety.max_rate_disagreement_rad_per_s <= 0.0;
            none.then(|| {
                "`max-rate-disagreement` is 0 and the velocity loop is closed on the gyro".to_owned()
            })
        },
        because: "noise alone would trip: choose about 2.3 deg/s, or close the loop on the encoder",
    },
    Rule { key: "safe-pose", broken: pose_outside, because: "choose a `safe-pose` inside the soft limits" },
    Rule {
        key: "safe-state",
        broken: released_where_it_does_not_stay,
        because: "the axis would swing when its torque is switched off: choose `safe-state = \"hold\"`, or \
                  a `safe-pose` at which static friction is 1.3 times spring and unbalance",
    },
];

/// Adds a mistake for every rule that the axis breaks.
pub(super) fn refuse(t: &mut TableReader<'_>, settings: &Settings<'_>) {
    for rule in RULES {
        if let Some(message) = (rule.broken)(settings) {
            let place = settings.written.place(rule.key).unwrap_or_else(|| t.span(rule.key));
            t.mistake_at(place, message, Some(rule.because.to_owned()));
        }
    }
}

fn not_above(kind: K, key: &str, value: f64, other: &str, bound: f64) -> Option<String> {
    let wrong = value <= bound;
    wrong.then(|| format!("`{key}` {} is not above `{other}` {}", kind.format(value), kind.format(bound)))
}

fn more_than(key: &str, value: f64, other: &str, bound: f64) -> Option<String> {
    let found = |torque| K::Torque.format(torque);
    (value > bound).then(|| format!("`{key}` {} is above `{other}` {}", found(value), found(bound)))
}

fn zero_leaves_the_travel(s: &Settings<'_>) -> Option<String> {
    let ([low, high], [soft_low, soft_high]) = (s.limits.travel_rad, s.limits.soft_limits_rad);
    let clear_rad = (soft_low - low).min(high - soft_high);
    let zero_rad = s.limits.zero_tolerance_rad;
    // Soft limits outside the travel are a mistake of their own.
    (clear_rad >= 0.0 && clear_rad < zero_rad).then(|| {
        let zero = K::Angle.format(zero_rad);
        let clear = K::Angle.format(clear_rad);
        format!("`zero-tolerance` is {zero}, but `soft-limits` are only {clear} inside `travel`")
    })
}

fn soft_limits_leave_the_travel(s: &Settings<'_>) -> Option<String> {
    let travel = s.limits.travel_rad;
    let soft = s.limits.soft_limits_rad;
    let what = match () {
        () if soft[0] < travel[0] || soft[1] > travel[1] => "reach beyond",
        () if soft[0] == travel[0] || soft[1] == travel[1] => "end at an end of",
        () => return None,
    };
    let shown = |[low, high]: [f64; 2]| format!("{} .. {}", K::Angle.format(low), K::Angle.format(high));
    Some(format!("`soft-limits` {} {what} `travel` {}", shown(soft), shown(travel)))
}

fn more_than_the_motor_gives(s: &Settings<'_>) -> Option<String> {
    let torque_nm = s.limits.max_torque_nm;
    let load_nm = s.guard.worst_load_nm;
    let gives = (torque_nm - load_nm) / s.limits.inertia_kg_m2;
    let wanted = s.guard.stop.deceleration_rad_per_s2;
    (wanted > gives).then(|| {
        let found = |a| K::AngularAcceleration.format(a);
        let torque = K::Torque.format(torque_nm);
        let load = K::Torque.format(load_nm);
        let wanted = found(wanted);
        let gives = found(gives);
        format!(
            "`braking-deceleration` {wanted} is more than the motor can deliver: {torque} less {load} of \
             loads is {gives}"
        )
    })
}

fn no_room_to_stop(s: &Settings<'_>) -> Option<String> {
    let [low, high] = s.limits.soft_limits_rad;
    let needed_rad = s.guard.stop.controlled(s.guard.safety.trip_velocity_rad_per_s).angle_rad;
    (needed_rad > high - low).then(|| {
        let speed = K::AngularVelocity.format(s.guard.safety.trip_velocity_rad_per_s);
        let room = K::Angle.format(high - low);
        let needed = K::Angle.format(needed_rad);
        format!(
            "a stop from `trip-velocity` {speed} needs {needed}, but there are only {room} between the soft limits"
        )
    })
}

fn watchdog_out_of_reach(s: &Settings<'_>) -> Option<String> {
    let watchdog_s = s.safety.watchdog_s;
    let shortest_s = SHORTEST_WATCHDOG_TICKS * s.cycle_s;
    // 10 ticks are allowed, however their period was rounded.
    let outside = watchdog_s < shortest_s * (1.0 - 1e-9) || watchdog_s > LONGEST_WATCHDOG_S;
    outside.then(|| {
        let [found, least, most] =
            [watchdog_s, shortest_s, LONGEST_WATCHDOG_S].map(|time| K::Time.format(time));
        format!("`process-data-watchdog` {found} is not in 10 ticks .. 50 ms ({least} .. {most})")
    })
}

fn polarity_torque_of_no_use(s: &Settings<'_>) -> Option<String> {
    let torque_nm = s.safety.polarity_torque_nm;
    let most_nm = s.limits.max_torque_nm;
    let least_nm = POLARITY_MARGIN * s.limits.expected_static_friction_nm;
    (torque_nm < least_nm || torque_nm > most_nm).then(|| {
        let [found, least, most] = [torque_nm, least_nm, most_nm].map(|torque| K::Torque.format(torque));
        format!(
            "`polarity-torque` {found} is not in {least} (1.2 times `expected-static-friction`) .. {most}"
        )
    })
}

fn pose_outside(s: &Settings<'_>) -> Option<String> {
    let (pose_rad, [low, high]) = (s.safety.safe_pose_rad?, s.limits.soft_limits_rad);
    (!(low..=high).contains(&pose_rad)).then(|| {
        let [pose, low, high] = [pose_rad, low, high].map(|angle| K::Angle.format(angle));
        format!("`safe-pose` {pose} is outside the soft limits {low} .. {high}")
    })
}

fn released_where_it_does_not_stay(s: &Settings<'_>) -> Option<String> {
    if s.safety.safe_state != SafeState::Release {
        return None;
    }
    let (stop, [low, high]) = (&s.guard.stop, s.limits.travel_rad);
    if let Some(pose_rad) = s.safety.safe_pose_rad {
        let load = K::Torque.format(stop.loads.at(pose_rad).abs());
        let pose = K::Angle.format(pose_rad);
        let friction = K::Torque.format(stop.friction.static_nm);
        let swings = !stop.holds_without_torque(pose_rad);
        return swings.then(|| {
            format!("`safe-state = \"release\"`: at `safe-pose` {pose} the load is {load}, least static friction {friction}")
        });
    }
    let pose_rad = |k: u32| low + (high - low) * f64::from(k) / f64::from(POSES);
    let nowhere = (0..=POSES).all(|k| !stop.holds_without_torque(pose_rad(k)));
    nowhere
        .then(|| "`safe-state = \"release\"`: nowhere in the travel does friction hold the axis".to_owned())
}
