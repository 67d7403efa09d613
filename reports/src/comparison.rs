//! Two runs beside each other: what was compared, what differs, and what that rests on.
//!
//! [`RunComparison`] is data; [`text`], [`markdown`] and [`json`] are pure functions of it.

use procedures::comparison::{self, Call, Comparison, Found, PublishedTable};
use procedures::verdict::{Overall, Verdict};
use serde::Serialize;

use crate::json::to_text;
use crate::record::Findings;

mod sections;
#[cfg(test)]
mod tests;
mod written;

/// Name and version of the structure of `comparison.json`.
const SCHEMA: &str = "comparison/1";

/// A fact of the title pages, in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fact {
    /// What it is, e.g. `seed`.
    pub what: String,
    /// Of the first run.
    pub a: String,
    /// Of the second run, or of the table.
    pub b: String,
}

/// A requirement whose verdict is not the same in both runs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct VerdictChange {
    /// Its id.
    pub requirement: String,
    /// Verdict of the first run; `None` where it does not have the requirement.
    pub a: Option<Verdict>,
    /// Verdict of the second run, likewise.
    pub b: Option<Verdict>,
}

/// Two runs, or a run and a table of published values, beside each other.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunComparison {
    /// Always `comparison/1`.
    schema: &'static str,
    /// Whether every finding is the same, bit for bit.
    identical: bool,
    /// Whether a value or a curve differs beyond its uncertainty.
    differs: bool,
    /// Share of a value, or of the height of a curve, below which a difference is of no interest.
    tolerance: Option<f64>,
    /// Names of both: folders, or that of a table.
    names: [String; 2],
    /// Facts of both title pages.
    facts: Vec<Fact>,
    /// What both campaigns came to; `None` beside a table.
    overall: Option<[Overall; 2]>,
    /// Requirements whose verdict changed, in the order of the first run, then of the second one.
    verdicts: Vec<VerdictChange>,
    /// Values and curves.
    findings: Comparison,
}

impl RunComparison {
    /// Two runs. Facts come from their title pages, which this crate does not know.
    pub fn of_runs(
        names: [&str; 2],
        facts: Vec<Fact>,
        [a, b]: [&Findings; 2],
        tolerance: Option<f64>,
    ) -> Self {
        let names = names.map(str::to_owned);
        let [found_a, found_b] = [a, b].map(found);
        let findings = comparison::compare(&found_a, &found_b, tolerance);
        let verdicts = changes(a, b);
        let identical = findings.is_identical() && verdicts.is_empty() && a.overall == b.overall;
        let overall = Some([a.overall, b.overall]);
        let differs = findings.differs();
        Self { schema: SCHEMA, identical, differs, tolerance, names, facts, overall, verdicts, findings }
    }

    /// A run and published values.
    pub fn with_published(
        name: &str,
        run: &Findings,
        table: &PublishedTable,
        tolerance: Option<f64>,
    ) -> Self {
        let findings = comparison::compare_with_published(&found(run), table, tolerance);
        let differs = findings.differs();
        Self {
            schema: SCHEMA,
            identical: false,
            differs,
            tolerance,
            names: [name.to_owned(), format!("{}: {} ({})", table.id, table.title, table.source)],
            facts: Vec::new(),
            overall: None,
            verdicts: Vec::new(),
            findings,
        }
    }

    /// Whether a value or a curve differs beyond its uncertainty.
    pub fn differs(&self) -> bool {
        self.differs
    }

    /// Whether the runs have anything in common that could be compared.
    pub fn is_empty(&self) -> bool {
        self.findings.pairs() == 0 && self.findings.curves.is_empty()
    }

    /// What it comes to, in a sentence without its full stop.
    pub fn headline(&self) -> String {
        let pairs = counted(self.findings.pairs(), self.findings.curves.len());
        if self.identical {
            return format!("identical: {pairs} are the same, bit for bit");
        }
        let count = |call| self.findings.count(call);
        let ending = match count(Call::OnlyInA) + count(Call::OnlyInB) {
            0 => String::new(),
            alone => format!("; in one of the two only: {}", crate::printable::counted(alone, "value")),
        };
        match (count(Call::Differs), count(Call::Near)) {
            (0, 0) => format!("no difference beyond uncertainty in {pairs}{ending}"),
            (0, near) => format!("no difference beyond uncertainty in {pairs}, {near} near{ending}"),
            (differ, near) => {
                format!("{differ} of {pairs} differ beyond their uncertainty, {near} near{ending}")
            }
        }
    }
}

fn counted(values: usize, curves: usize) -> String {
    let values = crate::printable::counted(values, "value");
    format!("{values} and {}", crate::printable::counted(curves, "curve"))
}

fn found(findings: &Findings) -> Vec<Found<'_>> {
    let procedures = findings.procedures.iter();
    procedures.map(|p| Found { procedure: &p.id, measurements: &p.measurements, plots: &p.plots }).collect()
}

fn changes(a: &Findings, b: &Findings) -> Vec<VerdictChange> {
    let verdict = |all: &Findings, id: &str| all.outcome(id).map(|outcome| outcome.verdict);
    let change =
        |id: &str| VerdictChange { requirement: id.to_owned(), a: verdict(a, id), b: verdict(b, id) };
    let from_a = a.outcomes.iter();
    let alone = b.outcomes.iter().filter(|outcome| a.outcome(&outcome.requirement).is_none());
    let all = from_a.chain(alone).map(|outcome| change(&outcome.requirement));
    all.filter(|change| change.a != change.b).collect()
}

/// The comparison for a terminal: what differs, in aligned columns.
pub fn text(compared: &RunComparison) -> String {
    written::text(compared)
}

/// The comparison as Markdown: what differs, then every pair.
pub fn markdown(compared: &RunComparison) -> String {
    written::markdown(compared)
}

/// The comparison as data, every pair included.
pub fn json(compared: &RunComparison) -> String {
    to_text(compared)
}
