//! `report.md`: the result as Markdown tables, for merge requests and tickets.

use std::fmt::Write;

use crate::record::{Findings, ProcedureFindings, Results};
use crate::row::{self, Row};
use crate::{printable, safety, words};

/// The whole document.
pub fn render(results: &Results) -> String {
    let findings = &results.findings;
    let sign = words::overall(findings.overall);
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "# {}\n", text(&words::heading(results)));
    if let Some(word) = words::watermark(findings.origin) {
        let _ = writeln!(out, "**{word}**\n");
    }
    let counts: Vec<String> =
        words::tally(findings).into_iter().map(|(sign, n)| format!("{n} {}", sign.word)).collect();
    let _ = writeln!(out, "**{} {}** ({})\n", sign.symbol, sign.word, counts.join(", "));
    let _ = writeln!(
        out,
        "Unit {}, campaign {}, seed {}.\n",
        text(&findings.unit),
        text(&findings.campaign.id),
        findings.seed
    );
    if let Some(sentence) = words::screening(findings) {
        let _ = writeln!(out, "{sentence}.\n");
    }
    let evidence = text(&words::evidence(results));
    let loud = if words::evidence_mark(results).is_some() { "**" } else { "" };
    let _ = writeln!(out, "{loud}Evidence: {evidence}.{loud}\n");
    if let Some(alarm) = safety::alarm(findings) {
        let _ = writeln!(out, "**Safety: {}**\n", text(&alarm));
    }
    for sentence in &findings.disagreements {
        let _ = writeln!(out, "**Estimates disagree: {}**\n", text(sentence));
    }
    let rows = row::rows(findings);
    requirements(&mut out, &rows);
    not_measured(&mut out, &rows, &row::named_only(findings));
    for procedure in &findings.procedures {
        section(&mut out, procedure);
    }
    safety_page(&mut out, findings);
    let _ = writeln!(out, "## Statement of conformity\n");
    for sentence in words::statement(findings) {
        let _ = writeln!(out, "- {}", text(&sentence));
    }
    out
}

fn requirements(out: &mut String, rows: &[Row<'_>]) {
    let _ = writeln!(out, "## Requirements\n");
    let _ = writeln!(out, "| Requirement | Value | U | Limit | Rule | Margin | Verdict | Evidence |");
    let _ = writeln!(out, "| --- | ---: | ---: | --- | --- | ---: | --- | --- |");
    for row in row::shortfalls_first(rows) {
        let Some(evidence) = &row.evidence else { continue };
        let reason = row.reason.as_deref().map_or(String::new(), |r| format!(": {r}"));
        let point = evidence.point.map_or(String::new(), |p| format!(", {p}"));
        let cells = [
            row.requirement.id.clone(),
            row.value.clone(),
            row.expanded_u.clone(),
            row.named_limit(),
            row.rule.to_owned(),
            row.margin.clone(),
            format!("{} {}{reason}", row.sign.symbol, row.sign.word),
            format!("{}{point}", evidence.procedure),
        ];
        table_row(out, &cells);
    }
    out.push('\n');
}

fn not_measured(out: &mut String, rows: &[Row<'_>], named: &[(&str, Vec<&str>)]) {
    let missing: Vec<&Row<'_>> = rows.iter().filter(|r| r.evidence.is_none()).collect();
    if missing.is_empty() && named.is_empty() {
        return;
    }
    let _ = writeln!(out, "## Not measured\n");
    for row in missing {
        let required = if row.requirement.required { "**required**, " } else { "" };
        let reason = row.reason.as_deref().unwrap_or("not measured");
        let _ = writeln!(out, "- {}: {required}{}", text(&row.requirement.id), text(reason));
    }
    for (why, ids) in named {
        let _ = writeln!(out, "- {}: {why}", text(&ids.join(", ")));
    }
    out.push('\n');
}

fn section(out: &mut String, procedure: &ProcedureFindings) {
    let sign = words::verdict(procedure.verdict);
    let _ = writeln!(out, "## {}: {}\n", text(&procedure.id), text(&procedure.title));
    let _ = writeln!(
        out,
        "{} {}, {}, kind {}, axis {}{}\n",
        sign.symbol,
        sign.word,
        procedure.status.word(),
        text(&procedure.kind),
        text(&procedure.axis),
        procedure.state.as_deref().map_or_else(String::new, |state| {
            format!(", build state {}: reported, not judged", text(state))
        })
    );
    if !procedure.measurements.is_empty() {
        let _ = writeln!(out, "| Measurand | Point | Value | U | Verdict | Notes |");
        let _ = writeln!(out, "| --- | --- | ---: | ---: | --- | --- |");
        for (index, m) in procedure.measurements.iter().enumerate() {
            let (value, u) = row::value_cells(procedure, index, m);
            let verdicts: Vec<String> = procedure
                .judgements_of(index)
                .map(|j| format!("{} {}", j.requirement, words::verdict(j.verdict).word))
                .collect();
            let notes = row::measurement_notes(m).join("; ");
            let point = m.point.clone().unwrap_or_default();
            table_row(out, &[m.measurand.clone(), point, value, u, verdicts.join(", "), notes]);
        }
        out.push('\n');
    }
    for remark in &procedure.remarks {
        let _ = writeln!(out, "- {}", text(remark));
    }
    if !procedure.remarks.is_empty() {
        out.push('\n');
    }
}

fn safety_page(out: &mut String, findings: &Findings) {
    if !safety::is_known(findings) {
        return;
    }
    let _ = writeln!(out, "## Safety\n\n{}\n", text(&safety::summary(findings)));
    table(out, &safety::TRIP_HEAD, &safety::trips(findings));
    let stops: Vec<[String; 9]> = safety::stops(findings)
        .into_iter()
        .map(|([a, b, c, d, e, f, g, h], stop)| {
            let sign = words::against_computed(stop);
            [a, b, c, d, e, f, g, h, format!("{} {}", sign.symbol, sign.word)]
        })
        .collect();
    table(out, &safety::STOP_HEAD, &stops);
    table(out, &safety::WORST_HEAD, &safety::worst(findings));
    table(out, &safety::LEFT_HEAD, &safety::left(findings));
    table(out, &safety::NOT_ENFORCED_HEAD, &safety::not_enforced(findings));
    for risk in safety::risks(findings) {
        let _ = writeln!(out, "- residual risk: {}", text(risk));
    }
    out.push('\n');
}

/// A table; nothing without rows.
pub(crate) fn table(out: &mut String, head: &[&str], rows: &[impl AsRef<[String]>]) {
    if rows.is_empty() {
        return;
    }
    let _ = writeln!(out, "| {} |\n|{}", head.join(" | "), " --- |".repeat(head.len()));
    rows.iter().for_each(|row| table_row(out, row.as_ref()));
    out.push('\n');
}

pub(crate) fn table_row(out: &mut String, cells: &[String]) {
    let cells: Vec<String> = cells.iter().map(|c| text(c)).collect();
    let _ = writeln!(out, "| {} |", cells.join(" | "));
}

/// Text that neither ends a cell nor starts an element, emphasis or link, nor steers a terminal.
pub(crate) fn text(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '&' => out.push_str("&amp;"),
            '|' | '*' | '_' | '`' | '[' | ']' | '#' | '\\' | '!' => {
                out.push('\\');
                out.push(c);
            }
            '\n' | '\r' => out.push(' '),
            _ => out.push(printable::character(c)),
        }
    }
    out
}
