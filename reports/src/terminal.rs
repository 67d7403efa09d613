//! What a person at a terminal reads of a result: requirements as rows, and what stands in the way of a pass.
//!
//! The cells are those of the report, spaces that do not break made plain ones.

use procedures::verdict::Verdict;

use crate::record::Findings;
use crate::row::{self, Row, shortfall};
use crate::words;

/// Head of [`requirements`].
pub const HEAD: [&str; 6] = ["requirement", "verdict", "value", "U", "limit", "decided by"];

/// A row for each requirement and limit that was judged, shortfalls first, each in the unit of its limit.
pub fn requirements(findings: &Findings) -> Vec<[String; 6]> {
    let rows = row::rows(findings);
    let judged = row::shortfalls_first(&rows).into_iter().filter(|row| row.evidence.is_some());
    let cells = |row: &Row<'_>| {
        [
            row.requirement.id.clone(),
            row.sign.word.to_owned(),
            row.value.clone(),
            row.expanded_u.clone(),
            row.named_limit(),
            place(row),
        ]
        .map(|cell| plain(&cell))
    };
    judged.map(cells).collect()
}

/// What stands in the way of a pass, for one limit of a requirement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shortfall {
    /// Requirement id.
    pub requirement: String,
    /// Its verdict; none where nothing was measured.
    pub verdict: Verdict,
    /// The verdict as a word.
    pub word: &'static str,
    /// Value, expanded uncertainty, limit and margin, or the reason for no verdict.
    pub why: String,
    /// Procedure and point that decided; empty where nothing was measured.
    pub place: String,
}

/// Everything that did not simply pass, the worst first, and what the campaign must measure and did not.
pub fn shortfalls(findings: &Findings) -> Vec<Shortfall> {
    let rows = row::rows(findings);
    let one = |row: &Row<'_>| Shortfall {
        requirement: row.requirement.id.clone(),
        verdict: row.verdict,
        word: if row.evidence.is_some() { row.sign.word } else { "not measured" },
        why: plain(&shortfall::sentence(row)),
        place: plain(&place(row)),
    };
    shortfall::all(&rows).into_iter().map(one).collect()
}

/// A verdict as a word.
pub fn word(verdict: Verdict) -> &'static str {
    words::verdict(verdict).word
}

/// Requirements by verdict: `31 pass, 2 screened, 3 not measured`, the worst first.
pub fn counts(findings: &Findings) -> String {
    let counts = words::tally(findings).into_iter().map(|(sign, n)| format!("{n} {}", sign.word));
    counts.collect::<Vec<_>>().join(", ")
}

/// `AZ-FRICTION, velocity=10 deg/s`.
fn place(row: &Row<'_>) -> String {
    let Some(found) = &row.evidence else { return String::new() };
    let point = found.point.map_or_else(String::new, |point| format!(", {point}"));
    format!("{}{point}", found.procedure)
}

/// Rows as aligned columns, the header first.
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells: Vec<String> = row
            .iter()
            .zip(&widths)
            .map(|(cell, &w)| format!("{cell}{}", " ".repeat(w - cell.chars().count())))
            .collect();
        cells.join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

pub(crate) fn plain(text: &str) -> String {
    text.replace(['\u{a0}', '\u{202f}'], " ")
}
