//! `requirements.csv`: a row for each requirement and limit, with the number that decided.

use super::{RUN, evidence, line, number, run, text};
use crate::number::Shown;
use crate::record::{LimitFindings, Results};
use crate::row::{self, Row};

const COLUMNS: [&str; 23] = [
    "requirement",
    "text",
    "source",
    "method",
    "must_measure",
    "measurand",
    "limit",
    "verdict",
    "value",
    "U",
    "limit_unit",
    "value_si",
    "U_si",
    "low_si",
    "high_si",
    "unit_si",
    "margin_in_U",
    "probability_outside",
    "judged",
    "procedure",
    "point",
    "reason",
    "evidence",
];

/// The whole table with its head.
pub fn render(results: &Results) -> String {
    let head: Vec<String> = RUN.into_iter().chain(COLUMNS).map(str::to_owned).collect();
    let mut out = line(&head);
    for one in row::rows(&results.findings) {
        let mut cells = run(results);
        cells.extend(cells_of(results, &one));
        out += &line(&cells);
    }
    for (why, ids) in row::named_only(&results.findings) {
        for id in ids {
            let mut cells = run(results);
            cells.extend(COLUMNS.map(|column| match column {
                "requirement" => text(id),
                "reason" => text(why),
                _ => String::new(),
            }));
            out += &line(&cells);
        }
    }
    out
}

fn cells_of(results: &Results, row: &Row<'_>) -> [String; 23] {
    let requirement = row.requirement;
    let found = row.evidence.as_ref();
    let judgement = found.map(|found| found.judgement);
    let special = judgement.and_then(|j| j.limit.as_ref()).map(LimitFindings::from);
    let judged = found.and_then(|found| requirement.judged(found.measurand));
    let limit = special.as_ref().or(judged.and_then(|j| j.limit.as_ref()));
    let measurement = found.and_then(|f| results.findings.deciding_of(f.procedure, f.judgement));
    let value = measurement.and_then(|m| m.value);
    let expanded_u = judgement.filter(|_| value.is_some()).map(|j| j.expanded_u);
    let unit = limit.map(Shown::of_limit).or(measurement.map(|m| Shown::of_kind(m.kind)));
    let in_unit = |si: Option<f64>| number(unit.as_ref().zip(si).map(|(unit, si)| unit.rounded(si)));
    let limit_text = limit.map_or(requirement.limit_text.as_str(), |limit| limit.text.as_str());
    [
        text(&requirement.id),
        text(&requirement.text),
        text(&requirement.source),
        text(&requirement.method),
        requirement.required.to_string(),
        text(found.map_or("", |found| found.measurand)),
        text(row.band.unwrap_or(limit_text)),
        text(row.sign.word),
        in_unit(value),
        in_unit(expanded_u),
        text(unit.as_ref().map_or("", Shown::symbol)),
        number(value),
        number(expanded_u),
        number(limit.and_then(|l| l.low)),
        number(limit.and_then(|l| l.high)),
        text(measurement.map_or("", |m| m.kind.si_unit())),
        number(row.margin_per_u),
        number(judgement.and_then(|j| j.probability_outside)),
        found.map_or(0, |found| found.judged).to_string(),
        text(found.map_or("", |found| found.procedure)),
        text(found.and_then(|found| found.point).unwrap_or("")),
        text(row.reason.as_deref().unwrap_or("")),
        text(evidence(results)),
    ]
}
