//! `results.csv`: one row a measurement and requirement, RFC 4180 (comma, CRLF, quotes doubled).
//!
//! Numbers are in SI units with the digits that read back to the same bits. A text cell that a spreadsheet would take
//! for a formula gets an apostrophe before it.

use procedures::measurement::Measurement;
use procedures::verdict::Judgement;

use crate::record::{Findings, LimitFindings, ProcedureFindings, Results};
use crate::{printable, words};

const COLUMNS: [&str; 23] = [
    "procedure",
    "axis",
    "point",
    "measurand",
    "conditions",
    "value",
    "unit",
    "u",
    "dof",
    "n",
    "requirement",
    "rule",
    "k",
    "U",
    "low",
    "high",
    "margin",
    "probability_outside",
    "verdict",
    "reason",
    "estimator",
    "flags",
    "evidence",
];

/// The whole table with its head.
pub fn render(results: &Results) -> String {
    let mut out = line(&COLUMNS.map(str::to_owned));
    let evidence = results.evidence.as_ref().map_or("not checked", |found| found.state.word());
    for procedure in &results.findings.procedures {
        for (index, measurement) in procedure.measurements.iter().enumerate() {
            let judgements: Vec<&Judgement> = procedure.judgements_of(index).collect();
            if judgements.is_empty() {
                out += &line(&row((&results.findings, evidence), procedure, measurement, None));
            }
            for judgement in judgements {
                out += &line(&row((&results.findings, evidence), procedure, measurement, Some(judgement)));
            }
        }
    }
    out
}

fn row(
    (findings, evidence): (&Findings, &str),
    p: &ProcedureFindings,
    m: &Measurement,
    j: Option<&Judgement>,
) -> [String; 23] {
    let requirement = j.and_then(|j| findings.requirement(&j.requirement));
    let judged = requirement.and_then(|r| r.judged(&m.measurand));
    let special = j.and_then(|j| j.limit.as_ref()).map(LimitFindings::from);
    let limit = special.as_ref().or(judged.and_then(|j| j.limit.as_ref()));
    let reason = j.and_then(|j| j.reason.as_deref()).or(m.inconclusive.as_deref());
    let has_value = m.value.is_some();
    [
        text(&p.id),
        text(&m.axis),
        text(m.point.as_deref().unwrap_or("")),
        text(&m.measurand),
        text(&conditions(m)),
        number(m.value),
        text(m.kind.si_unit()),
        number(has_value.then_some(m.u)),
        number(m.dof),
        m.n.to_string(),
        text(j.map_or("", |j| &j.requirement)),
        text(judged.map_or("", |j| j.rule.name())),
        number(j.filter(|_| has_value).map(|j| j.k)),
        number(j.filter(|_| has_value).map(|j| j.expanded_u)),
        number(limit.and_then(|l| l.low)),
        number(limit.and_then(|l| l.high)),
        number(j.and_then(|j| j.margin)),
        number(j.and_then(|j| j.probability_outside)),
        text(j.map_or("", |j| words::verdict(j.verdict).word)),
        text(reason.unwrap_or("")),
        text(&m.estimator),
        text(&m.flags.join("; ")),
        text(evidence),
    ]
}

/// `velocity: asked 0.174 rad/s, reached 0.175`.
fn conditions(m: &Measurement) -> String {
    let one = |c: &procedures::measurement::Condition| {
        let reached = c.achieved.map_or("not reached".to_owned(), |a| format!("reached {a}"));
        format!("{}: asked {}, {reached} {}", c.name, c.requested, c.kind.si_unit())
    };
    m.conditions.iter().map(one).collect::<Vec<_>>().join("; ")
}

fn number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or(String::new(), |v| format!("{v}"))
}

/// A text cell: never a formula, quoted where it must be.
fn text(text: &str) -> String {
    let text = printable::text(text);
    let formula = text.trim_start().starts_with(['=', '+', '-', '@', '|', '%']) || text.starts_with('\t');
    let safe = if formula { format!("'{text}") } else { text };
    if safe.contains(['"', ',', '\n']) { format!("\"{}\"", safe.replace('"', "\"\"")) } else { safe }
}

fn line(cells: &[String]) -> String {
    cells.join(",") + "\r\n"
}
