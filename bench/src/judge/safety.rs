//! What a log says of safety: trips, stops, how the axes were left; and what was computed before anything moved, as the
//! run wrote it down.

use procedures::log::{Attachment, Window};
use reports::record::{ComputedWorst, NotEnforcedFinding, SafetyFindings, TripFinding};

use crate::model::axis::{NOT_ENFORCED, NotEnforced};
use crate::record::log::COMPUTED;

/// Takes what happened in a point.
pub(super) fn take(safety: &mut SafetyFindings, point: &str, window: &Window) {
    let trip = |(index, reason): (usize, &String)| TripFinding {
        point: point.to_owned(),
        first_out: index == 0,
        reason: reason.clone(),
    };
    safety.trips.extend(window.trips.iter().enumerate().map(trip));
    safety.stops.extend(window.stops.iter().map(|stop| stop.clone().of_point(point.to_owned())));
    // Only the last point tells how the procedure left the axes.
    if !window.left.is_empty() {
        safety.left.clone_from(&window.left);
    }
}

/// The worst cases that were computed before the run, from the attachment that holds them; `None` in a log without one.
///
/// # Errors
/// The mistake of an attachment that is not what it should be.
pub(super) fn computed(attachments: &[Attachment]) -> Result<Option<ComputedWorst>, serde_json::Error> {
    let attached = attachments.iter().find(|a| a.name == COMPUTED);
    attached.map(|a| serde_json::from_str(&a.text)).transpose()
}

/// What the drives leave to the bench, for the report.
pub(super) fn not_enforced() -> Vec<NotEnforcedFinding> {
    let finding = |n: &NotEnforced| NotEnforcedFinding {
        what: n.what.to_owned(),
        watched_by: n.watched_by.to_owned(),
        why: n.why.to_owned(),
    };
    NOT_ENFORCED.iter().map(finding).collect()
}
