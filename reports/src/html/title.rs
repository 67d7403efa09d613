//! The title of the report, and the facts of its title page.

use crate::markup::Markup;
use crate::record::{Origin, Results};
use crate::words;

const MISSING: &str = "—";

/// `DRAFT` while a field of a final report is missing.
pub(super) fn draft_mark(results: &Results) -> Option<&'static str> {
    (!results.record.missing_for_final().is_empty()).then_some("DRAFT")
}

/// The title.
pub(super) fn write(m: &mut Markup, results: &Results) {
    m.open("header", &[]);
    if let Some(mark) = words::evidence_mark(results) {
        m.element("p", &[("class", "draft")], mark);
    }
    if let Some(mark) = draft_mark(results) {
        m.element("p", &[("class", "draft")], mark);
    }
    m.element("h1", &[], &words::heading(results));
    subtitle(m, results);
    m.close();
}

fn subtitle(m: &mut Markup, results: &Results) {
    let findings = &results.findings;
    m.open("p", &[("class", "subtitle")]);
    m.text("Unit ");
    m.element("strong", &[], &findings.unit);
    if let Some(serial) = &results.record.serial_number {
        m.text(&format!(", serial number {serial}"));
    }
    m.text(&format!(" · campaign {} · {}", findings.campaign.id, origin_text(findings.origin)));
    m.close();
}

fn origin_text(origin: Origin) -> &'static str {
    match origin {
        Origin::Real => "real devices",
        Origin::Mixed => "partly SIMULATED",
        Origin::Simulated => "all devices SIMULATED",
        Origin::Imported => "record of another tool",
    }
}

/// Facts of the title page and of the run.
pub(super) fn facts(m: &mut Markup, results: &Results) {
    m.open("section", &[("id", "facts")]);
    m.element("h2", &[], "Report and unit under test");
    let missing = results.record.missing_for_final();
    if !missing.is_empty() {
        m.within("p", &[("class", "note")], |m| {
            m.element("strong", &[], "DRAFT. ");
            m.text(&format!("A final report needs: {}.", missing.join(", ")));
        });
    }
    m.open("div", &[("class", "facts")]);
    for column in [document(results), run(results)] {
        m.open("table", &[]);
        m.open("tbody", &[]);
        for (name, value) in column {
            m.open("tr", &[]);
            m.element("th", &[("scope", "row")], name);
            let class = if name.ends_with("digest") { "digest" } else { "" };
            m.element("td", &[("class", class)], value.as_deref().unwrap_or(MISSING));
            m.close();
        }
        m.close();
        m.close();
    }
    m.close();
    m.close();
}

type Facts = Vec<(&'static str, Option<String>)>;

fn document(results: &Results) -> Facts {
    let page = &results.record.title_page;
    vec![
        ("Report number", page.report_id.clone()),
        ("Revision", page.revision.clone()),
        ("Supersedes", page.supersedes.clone()),
        ("Issued", page.issued_utc.clone()),
        ("Classification", page.classification.clone()),
        ("Customer", page.customer.clone()),
        ("Supplier", page.supplier.clone()),
        ("Contract", page.contract.clone()),
        ("Unit", Some(results.findings.unit.clone())),
        ("Part number", page.part_number.clone()),
        ("Serial number", results.record.serial_number.clone()),
        ("Unit revision", page.unit_revision.clone()),
    ]
}

fn run(results: &Results) -> Facts {
    let record = &results.record;
    let campaign = &results.findings.campaign;
    let mut facts = vec![
        ("Campaign", Some(format!("{}: {}", campaign.id, campaign.title))),
        ("Mode", Some(origin_text(results.findings.origin).to_owned())),
        ("Seed", Some(results.findings.seed.to_string())),
        ("Location", record.title_page.location.clone()),
        ("Station, rig", join(&record.station, &record.rig)),
        ("Operator", record.operator.clone()),
        ("Started", record.started_utc.clone()),
        ("Ended", record.ended_utc.clone()),
        ("Software", Some(software(results))),
        ("Campaign digest", campaign.sha256.clone()),
        ("Requirements digest", campaign.requirements_sha256.clone()),
    ];
    if let Some(evidence) = &results.evidence {
        facts.push(("Results digest", evidence.sha256_of("results.json").map(str::to_owned)));
        facts.push(("Evidence index digest", evidence.index_sha256.clone()));
    }
    facts.extend(build_states(results).map(|text| ("Build states", Some(text))));
    facts.extend(calibrations(results).map(|text| ("Instruments", Some(text))));
    facts
}

/// Build states before the final one, with what was measured in them.
fn build_states(results: &Results) -> Option<String> {
    let mut states: Vec<(&str, Vec<&str>)> = Vec::new();
    for procedure in &results.findings.procedures {
        let Some(state) = procedure.state.as_deref() else { continue };
        match states.iter_mut().find(|(known, _)| *known == state) {
            Some((_, ids)) => ids.push(&procedure.id),
            None => states.push((state, vec![&procedure.id])),
        }
    }
    let texts: Vec<String> =
        states.iter().map(|(state, ids)| format!("{state} ({})", ids.join(", "))).collect();
    (!texts.is_empty()).then(|| format!("{}: reported, not judged; all else final", texts.join("; ")))
}

/// How many instruments are what.
fn calibrations(results: &Results) -> Option<String> {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for instrument in &results.record.instruments {
        match counts.iter_mut().find(|(status, _)| *status == instrument.status) {
            Some((_, count)) => *count += 1,
            None => counts.push((&instrument.status, 1)),
        }
    }
    let texts: Vec<String> = counts.iter().map(|(status, count)| format!("{count} {status}")).collect();
    (!texts.is_empty()).then(|| texts.join(", "))
}

fn join(a: &Option<String>, b: &Option<String>) -> Option<String> {
    match (a, b) {
        (Some(a), Some(b)) => Some(format!("{a}, {b}")),
        (a, b) => a.clone().or_else(|| b.clone()),
    }
}

/// Version and commit.
pub(super) fn software(results: &Results) -> String {
    let commit = results.record.git_commit.as_deref().map_or(String::new(), |c| format!(" ({c})"));
    format!("bench {}{commit}", results.record.software_version)
}
