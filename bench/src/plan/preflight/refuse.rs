//! What of a plan the rig does not allow.

use procedures::case::{Case, Zone};
use procedures::diagnostic::Diagnostic;
use procedures::quantity::QuantityKind as Q;

use super::{PlannedStop, PointEnvelope, ProcedureEnvelope};
use crate::model::axis::RigAxis;
use crate::model::rig::Rig;
use crate::model::safety::SafeState;

/// Angles and torques may exceed their limits by this: both went through unit conversion.
const ROUNDING: f64 = 1e-9;

/// Every refusal of a procedure.
pub(super) fn refusals(found: &ProcedureEnvelope, cases: &[Case], rig: &Rig) -> Vec<Diagnostic> {
    let Some(axis) = rig.axes.iter().find(|a| a.name == found.axis) else { return Vec::new() };
    let mut all = Vec::new();
    for (point, case) in found.points.iter().zip(cases) {
        let at = format!("{}, point `{}`", found.procedure, point.point);
        let mut fenced = axis.clone();
        fenced.guard.stop.soft_limits_rad = case.soft_limits_rad(&axis.name, axis.guard.stop.soft_limits_rad);
        all.extend(leaves(&at, point, &fenced));
        all.extend(too_strong(&at, point, axis));
        all.extend(hits(&at, point, axis));
        all.extend(rams(&at, point, axis));
        all.extend(lets_go(&at, point, axis));
        all.extend(drops(&at, case, rig));
        if found.axis == case.axis {
            all.extend(masked(&at, case, rig));
        }
    }
    all.extend(too_hot(found, axis));
    all
}

fn leaves(at: &str, point: &PointEnvelope, axis: &RigAxis) -> Option<Diagnostic> {
    let stop: PlannedStop = point.nearest_stop.filter(|s| s.room_rad < -ROUNDING)?;
    let [low, high] = axis.guard.stop.soft_limits_rad.map(|limit| Q::Angle.format(limit));
    let how = if point.open_loop { "without torque" } else { "under control" };
    let message = format!(
        "{at}: a stop {how} of axis `{}` from {} at {} ends at {}: its soft limits are {low} .. {high}",
        axis.name,
        Q::AngularVelocity.format(stop.rate_rad_per_s.abs()),
        Q::Angle.format(stop.from_rad),
        Q::Angle.format(stop.reach_rad),
    );
    let help = format!(
        "stay {} farther from the soft limit, or reduce speed or acceleration",
        Q::Angle.format(-stop.room_rad)
    );
    Some(Diagnostic::new(message).help(help))
}

fn too_strong(at: &str, point: &PointEnvelope, axis: &RigAxis) -> Option<Diagnostic> {
    let allowed = axis.guard.max_torque_nm;
    if point.torque_nm <= allowed * (1.0 + ROUNDING) {
        return None;
    }
    let message = format!(
        "{at}: inertia, expected friction and loads of axis `{}` need {}, but it can deliver {}",
        axis.name,
        Q::Torque.format(point.torque_nm),
        Q::Torque.format(allowed)
    );
    Some(Diagnostic::new(message).help("reduce the acceleration"))
}

fn hits(at: &str, point: &PointEnvelope, axis: &RigAxis) -> Option<Diagnostic> {
    let worst = point.coast?;
    let impact = worst.coast.impact?;
    let takes = axis.guard.stop.end_stop_energy_j;
    if impact.energy_j <= takes {
        return None;
    }
    let message = format!(
        "{at}: without torque from {worst}, axis `{}` hits its end stop with {} ({}), which absorbs only {}",
        axis.name,
        Q::Energy.format(impact.energy_j),
        Q::AngularVelocity.format(impact.speed_rad_per_s),
        Q::Energy.format(takes),
    );
    let help =
        "reduce the speed or stay farther from the end; declare a brake or buffers in `[axis.*.safety]`";
    Some(Diagnostic::new(message).help(help))
}

/// Torque that is taken away as ordered must not end in an end stop, whatever that would bear.
fn rams(at: &str, point: &PointEnvelope, axis: &RigAxis) -> Option<Diagnostic> {
    let ordered = point.torque_off?;
    let impact = ordered.coast.impact?;
    let message = format!(
        "{at}: the torque is to be switched off at {ordered}, but axis `{}` would then hit its end stop with {}",
        axis.name,
        Q::Energy.format(impact.energy_j),
    );
    Some(
        Diagnostic::new(message)
            .help("a plan must not hit an end stop: reduce the speed or begin farther from the end"),
    )
}

