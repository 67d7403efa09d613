//! Gates: what must hold before anything moves. A closed gate refuses the point (exit 6) and says what was expected and
//! what was found.
//!
//! One gate is one row of [`GATES`] (every point passes all of them) or of [`ASKED`] (where a procedure file asks for
//! it). They are checked while the drives have no torque yet. What is not known in the tick is checked before it:
//! [`free_disk`].

use drivers::cia402::{Actuals, PowerState, error_code_meaning};
use procedures::case::Case;
use procedures::quantity::{Limit, QuantityKind as Q};

use crate::model::axis::RigAxis;
use crate::rig::ArmedRig;

mod before;
#[cfg(test)]
mod tests;

pub(crate) use before::{free_disk, planned_log_bytes};

/// What a gate may look at: one axis before anything moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View<'a> {
    /// The axis' part of the rig file.
    pub axis: &'a RigAxis,
    /// What its drive said.
    pub actuals: &'a Actuals,
    /// The point that is to begin.
    pub case: &'a Case,
}

/// A gate that every point passes.
pub(crate) struct Gate {
    /// Name in refusals.
    pub name: &'static str,
    /// `Some((expected, found))` where it is closed.
    pub check: fn(&View<'_>) -> Option<(String, String)>,
}

/// A gate that a procedure file asks for under `[gate]`, with a limit.
pub(crate) struct AskedGate {
    /// Key in the file; the same names stand in `procedures::procedure::GATES`, with the kind of their limits.
    pub name: &'static str,
    /// The quantity, SI units.
    pub seen: fn(&Actuals) -> f64,
}

/// Built-in gates, in the order of checking.
pub(crate) const GATES: &[Gate] = &[
    // The drive has no torque yet and no reaction under way: nobody else commands it. A latched fault passes; it is reset
    // before torque comes, and stays a refusal to enable where it cannot be.
    Gate { name: "drive-state", check: drive_state },
    // The position is known: a finite angle inside the travel (0.1 deg for resting against a stop). An encoder with a lost or
    // wrong offset shows itself here. The start pose is not demanded: homing goes there, slowly and under all interlocks.
    Gate { name: "homed", check: homed },
    // The axis is slower than 2 deg/s: enabling catches one that slips under its load, and is no brake for one that falls or
    // is turned by hand.
    Gate { name: "slow", check: slow },
    // Where no loop may be closed, nothing can bring the axis to its start: it must stand at least 30 deg from either end of
    // its travel (less only where the travel is too short for that).
    Gate { name: "room", check: room },
];

/// Gates of procedure files: temperature of the drive's heat sink, voltage of the DC link.
pub(crate) const ASKED: &[AskedGate] = &[
    AskedGate { name: "heat-sink", seen: |a| a.heat_sink_degc },
    AskedGate { name: "bus-voltage", seen: |a| a.bus_v },
];

/// An axis that rests against its stop may read this much beyond it.
const BEYOND_TRAVEL_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// An axis without torque that is faster than this is not caught by enabling it.
const SLOW_RAD_PER_S: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Distance from every end at which signs may be tried out (safety.md: polarity).
const ROOM_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// The first gate that does not hold, as text with what was expected and found: first those of every point, then those
/// that the procedure asks for.
pub(crate) fn closed(asked: &[(String, Limit)], case: &Case, rig: &ArmedRig) -> Option<String> {
    let view = |index: usize| View { axis: &rig.axes()[index], actuals: rig.actuals(index), case };
    (0..rig.axes().len()).find_map(|index| closed_on(asked, &view(index)))
}

/// Whether a heat sink is warmer than the gate of its name allows: that passes by itself.
pub(crate) fn is_too_warm(asked: &[(String, Limit)], rig: &ArmedRig) -> bool {
    let warm =
        |limit: &Limit| (0..rig.axes().len()).any(|axis| !limit.holds(rig.actuals(axis).heat_sink_degc));
    asked.iter().any(|(name, limit)| name == "heat-sink" && warm(limit))
}

/// The first gate that is closed on one axis.
fn closed_on(asked: &[(String, Limit)], view: &View<'_>) -> Option<String> {
    let axis = &view.axis.name;
    let built_in = GATES.iter().find_map(|gate| {
        let (expected, found) = (gate.check)(view)?;
        Some(format!("gate `{}` of {axis}: expected {expected}, found {found}", gate.name))
    });
    built_in.or_else(|| {
        asked.iter().find_map(|(name, limit)| {
            let Some(gate) = ASKED.iter().find(|gate| gate.name == name) else {
                return Some(format!("gate `{name}`: the rig has no such channel"));
            };
            let seen = (gate.seen)(view.actuals);
            let found = limit.kind.format(seen);
            (!limit.holds(seen))
                .then(|| format!("gate `{name}` of {axis}: expected {}, found {found}", limit.text))
        })
    })
}

fn drive_state(view: &View<'_>) -> Option<(String, String)> {
    let state = PowerState::of(view.actuals.statusword);
    let foreign = matches!(
        state,
        PowerState::OperationEnabled | PowerState::FaultReactionActive | PowerState::Unknown(_)
    );
    foreign.then(|| {
        let mut found = format!("{} (statusword {:04X}h", state.name(), view.actuals.statusword);
        if view.actuals.error_code != 0 {
            let code = view.actuals.error_code;
            found += &format!(", error {code:04X}h: {}", error_code_meaning(code));
        }
        ("a drive without torque and without another master".to_owned(), found + ")")
    })
}

fn homed(view: &View<'_>) -> Option<(String, String)> {
    let [low, high] = view.axis.limits.travel_rad;
    let at = view.actuals.position_rad;
    let inside = (low - BEYOND_TRAVEL_RAD..=high + BEYOND_TRAVEL_RAD).contains(&at);
    let angle = |rad| Q::Angle.format(rad);
    (!inside).then(|| (format!("{} .. {} (the travel)", angle(low), angle(high)), angle(at)))
}

fn slow(view: &View<'_>) -> Option<(String, String)> {
    let rate = view.actuals.velocity_rad_per_s;
    let moves = rate.is_nan() || rate.abs() > SLOW_RAD_PER_S;
    let text = |rate| Q::AngularVelocity.format(rate);
    moves.then(|| (format!("at most {}", text(SLOW_RAD_PER_S)), text(rate)))
}

fn room(view: &View<'_>) -> Option<(String, String)> {
    if !view.case.open_loop || view.case.axis != view.axis.name {
        return None;
    }
    let [low, high] = view.axis.limits.travel_rad;
    let at = view.actuals.position_rad;
    let needed = ROOM_RAD.min((high - low) / 3.0);
    let there = (at - low).min(high - at);
    let text = |rad| Q::Angle.format(rad);
    (there.is_nan() || there < needed)
        .then(|| (format!("at least {} to either end of travel", text(needed)), text(there)))
}
