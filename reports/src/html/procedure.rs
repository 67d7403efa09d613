//! One procedure: method, points, pictures, measurements, remarks.

use super::{badge, measurements, method, points, procedure_anchor, section, table_head, zoom};
use crate::markup::Markup;
use crate::plot::{self, Figure};
use crate::record::{Findings, ProcedureFindings, Results, Status};
use crate::words;

/// The section of the procedure of this index.
pub(super) fn write(m: &mut Markup, results: &Results, index: usize) {
    let findings = &results.findings;
    let Some(procedure) = findings.procedures.get(index) else { return };
    section(m, &procedure_anchor(index), &format!("{}. {}: {}", index + 1, procedure.id, procedure.title));
    summary(m, results, procedure);
    method(m, findings, index);
    points::write(m, procedure);
    pictures(m, procedure, index);
    measurements::write(m, procedure, index);
    remarks(m, procedure);
    m.close();
}

/// The method in full where its kind comes first, a link to there afterwards.
fn method(m: &mut Markup, findings: &Findings, index: usize) {
    let procedure = &findings.procedures[index];
    if procedure.method.trim().is_empty() {
        return;
    }
    let same = |p: &ProcedureFindings| p.kind == procedure.kind && p.method == procedure.method;
    let first = findings.procedures.iter().position(same).unwrap_or(index);
    if first < index {
        m.open("p", &[("class", "summary")]);
        m.text("Method: that of ");
        let to = format!("#{}", procedure_anchor(first));
        m.element("a", &[("href", &to)], &format!("{}. {}", first + 1, findings.procedures[first].id));
        return m.close();
    }
    m.open("div", &[("class", "method")]);
    m.element("h3", &[], "Method");
    method::write(m, &procedure.method);
    m.close();
}

/// Ids of the requirements that judged something of a procedure, in their order.
fn judged_by<'a>(findings: &'a Findings, procedure: &ProcedureFindings) -> Vec<&'a str> {
    let judges = |id: &str| procedure.judgements.iter().any(|j| j.requirement == id);
    findings.requirements.iter().map(|r| r.id.as_str()).filter(|id| judges(id)).collect()
}

const HEAD: [(&str, &str); 9] = [
    ("n", "No."),
    ("", "Procedure"),
    ("", "Title"),
    ("", "Status"),
    ("n", "Points"),
    ("n", "Planned"),
    ("n", "Ran"),
    ("", "Verdict"),
    ("", "Judged by"),
];

/// All procedures with what they came to: where to find what.
pub(super) fn list(m: &mut Markup, results: &Results) {
    let findings = &results.findings;
    section(m, "procedures", "Procedures");
    m.open("table", &[("class", "result")]);
    table_head(m, &HEAD);
    m.open("tbody", &[]);
    for (index, procedure) in findings.procedures.iter().enumerate() {
        let completed = procedure.points.iter().filter(|p| p.status == Status::Completed).count();
        m.open("tr", &[]);
        m.element("td", &[("class", "n")], &(index + 1).to_string());
        let to = format!("#{}", procedure_anchor(index));
        m.within("th", &[("scope", "row")], |m| m.element("a", &[("href", &to)], &procedure.id));
        m.element("td", &[], &procedure.title);
        m.element("td", &[], procedure.status.word());
        m.element("td", &[("class", "n")], &format!("{completed} of {}", procedure.points.len()));
        let attempt = results.record.attempt_at(&procedure.id);
        for duration_s in [attempt.and_then(|a| a.planned_s), attempt.and_then(|a| a.ran_s)] {
            m.element("td", &[("class", "n")], &duration_s.map_or_else(|| "—".to_owned(), words::duration));
        }
        m.within("td", &[], |m| badge(m, words::verdict(procedure.verdict)));
        m.element("td", &[], &judged_by(findings, procedure).join(", "));
        m.close();
    }
    m.close();
    m.close();
    m.close();
}

fn summary(m: &mut Markup, results: &Results, procedure: &ProcedureFindings) {
    let Results { findings, record, .. } = results;
    m.open("p", &[("class", "summary")]);
    badge(m, words::verdict(procedure.verdict));
    m.text(&format!(" · {} · kind {} · axis {}", procedure.status.word(), procedure.kind, procedure.axis));
    if let Some(stage) = &procedure.stage {
        m.text(&format!(" · stage {stage}"));
    }
    if let Some(state) = &procedure.state {
        m.text(" · ");
        m.element("strong", &[], &format!("build state {state}"));
        m.text(": reported, not judged");
    }
    let ids = judged_by(findings, procedure);
    if !ids.is_empty() {
        m.text(&format!(" · judged by {}", ids.join(", ")));
    }
    m.close();
    if let Some(log) = &procedure.log {
        m.open("p", &[("class", "summary")]);
        m.text("Log ");
        m.element("code", &[], log);
        let own = record.files.iter().find(|file| file.file == *log).map(|file| &file.sha256);
        if let Some(digest) = own.or(procedure.log_sha256.as_ref()) {
            m.text(", SHA-256 ");
            m.element("code", &[("class", "digest")], digest);
        }
        m.close();
    }
}

fn pictures(m: &mut Markup, procedure: &ProcedureFindings, index: usize) {
    for (number, figure) in Figure::all(&procedure.plots).iter().enumerate() {
        m.open("figure", &[]);
        let id = format!("plot-{}-{}", index + 1, number + 1);
        m.verbatim("\n");
        m.verbatim(plot::svg(figure, &id).trim_end());
        zoom::data(m, figure);
        let caption = format!("Figure {}.{}: {}", index + 1, number + 1, figure.head().title);
        m.open("figcaption", &[]);
        m.text(&caption);
        for note in plot::shortfall(figure).iter().chain(&plot::thinned(figure)) {
            m.element("small", &[], note);
        }
        m.close();
        m.close();
    }
}

fn remarks(m: &mut Markup, procedure: &ProcedureFindings) {
    if procedure.remarks.is_empty() {
        return;
    }
    m.element("h3", &[], "Remarks");
    m.open("ul", &[]);
    for remark in &procedure.remarks {
        m.element("li", &[], remark);
    }
    m.close();
}
