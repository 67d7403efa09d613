//! What the axis cannot do: one diagnostic each, with what was asked and what is allowed.

use std::f64::consts::TAU;

use super::super::keys::Keys;
use super::APPROACH_FACTOR;
use crate::axis::AxisLimits;
use crate::diagnostic::Diagnostic;
use crate::quantity::QuantityKind as Q;

/// Static friction over torque quantum, at least (director.md §8).
const QUANTA: f64 = 300.0;
/// Largest multisine, in units of static friction (estimators.md §1.5): above, the contact is no spring any more.
const LARGEST_LEVEL: f64 = 0.1;
/// Shortest time in which a ramp may reach the expected static friction: the presliding mode (1 to 2 Hz, damped)
/// must follow, else the ramp measures inertia.
const SHORTEST_RAMP_S: f64 = 0.2;

/// Everything that keeps the procedure from running on this axis.
pub(super) fn refusals(keys: &Keys, axis: &str, limits: &AxisLimits) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    found.extend(quantum(axis, limits));
    found.extend(multisine(keys, axis, limits));
    found.extend(
        reaches(keys, limits).into_iter().filter_map(|(what, reach)| travel(axis, &what, reach, limits)),
    );
    found.extend(stroke(keys, axis, limits));
    found.extend(velocities(keys, axis, limits));
    match limits.torque_constant_nm_per_a {
        Some(constant) => found.extend(rates(keys, axis, limits, constant)),
        None => found.push(
            Diagnostic::new(format!(
                "axis `{axis}` has no torque constant: a current rate is no torque ramp"
            ))
            .help("give the rig's axis its `torque-constant`"),
        ),
    }
    found
}

fn quantum(axis: &str, limits: &AxisLimits) -> Option<Diagnostic> {
    let allowed = limits.expected_static_friction_nm / QUANTA;
    (limits.torque_quantum_nm > allowed).then(|| {
        Diagnostic::new(format!(
            "the torque quantum of axis `{axis}` is {}, at most {} is allowed: static friction ({} expected) over {QUANTA}",
            Q::Torque.format(limits.torque_quantum_nm),
            Q::Torque.format(allowed),
            Q::Torque.format(limits.expected_static_friction_nm),
        ))
        .help("lower the drive's torque scaling (object 6076)")
    })
}

fn multisine(keys: &Keys, axis: &str, limits: &AxisLimits) -> Option<Diagnostic> {
    let level = keys.multisine.as_ref()?.level_ratio;
    (level > LARGEST_LEVEL).then(|| {
        let torque = |ratio: f64| Q::Torque.format(ratio * limits.expected_static_friction_nm);
        Diagnostic::new(format!(
            "the multisine on axis `{axis}` peaks at {} of static friction ({}), at most {} ({}) is allowed",
            Q::Ratio.format(level),
            torque(level),
            Q::Ratio.format(LARGEST_LEVEL),
            torque(LARGEST_LEVEL),
        ))
        .help("set `level` in [multisine] to 0.1 or less: larger loops are not presliding")
    })
}

/// What the procedure reaches, by name of what asks for it.
fn reaches(keys: &Keys, limits: &AxisLimits) -> Vec<(String, [f64; 2])> {
    let displacement = keys.displacement_rad;
    let around = |pose: f64| [pose - APPROACH_FACTOR * displacement, pose + displacement];
    let mut all = Vec::new();
    if !keys.ramps.is_empty() || keys.multisine.is_some() {
        all.push((format!("`pose` {}", Q::Angle.format(keys.pose_rad)), around(keys.pose_rad)));
    }
    if let Some(map) = &keys.map {
        let reach = f64::from(map.periods) * TAU / limits.cogging_orders_per_rev;
        all.push(("the stroke of [map]".to_owned(), [keys.pose_rad - reach, keys.pose_rad + reach]));
    }
    for &pose in keys.hold.iter().flat_map(|h| &h.poses_rad) {
        all.push((format!("`pose` {} of [hold]", Q::Angle.format(pose)), around(pose)));
    }
    all
}

/// After each turn of the stroke the contact renews itself over up to `displacement`; then a period must remain.
fn stroke(keys: &Keys, axis: &str, limits: &AxisLimits) -> Option<Diagnostic> {
    let period = TAU / limits.cogging_orders_per_rev;
    let length = 2.0 * f64::from(keys.map.as_ref()?.periods) * period;
    let needed = 2.0 * keys.displacement_rad + period;
    (length < needed).then(|| {
        Diagnostic::new(format!(
            "the stroke of [map] on axis `{axis}` is {} long, at least {} is needed: twice `displacement` and a cogging period",
            Q::Angle.format(length),
            Q::Angle.format(needed)
        ))
        .help("more `periods` in [map]")
    })
}

fn travel(axis: &str, what: &str, reach: [f64; 2], limits: &AxisLimits) -> Option<Diagnostic> {
    let [low, high] = limits.soft_limits_rad;
    (reach[0] < low || reach[1] > high).then(|| {
        let range = |[a, b]: [f64; 2]| format!("{} … {}", Q::Angle.format(a), Q::Angle.format(b));
        Diagnostic::new(format!(
            "{what} reaches {} on axis `{axis}`, the soft limits are {}",
            range(reach),
            range([low, high])
        ))
        .help("choose another pose or a smaller `displacement` (approach from below included)")
    })
}

fn velocities(keys: &Keys, axis: &str, limits: &AxisLimits) -> Vec<Diagnostic> {
    let map = keys.map.as_ref().map(|m| ("`velocity` of [map]", m.velocity_rad_per_s));
    [("`approach-velocity`", keys.approach_rad_per_s)]
        .into_iter()
        .chain(map)
        .filter(|(_, asked)| *asked > limits.max_velocity_rad_per_s)
        .map(|(what, asked)| {
            Diagnostic::new(format!(
                "{what} is {}, axis `{axis}` allows {}",
                Q::AngularVelocity.format(asked),
                Q::AngularVelocity.format(limits.max_velocity_rad_per_s)
            ))
        })
        .collect()
}

fn rates(keys: &Keys, axis: &str, limits: &AxisLimits, constant: f64) -> Vec<Diagnostic> {
    let expected = limits.expected_static_friction_nm;
    let fastest = expected / SHORTEST_RAMP_S / constant;
    let asked: Vec<f64> = keys
        .ramps
        .iter()
        .flat_map(|r| r.rates_a_per_s.iter().copied())
        .chain(keys.hold.as_ref().map(|h| h.rate_a_per_s))
        .collect();
    let mut found: Vec<Diagnostic> = asked
        .into_iter()
        .filter(|&rate| rate > fastest)
        .map(|rate| {
            Diagnostic::new(format!(
                "a ramp of {} on axis `{axis}` reaches static friction within {}, at most {} is allowed",
                Q::CurrentRate.format(rate),
                Q::Time.format(expected / constant / rate),
                Q::CurrentRate.format(fastest),
            ))
            .help("a faster ramp shows the inertia, not the contact")
        })
        .collect();
    if keys.holding_torque_nm.abs() >= expected {
        found.push(Diagnostic::new(format!(
            "`holding-torque` {} is no less than the static friction expected on axis `{axis}`, {}",
            Q::Torque.format(keys.holding_torque_nm),
            Q::Torque.format(expected)
        )));
    }
    found
}