/// A restricted zone over the place where the axes start or are parked: they would be inside before anything watches,
/// or be sent into it in the end.
fn masked(at: &str, case: &Case, rig: &Rig) -> Vec<Diagnostic> {
    let zones = case.fence.as_ref().map_or(&[][..], |fence| fence.zones.as_slice());
    let Some(gimbal) = rig.gimbal() else { return Vec::new() };
    let both = gimbal.both().map(|axis| &rig.axes[axis]);
    let start = |axis: &RigAxis| case.start_pose_rad.get(&axis.name).copied();
    let park = |axis: &RigAxis| {
        axis.guard.safety.safe_pose_rad.filter(|_| axis.guard.safety.safe_state == SafeState::Release)
    };
    let parks = rig.axes.iter().any(|axis| park(axis).is_some());
    let mut all = Vec::new();
    for zone in zones {
        let within = |pose: &dyn Fn(&RigAxis) -> Option<f64>| {
            let inside = |(place, axis): (usize, &RigAxis)| {
                pose(axis).is_some_and(|rad| zone.gap_rad(place, rad).0 <= 0.0)
            };
            both.into_iter().enumerate().all(inside)
        };
        for (what, holds, pose) in [
            ("start", true, &start as &dyn Fn(&RigAxis) -> Option<f64>),
            ("are parked", parks, &|axis: &RigAxis| park(axis).or_else(|| start(axis))),
        ] {
            if holds && within(pose) {
                all.push(over(at, zone, what, pose, both));
            }
        }
    }
    all
}

fn over(
    at: &str,
    zone: &Zone,
    what: &str,
    pose: &dyn Fn(&RigAxis) -> Option<f64>,
    both: [&RigAxis; 2],
) -> Diagnostic {
    let [outer, inner] = [0, 1].map(|k| {
        let [low, high] = [zone.lower_rad[k], zone.upper_rad[k]].map(|rad| Q::Angle.format(rad));
        format!("{} {low} .. {high}", both[k].name)
    });
    let places: Vec<String> = both
        .iter()
        .map(|axis| {
            format!("{} {}", axis.name, pose(axis).map_or_else(String::new, |rad| Q::Angle.format(rad)))
        })
        .collect();
    let message = format!(
        "{at}: the restricted zone {outer}, {inner} covers the place where the axes {what}: {}",
        places.join(", ")
    );
    Diagnostic::new(message)
        .help("move the zone, the start, or `safe-pose` of the rig: no axis may be inside it")
}

/// Torque that is taken away as ordered from an axis at rest must leave it where it is.
fn lets_go(at: &str, point: &PointEnvelope, axis: &RigAxis) -> Option<Diagnostic> {
    let ordered = point.torque_off.filter(|off| off.rate_rad_per_s == 0.0)?;
    let stop = &axis.guard.stop;
    if stop.holds_without_torque(ordered.from_rad) {
        return None;
    }
    let message = format!(
        "{at}: the torque is to be switched off at {}, but axis `{}` may not stay there: the load is {}, \
         static friction {}",
        Q::Angle.format(ordered.from_rad),
        axis.name,
        Q::Torque.format(stop.loads.at(ordered.from_rad).abs()),
        Q::Torque.format(stop.friction.static_nm + stop.brake_nm),
    );
    Some(Diagnostic::new(message).help("choose a pose where static friction is at least 1.3 times the load"))
}

/// In a point without closed loops the other axes have no torque: friction must hold them.
fn drops(at: &str, case: &Case, rig: &Rig) -> Option<Diagnostic> {
    let falls = |axis: &&RigAxis| {
        let pose = case.start_pose_rad.get(&axis.name);
        pose.is_some_and(|&rad| !axis.guard.stop.holds_without_torque(rad))
    };
    let axis = rig.axes.iter().filter(|_| case.open_loop).find(falls)?;
    let pose_rad = case.start_pose_rad.get(&axis.name).copied()?;
    let stop = &axis.guard.stop;
    let message = format!(
        "{at}: no loop is closed, and axis `{}` does not stay at {}: the load is {}, static friction {}",
        axis.name,
        Q::Angle.format(pose_rad),
        Q::Torque.format(stop.loads.at(pose_rad).abs()),
        Q::Torque.format(stop.friction.static_nm + stop.brake_nm),
    );
    Some(Diagnostic::new(message).help("begin where static friction is at least 1.3 times the load"))
}

fn too_hot(found: &ProcedureEnvelope, axis: &RigAxis) -> Option<Diagnostic> {
    let allowed = axis.guard.safety.continuous_torque_nm;
    if found.rms_torque_nm <= allowed * (1.0 + ROUNDING) {
        return None;
    }
    let message = format!(
        "{}, point `{}`: axis `{}` needs {} root mean square (time constant {}), but can sustain only {}",
        found.procedure,
        found.rms_point,
        axis.name,
        Q::Torque.format(found.rms_torque_nm),
        Q::Time.format(axis.guard.safety.thermal_time_s),
        Q::Torque.format(allowed)
    );
    Some(Diagnostic::new(message).help("reduce the acceleration, use fewer cycles, or dwell longer"))
}
