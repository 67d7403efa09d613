//! Segments in torque mode have no planned position. They are bounded by what ends them, and by how fast an axis with
//! the least friction can become until then.

use procedures::case::{Case, Condition, Segment};
use procedures::excitation::Injection;
use procedures::stimulus::Stimulus;

use crate::model::axis::RigAxis;
use crate::model::stopping::Loads;

/// Places at which the load is looked for its largest value.
const PLACES: u32 = 16;

/// How far and how fast a segment may take the axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bounded {
    /// Lowest and highest place while it runs.
    pub(super) place_rad: [f64; 2],
    /// Largest speed.
    pub(super) rate_rad_per_s: f64,
    /// Largest acceleration.
    pub(super) acceleration_rad_per_s2: f64,
    /// Lowest and highest place after the stop that follows.
    pub(super) after_rad: [f64; 2],
    /// What bounds it.
    pub(super) by: &'static str,
    /// Only an interlock bounds it: the braking curve keeps every stop inside the soft limits.
    pub(super) by_interlock: bool,
}

/// Bounds of a segment that begins somewhere in `here`.
pub(super) fn bounds(case: &Case, segment: &Segment, axis: &RigAxis, here: [f64; 2]) -> Bounded {
    let stop = &axis.guard.stop;
    let way_rad = displacement(case, segment);
    let reach = |way: f64| [here[0] - way, here[1] + way];
    let place_rad = way_rad.map_or(stop.travel_rad, reach);
    let added_nm = match segment.excited.and_then(|index| case.excitations.get(index)) {
        Some(excitation) if excitation.into == Injection::Torque => excitation.peak(),
        _ => 0.0,
    };
    let motor_nm = (peak_nm(&segment.stimulus, segment.at_most_s) + added_nm).min(limit_nm(case, axis));
    let torque_nm = motor_nm + case.pull.map_or(0.0, |pull| pull.at_most_nm);
    if torque_nm + largest(&stop.loads, here) <= stop.friction.static_nm {
        return Bounded {
            place_rad: here,
            rate_rad_per_s: 0.0,
            acceleration_rad_per_s2: 0.0,
            after_rad: here,
            by: "static friction",
            by_interlock: false,
        };
    }
    let push_nm = torque_nm + largest(&stop.loads, place_rad);
    let acceleration = (push_nm - stop.friction.coulomb_nm).max(0.0) / stop.inertia_kg_m2;
    let (bound, by) = fastest(case, segment, axis, acceleration, way_rad);
    // What ends it takes the reaction time to take effect.
    let rate = (bound + acceleration * stop.reaction_s).min(axis.guard.safety.trip_velocity_rad_per_s);
    let in_time_rad = 0.5 * acceleration * segment.at_most_s * segment.at_most_s;
    let by_interlock = way_rad.is_none() && reach(in_time_rad)[1] > stop.travel_rad[1];
    let way = way_rad.unwrap_or(f64::INFINITY).min(in_time_rad) + rate * stop.reaction_s;
    let place_rad =
        if by_interlock { stop.soft_limits_rad } else { in_bounds(case, reach(way), rate * stop.reaction_s) };
    let arrest_rad = if by_interlock { 0.0 } else { stop.controlled(rate).angle_rad };
    Bounded {
        place_rad,
        rate_rad_per_s: rate,
        acceleration_rad_per_s2: acceleration,
        after_rad: [place_rad[0] - arrest_rad, place_rad[1] + arrest_rad],
        by: if by_interlock { "the braking curve alone" } else { by },
        by_interlock,
    }
}

/// The part of a range that the point's bounds leave: they count from where the point began, over all of its segments, and
/// trip. `late_rad` is the way of the reaction time.
fn in_bounds(case: &Case, [low, high]: [f64; 2], late_rad: f64) -> [f64; 2] {
    let Some(bounds) = case.bounds else { return [low, high] };
    let start_rad = case.start_pose_rad.get(&case.axis).copied().unwrap_or(0.0);
    let most_rad = bounds.displacement_rad + late_rad;
    [low.max(start_rad - most_rad), high.min(start_rad + most_rad)]
}

/// The largest speed that the segment's end, the point's bounds or the rig allow, and which of them.
fn fastest(
    case: &Case,
    segment: &Segment,
    axis: &RigAxis,
    acceleration: f64,
    way_rad: Option<f64>,
) -> (f64, &'static str) {
    let speed = match segment.until {
        Some(Condition::Speed { above_rad_per_s }) => Some(above_rad_per_s),
        _ => None,
    };
    [
        (Some(axis.guard.safety.trip_velocity_rad_per_s), "the trip velocity"),
        (Some(acceleration * segment.at_most_s), "its duration"),
        (way_rad.map(|way| (2.0 * acceleration * way).sqrt()), "its displacement"),
        (speed, "its speed condition"),
        (case.bounds.map(|b| b.speed_rad_per_s), "the bounds of the point"),
    ]
    .into_iter()
    .filter_map(|(bound, by)| Some((bound?, by)))
    .min_by(|a, b| a.0.total_cmp(&b.0))
    .expect("the trip velocity is always there")
}

/// The way after which the segment ends or trips.
fn displacement(case: &Case, segment: &Segment) -> Option<f64> {
    let own = match segment.until {
        Some(Condition::Displacement { above_rad }) => Some(above_rad),
        _ => None,
    };
    own.into_iter().chain(case.bounds.map(|b| b.displacement_rad)).min_by(f64::total_cmp)
}

fn limit_nm(case: &Case, axis: &RigAxis) -> f64 {
    case.torque_limit_nm.unwrap_or(axis.limits.max_torque_nm)
}

/// Largest magnitude of the commanded torque.
fn peak_nm(stimulus: &Stimulus, at_most_s: f64) -> f64 {
    match stimulus {
        Stimulus::Hold { torque_nm } => torque_nm.abs(),
        Stimulus::TorqueRamp { from_nm, rate_nm_per_s } => {
            from_nm.abs().max((from_nm + rate_nm_per_s * at_most_s).abs())
        }
        Stimulus::TorqueMultisine { offset_nm, lines, .. } => {
            offset_nm.abs() + lines.iter().map(|l| l.amplitude_nm.abs()).sum::<f64>()
        }
        Stimulus::Move { .. }
        | Stimulus::Reversals { .. }
        | Stimulus::Cruise { .. }
        | Stimulus::Step { .. }
        | Stimulus::Sine { .. }
        | Stimulus::Trajectory { .. } => 0.0,
    }
}

/// Largest magnitude of the loads over a range.
fn largest(loads: &Loads, [low, high]: [f64; 2]) -> f64 {
    let load_nm = |k: u32| loads.at(low + (high - low) * f64::from(k) / f64::from(PLACES)).abs();
    (0..=PLACES).map(load_nm).fold(0.0, f64::max)
}
