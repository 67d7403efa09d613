//! The verification matrix: one row a requirement, those included that were declared or not measured.

use super::{anchor, badge, measurement_anchor, section, table_head};
use crate::markup::Markup;
use crate::number;
use crate::record::{Findings, Results, RunRecord};
use crate::row::{self, Evidence, Row};

const HEAD: [(&str, &str); 12] = [
    ("", "Requirement"),
    ("", "Demand"),
    ("", "Method"),
    ("", "Procedure and point"),
    ("", "Limit"),
    ("", "Rule"),
    ("n", "Worst result"),
    ("n", "U"),
    ("n", "Margin"),
    ("", "Verdict"),
    ("", "Evidence"),
    ("", "Waiver"),
];

/// The matrix, and what it does not cover.
pub(super) fn write(m: &mut Markup, results: &Results) {
    let findings = &results.findings;
    section(m, "requirements", "Verification matrix");
    m.element(
        "p",
        &[("class", "note")],
        "Method: T test, A analysis, I inspection, D demonstration. U is the expanded uncertainty of the \
         worst result; evidence is the log and the time on its axis. A waiver does not change a verdict; a \
         dash means that no waiver is on record.",
    );
    m.open("table", &[("class", "matrix")]);
    table_head(m, &HEAD);
    m.open("tbody", &[]);
    let rows = row::rows(findings);
    for row in &rows {
        write_row(m, results, row);
    }
    m.close();
    m.close();
    uncovered(m, findings, &rows);
    m.close();
}

fn write_row(m: &mut Markup, results: &Results, row: &Row<'_>) {
    let findings = &results.findings;
    let id = if row.is_first { anchor(&row.requirement.id) } else { String::new() };
    let class = if row.evidence.is_some() { "" } else { "uncovered" };
    m.open("tr", &[("id", &id), ("class", class)]);
    m.element("th", &[("scope", "row")], &row.requirement.id);
    m.within("td", &[], |m| demand(m, row));
    m.within("td", &[("class", "method-letter")], |m| method(m, &row.requirement.method));
    m.within("td", &[("class", "evidence")], |m| match &row.evidence {
        Some(evidence) => place(m, findings, row, evidence),
        None => m.text("—"),
    });
    m.within("td", &[("class", "limit")], |m| {
        m.text(&row.limit);
        let one_of = row.decisive_limit.as_ref().filter(|_| row.requirement.judges.len() > 1);
        small(m, one_of.map(|limit| format!("here {limit}")).as_deref());
        small(m, row.goal.as_deref());
    });
    m.element("td", &[("class", "rule")], row.rule);
    m.element("td", &[("class", "n")], &row.value);
    m.element("td", &[("class", "n")], &row.expanded_u);
    m.within("td", &[("class", "n")], |m| {
        m.text(&row.margin);
        small(m, row.margin_percent().as_deref());
        small(m, row.margin_in_u().as_deref());
    });
    m.within("td", &[], |m| verdict(m, row));
    m.within("td", &[("class", "evidence")], |m| log(m, row));
    m.within("td", &[], |m| waiver(m, &results.record, row));
    m.close();
}

/// Number, approver and last day of each waiver.
fn waiver(m: &mut Markup, record: &RunRecord, row: &Row<'_>) {
    let mut all = record.waivers_of(&row.requirement.id).peekable();
    if all.peek().is_none() {
        return m.text("—");
    }
    for waiver in all {
        m.element("a", &[("href", "#waivers")], &waiver.number);
        small(m, Some(&waiver.approver));
        let word = if record.has_expired(waiver) { "EXPIRED" } else { "until" };
        small(m, Some(&format!("{word} {}", waiver.expiry)));
    }
}

fn demand(m: &mut Markup, row: &Row<'_>) {
    let requirement = row.requirement;
    m.text(&requirement.text);
    if !requirement.claims.is_empty() {
        let claims: Vec<String> = requirement.claims.iter().map(|c| number::typeset(c)).collect();
        small(m, Some(&format!("claimed over {}", claims.join("; "))));
    }
    if !requirement.conditions.is_empty() {
        let conditions: Vec<String> = requirement.conditions.iter().map(|c| number::typeset(c)).collect();
        small(m, Some(&format!("judged where {}", conditions.join(", "))));
    }
    small(m, Some(&format!("source {}", requirement.source)));
}

