//! `report.html`: one self-contained page that is handed to a customer.
//!
//! Style, pictures and what zooms into them are inline, nothing is fetched. Without scripts, and on paper, the
//! pictures stand as they are. It prints on A4 with page numbers. The contents follow ISO/IEC 17025:2017 7.8 as far as a run knows them; what a final report needs and nobody has given
//! is a dash under a DRAFT mark.

use crate::markup::Markup;
use crate::record::Results;
use crate::words;

mod appendix;
mod matrix;
mod measurements;
mod method;
mod points;
mod procedure;
mod realtime;
mod result;
mod safety;
mod title;
mod zoom;

/// What a browser lets the page do: nothing is fetched, and nothing but what stands in the page is run.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

const STYLE: &str = include_str!("html/report.css");

/// The whole page.
pub fn render(results: &Results) -> String {
    let mut m = Markup::default();
    m.verbatim("<!DOCTYPE html>");
    m.open("html", &[("lang", "en")]);
    head(&mut m, results);
    m.open("body", &[]);
    if let Some(word) = words::watermark(results.findings.origin) {
        m.element("div", &[("class", "watermark"), ("aria-hidden", "true")], word);
    }
    m.open("main", &[]);
    title::write(&mut m, results);
    result::write(&mut m, results);
    title::facts(&mut m, results);
    appendix::bench(&mut m, results);
    realtime::write(&mut m, results);
    matrix::write(&mut m, results);
    procedure::list(&mut m, results);
    for index in 0..results.findings.procedures.len() {
        procedure::write(&mut m, results, index);
    }
    safety::write(&mut m, &results.findings);
    appendix::write(&mut m, results);
    m.close();
    if has_pictures(results) {
        zoom::script(&mut m);
    }
    m.finish()
}

fn has_pictures(results: &Results) -> bool {
    results.findings.procedures.iter().any(|p| !p.plots.is_empty()) || !results.record.lateness.is_empty()
}

fn head(m: &mut Markup, results: &Results) {
    m.open("head", &[]);
    m.empty("meta", &[("charset", "utf-8")]);
    m.empty("meta", &[("name", "viewport"), ("content", "width=device-width, initial-scale=1")]);
    m.empty("meta", &[("http-equiv", "Content-Security-Policy"), ("content", POLICY)]);
    m.element("title", &[], &words::heading(results));
    m.open("style", &[]);
    m.verbatim(STYLE);
    if has_pictures(results) {
        m.verbatim(zoom::STYLE);
        m.verbatim("\n");
    }
    m.verbatim(&running_head(results));
    m.close();
    m.close();
}

/// Texts in the margins of printed pages. They stand in the style sheet, so only plain letters and digits pass.
fn running_head(results: &Results) -> String {
    let plain = |text: &str| -> String {
        text.chars().filter(|c| c.is_ascii_alphanumeric() || " ._-".contains(*c)).take(60).collect()
    };
    let number = results.record.title_page.report_id.as_deref().unwrap_or("no report number");
    let left = format!(
        "{} · {} · {}",
        plain(number),
        plain(&results.findings.campaign.id),
        plain(&results.findings.unit)
    );
    let watermark = words::watermark(results.findings.origin);
    let marks: Vec<&str> = words::evidence_mark(results)
        .into_iter()
        .chain(title::draft_mark(results))
        .chain(watermark)
        .collect();
    format!(
        "@page {{ @top-left {{ content: \"{left}\"; }} @top-right {{ content: \"{}\"; }} }}\n",
        marks.join(" · ")
    )
}

/// Heading of a section, with an anchor.
fn section(m: &mut Markup, id: &str, heading: &str) {
    m.open("section", &[("id", id)]);
    m.element("h2", &[], heading);
}

/// A verdict as symbol, word and colour.
fn badge(m: &mut Markup, sign: words::Sign) {
    let class = format!("badge {}", sign.class);
    m.within("span", &[("class", &class)], |m| {
        m.element("span", &[("class", "symbol"), ("aria-hidden", "true")], sign.symbol);
        m.text(" ");
        m.text(sign.word);
    });
}

/// The head of a table.
fn table_head(m: &mut Markup, cells: &[(&str, &str)]) {
    m.open("thead", &[]);
    m.open("tr", &[]);
    for (class, text) in cells {
        m.element("th", &[("scope", "col"), ("class", class)], text);
    }
    m.close();
    m.close();
}

/// Anchor of a requirement.
fn anchor(requirement: &str) -> String {
    let letters = requirement.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' });
    format!("requirement-{}", letters.collect::<String>())
}

/// Anchor of a procedure.
fn procedure_anchor(index: usize) -> String {
    format!("procedure-{}", index + 1)
}

/// Anchor of a measurement of a procedure.
fn measurement_anchor(procedure: usize, measurement: usize) -> String {
    format!("procedure-{}-measurement-{}", procedure + 1, measurement + 1)
}
