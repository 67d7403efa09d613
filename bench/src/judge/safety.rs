//! What a log says of safety: trips, stops, how the axes were left; and what was computed before anything moved.

use procedures::diagnostic::SourceFile;
use procedures::log::{LogReader, Plan, Window};
use reports::record::{ComputedWorst, NotEnforcedFinding, SafetyFindings, StopFinding, TripFinding};

use crate::model::rig::Rig;
use crate::preflight::{self, NOT_ENFORCED};

/// Takes what happened in a point.
pub(super) fn take(safety: &mut SafetyFindings, point: &str, window: &Window) {
    let trip = |(index, reason): (usize, &String)| TripFinding {
        point: point.to_owned(),
        first_out: index == 0,
        reason: reason.clone(),
    };
    safety.trips.extend(window.trips.iter().enumerate().map(trip));
    safety.stops.extend(window.stops.iter().map(|stop| StopFinding::new(point, stop)));
    // Only the last point tells how the procedure left the axes.
    if !window.left.is_empty() {
        safety.left.clone_from(&window.left);
    }
}

/// The worst cases of a plan, from the rig file that is attached to its log; `None` where there is none that is one.
pub(super) fn computed(reader: &LogReader, plan: &Plan) -> Option<ComputedWorst> {
    let attached = reader.attachments().iter().find(|a| a.name == "rig.toml")?;
    let rig = Rig::parse(SourceFile::new(attached.name.clone(), attached.text.clone())).ok()?;
    let all = preflight::envelopes_of(&plan.procedure, &plan.axis, &plan.cases, &rig);
    let found = all.first().filter(|found| found.axis == plan.axis)?;
    let axis = rig.axes.iter().find(|a| a.name == plan.axis)?;
    let (longest, nearest) = (found.longest_stop()?, found.nearest_stop()?);
    let coast = found.coast(axis).map(|c| c.coast);
    let impact = coast.and_then(|c| c.impact);
    Some(ComputedWorst {
        stop_angle_rad: longest.angle_rad,
        stop_s: longest.time_s,
        room_rad: nearest.room_rad,
        coast_to_rad: coast.map(|c| c.end_rad),
        impact_energy_j: impact.map(|i| i.energy_j),
        impact_rad_per_s: impact.map(|i| i.speed_rad_per_s),
        risks: preflight::risks(&all, &rig),
    })
}

/// What the drives leave to the bench, for the report.
pub(super) fn not_enforced() -> Vec<NotEnforcedFinding> {
    let finding = |n: &preflight::NotEnforced| NotEnforcedFinding {
        what: n.what.to_owned(),
        watched_by: n.watched_by.to_owned(),
        why: n.why.to_owned(),
    };
    NOT_ENFORCED.iter().map(finding).collect()
}
