//! One procedure: method, points, pictures, measurements, remarks.

use super::{badge, measurements, method, points, procedure_anchor, section, zoom};
use crate::markup::Markup;
use crate::plot::{self, Figure};
use crate::record::{Findings, ProcedureFindings};
use crate::words;

/// The section of the procedure of this index.
pub(super) fn write(m: &mut Markup, findings: &Findings, index: usize) {
    let Some(procedure) = findings.procedures.get(index) else { return };
    section(m, &procedure_anchor(index), &format!("{}. {}: {}", index + 1, procedure.id, procedure.title));
    summary(m, findings, procedure);
    if !procedure.method.trim().is_empty() {
        m.open("div", &[("class", "method")]);
        m.element("h3", &[], "Method");
        method::write(m, &procedure.method);
        m.close();
    }
    points::write(m, procedure);
    pictures(m, procedure, index);
    measurements::write(m, procedure, index);
    remarks(m, procedure);
    m.close();
}

fn summary(m: &mut Markup, findings: &Findings, procedure: &ProcedureFindings) {
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
    let mut ids: Vec<&str> = Vec::new();
    for requirement in &findings.requirements {
        if procedure.judgements.iter().any(|j| j.requirement == requirement.id) {
            ids.push(&requirement.id);
        }
    }
    if !ids.is_empty() {
        m.text(&format!(" · judged by {}", ids.join(", ")));
    }
    m.close();
    if let Some(log) = &procedure.log {
        m.open("p", &[("class", "summary")]);
        m.text("Log ");
        m.element("code", &[], log);
        if let Some(digest) = &procedure.log_sha256 {
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
        if let Some(shortfall) = plot::shortfall(figure) {
            m.element("small", &[], &shortfall);
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
