//! Which windows of a record count, and why the others do not.

use super::channels::Record;
use super::keys::Excited;
use crate::axis::AxisLimits;
use crate::measurement::Exclusion;
use crate::quantity::QuantityKind as Q;

/// Where a window begins, in which realisation, and with which lines.
pub(super) struct Candidate {
    pub(super) start: usize,
    pub(super) realisation: usize,
    pub(super) lines_hz: Vec<f64>,
    pub(super) place: usize,
}

/// Drops windows with gaps, at the torque limit, or in which the axis turned round.
pub(super) fn usable(
    candidates: Vec<Candidate>,
    record: &Record<'_>,
    rests: bool,
    length: usize,
    limits: &AxisLimits,
    excluded: &mut Vec<Exclusion>,
) -> Vec<Candidate> {
    let mut gaps = 0;
    let mut limited = 0;
    let mut clipped = 0;
    let mut reversed = 0;
    let lasts_s = (length - 1) as f64 / limits.row_rate_hz();
    let kept = candidates.into_iter().filter(|c| {
        let rows = c.start..c.start + length;
        let took_s = record.time_s[rows.end - 1] - record.time_s[rows.start];
        let rate = &record.rate[rows.clone()];
        let turns = !rests && rate.iter().any(|r| r * rate[0] <= 0.0);
        if (took_s - lasts_s).abs() > 0.5 / limits.row_rate_hz() {
            gaps += 1;
        } else if record.is_limited(rows.clone()) {
            clipped += 1;
        } else if record.torque_nm[rows].iter().any(|t| limits.is_saturated(*t)) {
            limited += 1;
        } else if turns {
            reversed += 1;
        } else {
            return true;
        }
        false
    });
    let kept = kept.collect();
    for (count, reason) in [
        (gaps, "cycles were dropped in them"),
        (limited, "the torque was at its limit"),
        (clipped, "the drive was at a limit of its own (bit 11 of its statusword)"),
        (reversed, "the axis turned round: the contact stuck"),
    ] {
        if count > 0 {
            excluded.push(Exclusion { count, of: "windows".to_owned(), reason: reason.to_owned() });
        }
    }
    kept
}

/// The windows in which the axis slid, where those are most of them; else all, and that it did not.
pub(super) fn sliding(
    kept: Vec<Candidate>,
    keys: &Excited,
    rate: &dyn Fn(&Candidate) -> f64,
    excluded: &mut Vec<Exclusion>,
) -> (Vec<Candidate>, bool) {
    let least = keys.background.sliding_from_rad_per_s;
    let slid = |c: &Candidate| keys.background.velocity_rad_per_s > 0.0 && rate(c) >= least;
    let slow = kept.iter().filter(|c| !slid(c)).count();
    if slow == 0 || 2 * slow > kept.len() || kept.len() < slow + 2 {
        return (kept, slow == 0);
    }
    let reason = format!("the axis slid slower than {}", Q::AngularVelocity.format(least));
    excluded.push(Exclusion { count: slow, of: "windows".to_owned(), reason });
    (kept.into_iter().filter(slid).collect(), true)
}

pub(super) fn why_none(excluded: &[Exclusion]) -> String {
    let reasons: Vec<String> =
        excluded.iter().map(|e| format!("{} {}: {}", e.count, e.of, e.reason)).collect();
    match reasons.as_slice() {
        [] => "the record holds fewer than two windows of its plan".to_owned(),
        _ => format!("fewer than two windows are left: {}", reasons.join("; ")),
    }
}
