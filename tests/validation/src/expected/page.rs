//! Expected results as text.

use std::fmt::Write as _;

use procedures::verdict::Verdict;

use super::Verified;

/// A table of rows, one line each.
pub fn table<'a>(rows: impl IntoIterator<Item = &'a Verified>) -> String {
    let mut text = format!(
        "{:11} {:4} {:24} {:34} {:>16} {:>12} {:>22} {:>12}  verdict\n",
        "requirement", "axis", "quantity", "condition", "expected", "U", "limit", "margin"
    );
    for row in rows {
        let e = &row.expected;
        let kind = row.kind;
        let limit = row.limit.as_ref().map_or("report only", |l| l.text.as_str());
        let margin = row.margin.map_or("-".into(), |m| short(kind.to_display(m)));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:11} {:4} {:24} {:34} {:>16} {:>12} {:>22} {:>12}  {}",
            e.requirement,
            e.axis.map_or("-", |axis| ["az", "el"][axis]),
            e.quantity,
            e.condition,
            format!("{} {}", short(kind.to_display(e.value_si)), kind.display_unit()),
            short(kind.to_display(e.uncertainty_si)),
            limit,
            margin,
            word(row.verdict),
        );
    }
    text
}

/// A verdict in a word; a fail stands out.
pub fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::None => "none",
        Verdict::Screened => "screened",
        Verdict::Pass => "pass",
        Verdict::ConditionalPass => "conditional-pass",
        Verdict::Inconclusive => "inconclusive",
        Verdict::ConditionalFail => "conditional-fail",
        Verdict::Fail => "FAIL",
    }
}

/// Four significant digits: what is expected is not known better.
fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let digits = (3 - x.abs().log10().floor() as i32).clamp(0, 9);
    format!("{x:.*}", usize::try_from(digits).unwrap_or(0))
}
