//! Margins: how far a result lies inside its limit.

use super::Row;
use crate::number;
use crate::record::LimitFindings;

/// Margin over the size of the limit: the magnitude of its bound, half the width of a range. None for a bound at zero.
pub(crate) fn ratio(limit: &LimitFindings, margin: f64) -> Option<f64> {
    let size = match (limit.low, limit.high) {
        (Some(low), Some(high)) => 0.5 * (high - low),
        (low, high) => low.or(high)?.abs(),
    };
    (size > 0.0).then(|| margin / size)
}

/// Rows with an uncertainty by their distance to the guard band in expanded uncertainties, the smallest first; equal ones in the order
/// of the requirements. A percentage of a limit in dB or °C would say nothing. The roll-up finds the measurement that decides by
/// this distance, too.
pub(crate) fn worst_first<'r, 'a>(rows: &'r [Row<'a>]) -> Vec<&'r Row<'a>> {
    let distance = |row: &'r Row<'a>| Some((row.guard_distance_per_u?, row));
    let mut known: Vec<(f64, &Row<'a>)> = rows.iter().filter_map(distance).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    known.into_iter().map(|(_, row)| row).collect()
}

/// Rows with a margin and no uncertainty, such as counts.
pub(crate) fn exact<'r, 'a>(rows: &'r [Row<'a>]) -> Vec<&'r Row<'a>> {
    rows.iter().filter(|r| r.margin != "—" && r.guard_distance_per_u.is_none()).collect()
}

impl Row<'_> {
    /// The margin in per cent of the limit.
    pub(crate) fn margin_percent(&self) -> Option<String> {
        let percent = 100.0 * self.margin_ratio?;
        let digits = if percent.abs() >= 100.0 { format!("{percent:.0}") } else { number::short(percent, 2) };
        Some(format!("{} %", number::typeset(&digits)))
    }

    /// The margin in multiples of the expanded uncertainty.
    pub(crate) fn margin_in_u(&self) -> Option<String> {
        self.margin_per_u.map(in_u)
    }

    /// The distance to the guard band in multiples of the expanded uncertainty.
    pub(crate) fn guard_distance_in_u(&self) -> Option<String> {
        self.guard_distance_per_u.map(in_u)
    }
}

fn in_u(multiple: f64) -> String {
    let digits = match multiple.abs() {
        m if m >= 1e4 => if multiple > 0.0 { "> 10⁴" } else { "< −10⁴" }.to_owned(),
        m if m >= 100.0 => format!("{multiple:.0}"),
        _ => number::short(multiple, 2),
    };
    format!("{} U", number::typeset(&digits))
}
