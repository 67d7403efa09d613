//! What a point says all the same whose target was never locked on: that it was lost although it stood, or that the fine
//! loop did not come to rest although the target was there.

use super::dwell;
use super::frames::Frames;
use super::loss;
use super::point::{COARSE_TOPIC, FINE_TOPIC, Point};
use crate::log::{EndedBy, PointStatus, SegmentSpan};
use crate::measurement::Measurement;

/// Puts what is known in the place of what is not; `acquire` where the point did not come beyond that.
pub(super) fn amend(point: &Point<'_>, acquire: Option<&SegmentSpan>, measurements: &mut [Measurement]) {
    let dwell = acquire.and_then(|acquire| without_dwell(point, acquire));
    for found in [loss::tripped_early(point), dwell].into_iter().flatten() {
        if let Some(place) = measurements.iter_mut().find(|m| m.measurand == found.measurand) {
            *place = found;
        }
    }
}

/// The dwell within the time for the acquisition, where the coarse tracker showed the target all the while and this time was
/// long enough for a dwell.
fn without_dwell(point: &Point<'_>, acquire: &SegmentSpan) -> Option<Measurement> {
    let window_s = point.keys.dwell_window_s;
    let timed_out = acquire.ended_by == EndedBy::Timeout && point.window.status == PointStatus::Completed;
    if !(point.loops.fine() && timed_out && acquire.end_s - acquire.start_s > window_s) {
        return None;
    }
    let there = [acquire.end_s - window_s, acquire.end_s];
    let coarse = Frames::read(point.window, COARSE_TOPIC, there).ok()?;
    if !coarse.losses(acquire.end_s).is_empty() {
        return None;
    }
    let fine = Frames::read(point.window, FINE_TOPIC, point.tracked_s).ok()?;
    let mut found = dwell::measure(point, &fine);
    found.inconclusive = None;
    found.flags.push("the fine loop never locked, although the coarse tracker showed the target".to_owned());
    Some(found)
}