/// Test, analysis, inspection and demonstration by their letters, anything else in full.
fn method(m: &mut Markup, method: &str) {
    match method {
        "test" => m.text("T"),
        "analysis" => m.text("A"),
        "inspection" => m.text("I"),
        "demonstration" => m.text("D"),
        other => m.text(other),
    }
}

fn place(m: &mut Markup, findings: &Findings, row: &Row<'_>, evidence: &Evidence<'_>) {
    let Some(index) = findings.procedures.iter().position(|p| p.id == evidence.procedure) else { return };
    let to = format!("#{}", measurement_anchor(index, evidence.measurement));
    m.element("a", &[("href", &to)], evidence.procedure);
    small(m, evidence.point);
    if row.requirement.judges.len() > 1 {
        small(m, Some(evidence.measurand));
    }
    if evidence.judged > 1 {
        small(m, Some(&format!("worst of {}", evidence.judged)));
    }
}

fn verdict(m: &mut Markup, row: &Row<'_>) {
    match (&row.evidence, &row.requirement.evidence) {
        (None, Some(_)) => m.text("declared"),
        (None, None) if row.requirement.required => m.element("strong", &[], "required, not measured"),
        (None, None) => m.text("not measured"),
        (Some(_), _) => badge(m, row.sign),
    }
    let declared = row.evidence.is_none() && row.requirement.evidence.is_some();
    small(m, row.reason.as_deref().filter(|_| !declared));
    small(
        m,
        row.probability_outside
            .as_ref()
            .map(|p| format!("P(outside)\u{a0}{}", p.replace(' ', "\u{a0}")))
            .as_deref(),
    );
}

fn log(m: &mut Markup, row: &Row<'_>) {
    match (&row.evidence, &row.requirement.evidence) {
        (None, Some(declared)) => m.text(declared),
        (None, None) => m.text("—"),
        (Some(evidence), _) => match evidence.log {
            Some(log) => {
                m.text(if log.file.is_empty() { "log" } else { &log.file });
                small(m, Some(&format!("{:.1} … {:.1} s", log.t0_s, log.t1_s)));
            }
            None => m.text("—"),
        },
    }
}

fn small(m: &mut Markup, text: Option<&str>) {
    if let Some(text) = text.filter(|t| !t.is_empty()) {
        m.element("small", &[], text);
    }
}

/// Every requirement without evidence by name, with the reason: nobody must find the gaps of the matrix by himself.
fn uncovered(m: &mut Markup, findings: &Findings, rows: &[Row<'_>]) {
    let mut by_reason: Vec<(String, Vec<&str>)> = Vec::new();
    let open = rows.iter().filter(|r| r.evidence.is_none() && r.requirement.evidence.is_none());
    let reason_of = |row: &Row<'_>| match (&row.reason, row.requirement.required) {
        (Some(reason), false) => reason.clone(),
        (Some(reason), true) => format!("required, but {reason}"),
        (None, _) => "judged, but the measurement is not in this report".to_owned(),
    };
    let known = open.map(|row| (reason_of(row), row.requirement.id.as_str()));
    let named =
        row::named_only(findings).into_iter().flat_map(|(why, ids)| ids.into_iter().map(move |id| (why, id)));
    for (why, id) in known.chain(named.map(|(why, id)| (why.to_owned(), id))) {
        match by_reason.iter_mut().find(|(known, _)| *known == why) {
            Some((_, ids)) => ids.push(id),
            None => by_reason.push((why, vec![id])),
        }
    }
    m.open("div", &[("id", "not-measured")]);
    m.element("h3", &[], "Not covered");
    if by_reason.is_empty() {
        m.element("p", &[], "None: every requirement was measured or declared.");
    }
    for (why, ids) in by_reason {
        m.element("p", &[], &format!("{}: {}.", ids.join(", "), why));
    }
    m.close();
}
