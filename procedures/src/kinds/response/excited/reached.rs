//! How large the excitation is in the log.

use std::ops::Range;

use super::channels::Record;
use crate::axis::AxisLimits;
use crate::excitation::Excitation;

/// Size of an excitation over the planned one in these rows, by projection on what was planned; a row is the mean over its ticks.
pub(super) fn ratio(
    excitation: &Excitation,
    began_s: f64,
    record: &Record<'_>,
    limits: &AxisLimits,
    rows: Range<usize>,
) -> f64 {
    let ticks = (limits.loop_rate_hz / limits.row_rate_hz()).round().max(1.0);
    let planned = |row: usize| {
        let at =
            |back: u32| excitation.at(record.time_s[row] - began_s - f64::from(back) / limits.loop_rate_hz);
        (0..ticks as u32).map(at).sum::<f64>() / ticks
    };
    let mut both = 0.0;
    let mut own = 0.0;
    for row in rows {
        let planned = planned(row);
        both += planned * record.excitation[row];
        own += planned * planned;
    }
    both / own
}
