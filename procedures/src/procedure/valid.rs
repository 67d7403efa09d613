//! Whether a recorded point may be measured from: it completed, and it meets `valid-if`.

use super::ValidIf;
use crate::case::Case;
use crate::log::{PointStatus, Window};
use crate::measurement::{PointResult, Reduced};
use crate::reason::{Ending, Reason};

/// Topic and channel that count missed periods: each row holds how many were skipped before it.
const BENCH_TOPIC: &str = "/bench";
const MISSED_PERIODS: &str = "missed_periods";

/// Why nothing can be measured from a point that did not complete.
pub(super) fn broken_off(window: &Window) -> Option<Reason> {
    let ending = match window.status {
        PointStatus::Completed => return None,
        PointStatus::Aborted => Ending::Aborted,
        PointStatus::Errored => Ending::Errored,
        PointStatus::Lost => Ending::Lost,
    };
    Some(Reason::BrokenOff { ending, trips: window.trips.clone() })
}

/// How the point breaks the condition, if it does.
pub(super) fn breach(
    valid: &ValidIf,
    case: &Case,
    result: &PointResult,
    window: &Window,
    loop_rate_hz: f64,
) -> Option<Reason> {
    match valid {
        ValidIf::Near { condition, ratio } => far(case, result, condition, *ratio),
        ValidIf::DroppedCycles { ratio, longest_s } => dropped(window, *ratio, *longest_s, loop_rate_hz),
    }
}

/// A condition that the case asked for and that no measurement of the point reports cannot be checked: that is a
/// breach too, or the condition would hold whatever happened.
fn far(case: &Case, result: &PointResult, condition: &str, ratio: f64) -> Option<Reason> {
    let all = result.measurements.iter().flat_map(|m| &m.conditions);
    let mut reported = all.filter(|c| c.name == condition).peekable();
    let condition = condition.to_owned();
    if reported.peek().is_none() && case.requested(&condition).is_some() {
        return Some(Reason::NotReported { condition });
    }
    let found = reported.find_map(|c| match c.achieved {
        // Written so that NaN is a breach too.
        Some(achieved) if (achieved - c.requested).abs() <= ratio * c.requested.abs() => None,
        achieved => Some((c.requested, achieved)),
    });
    found.map(|(requested, achieved)| match achieved {
        None => Reason::NotReached { condition, requested },
        Some(achieved) => Reason::Far { condition, requested, achieved, allowed_ratio: ratio },
    })
}

/// Logs from elsewhere do not count missed periods: then there is nothing to check.
fn dropped(window: &Window, ratio: f64, longest_s: f64, loop_rate_hz: f64) -> Option<Reason> {
    let rows = window.rows(BENCH_TOPIC)?;
    let missed = rows.column(MISSED_PERIODS)?;
    let duration_s = rows.time_s.last()? - rows.time_s.first()?;
    let periods = (duration_s * loop_rate_hz).max(1.0);
    let share = missed.iter().sum::<f64>() / periods;
    let gap_s = missed.iter().copied().fold(0.0, f64::max) / loop_rate_hz;
    if share >= ratio {
        return Some(Reason::MissedPeriods { missed_ratio: share, allowed_ratio: ratio });
    }
    (gap_s >= longest_s).then_some(Reason::LongGap { gap_s, allowed_s: longest_s })
}

/// The point with its reason in place of every number, so that no conclusion can rest on it; pictures and remarks stay.
pub(super) fn without_numbers(mut result: PointResult, reason: Reason) -> PointResult {
    for measurement in &mut result.measurements {
        measurement.value = None;
        measurement.u = 0.0;
        measurement.dof = None;
        measurement.inconclusive = Some(reason.to_string());
    }
    result.reduced = Reduced::default();
    result.inconclusive = Some(reason);
    result
}
