//! Tables for spreadsheets and data frames, RFC 4180 (comma, CRLF, quotes doubled): `results.csv` has a row for each measurement and
//! requirement, `requirements.csv` one for each requirement and limit.
//!
//! Numbers in SI units have the digits that read back to the same bits. A text cell that a spreadsheet would take for a formula gets
//! an apostrophe before it.

use procedures::measurement::{Bound, Condition, Measurement};
use procedures::verdict::Judgement;

use crate::number::Shown;
use crate::record::{Findings, LimitFindings, ProcedureFindings, Results};
use crate::{printable, words};

pub mod requirements;

/// Columns that come first in both tables: which run it was.
const RUN: [&str; 5] = ["run", "campaign", "unit_under_test", "serial_number", "seed"];

const PLACE: [&str; 6] = ["stage", "procedure", "kind", "axis", "point", "measurand"];

const NUMBERS: [&str; 26] = [
    "value",
    "unit",
    "u",
    "dof",
    "n",
    "bound",
    "angle from [rad]",
    "angle to [rad]",
    "requirement",
    "rule",
    "k",
    "U",
    "low",
    "high",
    "margin",
    "value_in_limit_unit",
    "U_in_limit_unit",
    "limit_unit",
    "limit",
    "probability_outside",
    "verdict",
    "reason",
    "estimator",
    "flags",
    "log",
    "evidence",
];

/// `results.csv` with its head. Conditions have two columns each, what was asked and what was reached, their SI unit in the name.
pub fn render(results: &Results) -> String {
    let conditions = conditions(&results.findings);
    let names = conditions.iter().flat_map(|c| ["asked", "reached"].map(|which| c.column(which)));
    let head: Vec<String> = RUN
        .into_iter()
        .chain(PLACE)
        .map(str::to_owned)
        .chain(names)
        .chain(NUMBERS.map(str::to_owned))
        .collect();
    let mut out = line(&head.iter().map(|name| text(name)).collect::<Vec<_>>());
    let table = Table { results, conditions };
    for procedure in &results.findings.procedures {
        for (index, measurement) in procedure.measurements.iter().enumerate() {
            let judgements: Vec<&Judgement> = procedure.judgements_of(index).collect();
            if judgements.is_empty() {
                out += &line(&table.row(procedure, measurement, None));
            }
            for judgement in judgements {
                out += &line(&table.row(procedure, measurement, Some(judgement)));
            }
        }
    }
    out
}

/// A condition that has columns of its own.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Column {
    name: String,
    unit: &'static str,
}

impl Column {
    fn of(condition: &Condition) -> Self {
        Self { name: condition.name.clone(), unit: condition.kind.si_unit() }
    }

    /// `velocity asked [rad/s]`.
    fn column(&self, which: &str) -> String {
        format!("{} {which} [{}]", self.name, self.unit)
    }
}

/// Conditions of all measurements, by name.
fn conditions(findings: &Findings) -> Vec<Column> {
    let measurements = findings.procedures.iter().flat_map(|p| &p.measurements);
    let mut all: Vec<Column> = measurements.flat_map(|m| &m.conditions).map(Column::of).collect();
    all.sort();
    all.dedup();
    all
}

struct Table<'a> {
    results: &'a Results,
    conditions: Vec<Column>,
}

impl Table<'_> {
    fn row(&self, p: &ProcedureFindings, m: &Measurement, j: Option<&Judgement>) -> Vec<String> {
        let mut cells = run(self.results);
        cells.extend([
            text(p.stage.as_deref().unwrap_or("")),
            text(&p.id),
            text(&p.kind),
            text(&m.axis),
            text(m.point.as_deref().unwrap_or("")),
            text(&m.measurand),
        ]);
        for column in &self.conditions {
            let own = m.conditions.iter().find(|c| Column::of(c) == *column);
            cells.push(number(own.map(|c| c.requested)));
            cells.push(number(own.and_then(|c| c.achieved)));
        }
        cells.extend(self.numbers(m, j));
        cells
    }

    fn numbers(&self, m: &Measurement, j: Option<&Judgement>) -> [String; 26] {
        let requirement = j.and_then(|j| self.results.findings.requirement(&j.requirement));
        let judged = requirement.and_then(|r| r.judged(&m.measurand));
        let special = j.and_then(|j| j.limit.as_ref()).map(LimitFindings::from);
        let limit = special.as_ref().or(judged.and_then(|j| j.limit.as_ref()));
        let unit = limit.map(Shown::of_limit);
        let in_unit = |si: Option<f64>| number(unit.as_ref().zip(si).map(|(unit, si)| unit.rounded(si)));
        let has_value = m.value.is_some();
        let judged_value = j.filter(|_| has_value);
        let logs: Vec<String> =
            m.evidence.iter().map(|e| format!("{} {:.3}..{:.3} s", e.file, e.t0_s, e.t1_s)).collect();
        [
            number(m.value),
            text(m.kind.si_unit()),
            number(has_value.then_some(m.u)),
            number(m.dof),
            m.n.to_string(),
            text(m.bound.as_ref().map_or("", Bound::sign)),
            number(m.angles_rad.map(|[from_rad, _]| from_rad)),
            number(m.angles_rad.map(|[_, to_rad]| to_rad)),
            text(j.map_or("", |j| &j.requirement)),
            text(judged.map_or("", |j| j.rule.name())),
            number(judged_value.map(|j| j.k)),
            number(judged_value.map(|j| j.expanded_u)),
            number(limit.and_then(|l| l.low)),
            number(limit.and_then(|l| l.high)),
            number(j.and_then(|j| j.margin)),
            in_unit(m.value),
            in_unit(judged_value.map(|j| j.expanded_u)),
            text(unit.as_ref().map_or("", Shown::symbol)),
            text(limit.map_or("", |l| &l.text)),
            number(j.and_then(|j| j.probability_outside)),
            text(j.map_or("", |j| words::verdict(j.verdict).word)),
            text(j.and_then(|j| j.reason.as_deref()).or(m.inconclusive.as_deref()).unwrap_or("")),
            text(&m.estimator),
            text(&m.flags.join("; ")),
            text(&logs.join("; ")),
            text(evidence(self.results)),
        ]
    }
}

/// Cells under [`RUN`].
fn run(results: &Results) -> Vec<String> {
    let Results { findings, record, .. } = results;
    vec![
        text(record.run.as_deref().unwrap_or("")),
        text(&findings.campaign.id),
        text(&findings.unit),
        text(record.serial_number.as_deref().unwrap_or("")),
        findings.seed.to_string(),
    ]
}

fn evidence(results: &Results) -> &'static str {
    results.evidence.as_ref().map_or("not checked", |found| found.state.word())
}

fn number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or(String::new(), |v| format!("{v}"))
}

/// A text cell: never a formula, quoted where it must be.
fn text(text: &str) -> String {
    let text = printable::text(text);
    let formula = text.trim_start().starts_with(['=', '+', '-', '@', '|']) || text.starts_with('\t');
    let safe = if formula { format!("'{text}") } else { text };
    if safe.contains(['"', ',', '\n']) { format!("\"{}\"", safe.replace('"', "\"\"")) } else { safe }
}

fn line(cells: &[String]) -> String {
    cells.join(",") + "\r\n"
}
