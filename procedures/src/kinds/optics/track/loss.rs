//! Whether the target stayed in sight.

use analysis::estimate::Estimate;

use super::frames::Frames;
use super::point::{COARSE_TOPIC, FINE_TOPIC, Point};
use super::{FINE_LOSSES, GAP, LOSSES};
use crate::measurement::Measurement;

/// Name of the interlock that ends a point whose target was lost.
const INTERLOCK: &str = "tracker lost";

/// Losses of the coarse tracker from the first lock on. None in a record without a jump or reversal is no verdict.
pub(super) fn coarse(point: &Point<'_>, frames: &Frames, windows: &[Vec<[f64; 2]>; 2]) -> [Measurement; 2] {
    let stretches = frames.losses(point.tracked_s[1]);
    let tripped = tripped(point);
    let count = stretches.len().max(usize::from(tripped));
    let mut losses = counted(point, LOSSES, count, frames.time_s.len(), COARSE_TOPIC);
    losses.flags.extend(stretches.iter().map(|[from_s, to_s]| {
        let since_s = from_s - point.tracked_s[0];
        format!("lost for {:.2} s, {since_s:.2} s after the first lock", to_s - from_s)
    }));
    if tripped {
        losses.flags.push(format!("ended by interlock `{INTERLOCK}`"));
    }
    let challenges: usize = windows.iter().map(Vec::len).sum();
    losses.flags.push(format!("{challenges} jumps or reversals of the target"));
    if count == 0 {
        let untested = (challenges == 0).then(|| {
            "the target neither jumped nor turned round: its staying in sight was not put to the test"
                .to_owned()
        });
        losses.inconclusive = point.cut.clone().or(untested);
    }
    let u = frames.period_s / 6.0_f64.sqrt();
    let estimate = Estimate { value: frames.longest_gap_s(), u, dof: f64::INFINITY, n: frames.time_s.len() };
    let mut gap = point.measurement(GAP, &point.case.axis, Ok(estimate), COARSE_TOPIC);
    gap.flags.push(format!("{} frames never came", frames.missing()));
    [losses, gap]
}

/// The loss that ended a point which was too short for anything else.
pub(super) fn tripped_early(point: &Point<'_>) -> Option<Measurement> {
    let lost = point.loops.coarse() && tripped(point);
    lost.then(|| {
        let mut losses = counted(point, LOSSES, 1, 1, COARSE_TOPIC);
        losses.flags.push(format!("as soon as it was seen; ended by interlock `{INTERLOCK}`"));
        losses
    })
}

fn tripped(point: &Point<'_>) -> bool {
    point.window.trips.iter().any(|trip| trip.starts_with(INTERLOCK))
}

/// Losses of the fine tracker: beyond the mirror's stroke its field is left, and that is no loss of the target.
pub(super) fn fine(point: &Point<'_>, frames: &Frames) -> Measurement {
    let count = frames.losses(point.tracked_s[1]).len();
    counted(point, FINE_LOSSES, count, frames.time_s.len(), FINE_TOPIC)
}

fn counted(point: &Point<'_>, name: &str, count: usize, n: usize, topic: &str) -> Measurement {
    let estimate = Estimate { value: count as f64, u: 0.0, dof: f64::INFINITY, n };
    point.measurement(name, &point.case.axis, Ok(estimate), topic)
}
