//! The table of measurements: every number with its pedigree.

use procedures::measurement::{Condition, Measurement};

use super::points::{other_axis, verdicts};
use super::{measurement_anchor, table_head};
use crate::markup::Markup;
use crate::number::{self, Shown};
use crate::record::ProcedureFindings;
use crate::row::{measurement_notes, unit_of, value_cells};

const HEAD: [(&str, &str); 9] = [
    ("", "Measurand"),
    ("n", "Value"),
    ("n", "U"),
    ("n", "u"),
    ("n", "ν"),
    ("n", "n"),
    ("", "Estimator"),
    ("", "Verdict"),
    ("", "Evidence, flags"),
];

/// The table, if there are measurements.
pub(super) fn write(m: &mut Markup, procedure: &ProcedureFindings, procedure_index: usize) {
    if procedure.measurements.is_empty() {
        return;
    }
    m.element("h3", &[], "Measurements");
    m.open("table", &[("class", "measurements")]);
    table_head(m, &HEAD);
    m.open("tbody", &[]);
    for (index, measurement) in procedure.measurements.iter().enumerate() {
        let id = measurement_anchor(procedure_index, index);
        m.open("tr", &[("id", &id)]);
        row(m, procedure, index, measurement);
        m.close();
    }
    m.close();
    m.close();
}

fn row(m: &mut Markup, procedure: &ProcedureFindings, index: usize, measurement: &Measurement) {
    let (value, expanded) = value_cells(procedure, index, measurement);
    let expanded = if expanded.starts_with("u = ") { "—".to_owned() } else { expanded };
    m.within("th", &[("scope", "row")], |m| {
        m.text(&measurement.measurand);
        let at = measurement.point.clone().unwrap_or_else(|| conditions(&measurement.conditions));
        let at: Vec<&str> = other_axis(procedure, measurement).into_iter().chain([at.as_str()]).collect();
        let at = at.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ");
        if !at.is_empty() {
            m.element("small", &[], &at);
        }
    });
    m.element("td", &[("class", "n")], &value);
    m.within("td", &[("class", "n")], |m| {
        m.text(&expanded);
        if let (Some(judgement), Some(_)) = (procedure.judgements_of(index).next(), measurement.value) {
            m.element("small", &[], &format!("k = {}", number::significant(judgement.k, 3)));
        }
    });
    m.element("td", &[("class", "n")], &standard(measurement));
    m.element("td", &[("class", "n")], &freedom(measurement));
    m.element("td", &[("class", "n")], &measurement.n.to_string());
    m.element("td", &[], &measurement.estimator);
    m.within("td", &[], |m| verdicts(m, procedure, index));
    m.within("td", &[("class", "notes")], |m| {
        let mut texts: Vec<String> = measurement.evidence.iter().map(evidence).collect();
        if measurement.point.is_none() {
            texts.extend(measurement_notes(measurement));
        }
        for (i, text) in texts.iter().enumerate() {
            if i > 0 {
                m.empty("br", &[]);
            }
            m.text(text);
        }
    });
}

fn standard(m: &Measurement) -> String {
    if m.value.is_none() {
        return "—".to_owned();
    }
    let unit = unit_of(m);
    unit.text(&unit.pair(0.0, m.u).1)
}

/// Degrees of freedom; infinite where there are none given.
fn freedom(m: &Measurement) -> String {
    match (m.value, m.dof) {
        (None, _) => "—".to_owned(),
        (_, Some(dof)) => number::short(dof, 3),
        (_, None) => "∞".to_owned(),
    }
}

fn conditions(conditions: &[Condition]) -> String {
    let text = |c: &Condition| {
        let at = c.achieved.unwrap_or(c.requested);
        let unit = Shown::of_kind(c.kind);
        format!("{} {}", c.name, unit.text(&number::short(unit.number(at), 4)))
    };
    conditions.iter().map(text).collect::<Vec<_>>().join(", ")
}

fn evidence(e: &procedures::measurement::Evidence) -> String {
    let file = if e.file.is_empty() { "log" } else { &e.file };
    format!("{file} {:.3} … {:.3} s: {}", e.t0_s, e.t1_s, e.channels.join(", "))
}
