//! Whether a recorded point may be measured from: it completed, and it meets `valid-if`.

use super::ValidIf;
use crate::case::Case;
use crate::condition::shown;
use crate::log::{PointStatus, Window};
use crate::measurement::{PointResult, Reduced};
use crate::quantity::QuantityKind;

/// Topic and channel that count missed periods: each row holds how many were skipped before it.
const BENCH_TOPIC: &str = "/bench";
const MISSED_PERIODS: &str = "missed_periods";

/// Why nothing can be measured from a point that did not complete.
pub(super) fn broken_off(window: &Window) -> Option<String> {
    let how = match window.status {
        PointStatus::Completed => return None,
        PointStatus::Aborted => "aborted",
        PointStatus::Errored => "broken off by an error of the bench",
        PointStatus::Lost => "lost: the log breaks off inside it",
    };
    match window.trips.as_slice() {
        [] => Some(format!("the point was {how}")),
        trips => Some(format!("the point was {how} ({})", trips.join("; "))),
    }
}

/// How the point breaks the condition, if it does.
pub(super) fn breach(
    valid: &ValidIf,
    case: &Case,
    result: &PointResult,
    window: &Window,
    loop_rate_hz: f64,
) -> Option<String> {
    match valid {
        ValidIf::Near { condition, ratio } => far(case, result, condition, *ratio),
        ValidIf::DroppedCycles { ratio, longest_s } => dropped(window, *ratio, *longest_s, loop_rate_hz),
    }
}

/// A condition that the case asked for and that no measurement of the point reports cannot be checked: that is a
/// breach too, or the condition would hold whatever happened.
fn far(case: &Case, result: &PointResult, condition: &str, ratio: f64) -> Option<String> {
    let all = result.measurements.iter().flat_map(|m| &m.conditions);
    let mut reported = all.filter(|c| c.name == condition).peekable();
    if reported.peek().is_none() && case.requested(condition).is_some() {
        return Some(format!("{condition}: no measurement of the point reports what was achieved"));
    }
    reported.find_map(|c| {
        let requested = shown(condition, c.requested);
        let Some(achieved) = c.achieved else {
            return Some(format!("{condition}: {requested} requested, not reached"));
        };
        // Written so that NaN is a breach too.
        if (achieved - c.requested).abs() <= ratio * c.requested.abs() {
            return None;
        }
        let achieved = shown(condition, achieved);
        let allowed = QuantityKind::Ratio.format(ratio);
        Some(format!("{condition}: {requested} requested, {achieved} achieved, {allowed} allowed"))
    })
}

/// Logs from elsewhere do not count missed periods: then there is nothing to check.
fn dropped(window: &Window, ratio: f64, longest_s: f64, loop_rate_hz: f64) -> Option<String> {
    let rows = window.rows(BENCH_TOPIC)?;
    let missed = rows.column(MISSED_PERIODS)?;
    let duration_s = rows.time_s.last()? - rows.time_s.first()?;
    let periods = (duration_s * loop_rate_hz).max(1.0);
    let share = missed.iter().sum::<f64>() / periods;
    let gap_s = missed.iter().copied().fold(0.0, f64::max) / loop_rate_hz;
    if share >= ratio {
        let share = QuantityKind::Ratio.format(share);
        let ratio = QuantityKind::Ratio.format(ratio);
        return Some(format!("dropped-cycles: {share} of the periods missed, less than {ratio} allowed"));
    }
    (gap_s >= longest_s).then(|| {
        let gap = QuantityKind::Time.format(gap_s);
        let longest = QuantityKind::Time.format(longest_s);
        format!("dropped-cycles: longest gap {gap}, less than {longest} allowed")
    })
}

/// The point with its reason in place of every number, so that no conclusion can rest on it; pictures and remarks stay.
pub(super) fn without_numbers(mut result: PointResult, reason: &str) -> PointResult {
    for measurement in &mut result.measurements {
        measurement.value = None;
        measurement.u = 0.0;
        measurement.dof = None;
        measurement.inconclusive = Some(reason.to_owned());
    }
    result.reduced = Reduced::default();
    result.inconclusive = Some(reason.to_owned());
    result
}
