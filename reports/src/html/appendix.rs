//! Deviations, test bench, raw-data index, and the end of the report.

use procedures::verdict::Verdict;

use super::{anchor, badge, section, table_head, title};
use crate::markup::Markup;
use crate::number;
use crate::record::{LawRecord, Results, Status};
use crate::words;

/// Everything after the procedures and the safety page.
pub(super) fn write(m: &mut Markup, results: &Results) {
    deviations(m, results);
    prompts(m, results);
    waivers(m, results);
    index(m, results);
    m.open("footer", &[]);
    m.element(
        "p",
        &[],
        "Results relate only to the item tested. This report shall not be reproduced except in full.",
    );
    m.element("p", &[("class", "end")], "— End of report —");
    m.close();
}

fn deviations(m: &mut Markup, results: &Results) {
    section(m, "deviations", "Deviations and incidents");
    let lines = incidents(results);
    if lines.is_empty() {
        m.element("p", &[], "None recorded.");
    } else {
        m.open("ul", &[]);
        for line in lines {
            m.element("li", &[], &line);
        }
        m.close();
    }
    m.close();
}

fn incidents(results: &Results) -> Vec<String> {
    let mut lines = Vec::new();
    for interruption in &results.record.interruptions {
        lines.push(format!("{}: interrupted, {}", interruption.utc, interruption.reason));
    }
    for a in results.record.attempts.iter().filter(|a| a.attempt > 1 || a.status != Status::Completed) {
        let reason = a.reason.as_deref().map_or(String::new(), |r| format!(": {r}"));
        lines.push(format!("{} attempt {} ({}) {}{reason}", a.procedure, a.attempt, a.file, a.status.word()));
    }
    for procedure in &results.findings.procedures {
        for point in procedure.points.iter().filter(|p| p.status != Status::Completed) {
            let reason = point.reason.as_deref().map_or(String::new(), |r| format!(": {r}"));
            lines.push(format!("{}, {} {}{reason}", procedure.id, point.point, point.status.word()));
        }
    }
    lines
}

/// What the operator was asked, and said.
fn prompts(m: &mut Markup, results: &Results) {
    section(m, "prompts", "Questions to the operator");
    if results.record.prompts.is_empty() {
        m.element("p", &[], "None recorded.");
        return m.close();
    }
    m.open("table", &[]);
    let heads = ["Asked by", "Class", "Question", "Answer", "By", "How", "When, UTC"];
    table_head(m, &heads.map(|head| ("", head)));
    m.open("tbody", &[]);
    for p in &results.record.prompts {
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], &p.asked_by);
        for cell in [&p.class, &p.text, &p.answer, &p.by, &p.how, &p.utc] {
            m.element("td", &[], cell);
        }
        m.close();
    }
    m.close();
    m.close();
    m.close();
}

fn waivers(m: &mut Markup, results: &Results) {
    let record = &results.record;
    section(m, "waivers", "Waivers");
    if record.waivers.is_empty() {
        m.element("p", &[], "None on record.");
        return m.close();
    }
    m.element(
        "p",
        &[("class", "note")],
        "A waiver does not change a verdict; it records who accepts the finding.",
    );
    m.open("table", &[]);
    let heads = ["Number", "Requirement", "Verdict", "Approved by", "Valid until", "Reason and conditions"];
    table_head(m, &heads.map(|head| ("", head)));
    m.open("tbody", &[]);
    for waiver in &record.waivers {
        let verdict = results.findings.outcome(&waiver.requirement).map_or(Verdict::None, |o| o.verdict);
        let expired = if record.has_expired(waiver) { " (EXPIRED)" } else { "" };
        let needless = if verdict == Verdict::Pass { " (not needed: it passed)" } else { "" };
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], &waiver.number);
        let to = format!("#{}", anchor(&waiver.requirement));
        m.within("td", &[], |m| m.element("a", &[("href", &to)], &waiver.requirement));
        m.within("td", &[], |m| badge(m, words::verdict(verdict)));
        m.element("td", &[], &waiver.approver);
        m.element("td", &[], &format!("{}{expired}", waiver.expiry));
        m.element("td", &[], &format!("{}{needless}", waiver.reason));
        m.close();
    }
    m.close();
    m.close();
    m.close();
}

/// The test bench: software, command, devices with their identity.
pub(super) fn bench(m: &mut Markup, results: &Results) {
    let record = &results.record;
    section(m, "bench", "Test bench");
    m.open("table", &[("class", "bench")]);
    m.open("tbody", &[]);
    let mut rows = vec![
        ("Software", title::software(results)),
        ("Command", record.command_line.clone()),
        ("Numeric profile", record.numeric_profile.clone().unwrap_or_else(|| "—".to_owned())),
        ("Jobs", record.jobs.to_string()),
        ("Processor time", format!("{} s", number::short(record.cpu_s, 3))),
    ];
    if let Some(factor) = record.speed_factor {
        rows.push(("Simulated time per processor time", number::short(factor, 3)));
    }
    let laws: Vec<_> =
        record.laws.iter().map(|law| (format!("Velocity law, {}", law.axis), law_in_words(law))).collect();
    rows.extend(laws.iter().map(|(name, value)| (name.as_str(), value.clone())));
    for (name, value) in rows {
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], name);
        m.element("td", &[], &value);
        m.close();
    }
    m.close();
    m.close();
    devices(m, results);
    instruments(m, results);
    m.close();
}

/// An external law: who it is, and which build of it.
fn law_in_words(law: &LawRecord) -> String {
    let LawRecord { name, version, file, sha256, hosting, .. } = law;
    format!("{name} {version}, external ({file}, SHA-256 {sha256}), {hosting}")
}

fn instruments(m: &mut Markup, results: &Results) {
    if results.record.instruments.is_empty() {
        return;
    }
    m.open("table", &[]);
    let heads =
        ["Instrument", "Role", "Maker, model", "Serial number", "Certificate", "Uncertainty", "Calibration"];
    table_head(m, &heads.map(|head| ("", head)));
    m.open("tbody", &[]);
    let cell = |text: &Option<String>| text.clone().unwrap_or_else(|| "—".to_owned());
    for i in &results.record.instruments {
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], &i.name);
        let which: Vec<&str> = i.maker.iter().chain(&i.model).map(String::as_str).collect();
        let which = if which.is_empty() { "—".to_owned() } else { which.join(" ") };
        let cells =
            [i.role.clone(), which, cell(&i.serial_number), cell(&i.certificate), cell(&i.uncertainty)];
        for text in cells.iter().chain([&i.status]) {
            m.element("td", &[], text);
        }
        m.close();
    }
    m.close();
    m.close();
}

fn devices(m: &mut Markup, results: &Results) {
    if results.record.devices.is_empty() {
        return;
    }
    m.open("table", &[]);
    table_head(m, &[("", "Device"), ("", "Identity"), ("", "Real"), ("", "Grounds")]);
    m.open("tbody", &[]);
    for device in &results.record.devices {
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], &device.name);
        m.element("td", &[], &device.identity);
        m.element("td", &[], if device.proven_real { "real" } else { "SIMULATED" });
        m.element("td", &[], &device.grounds);
        m.close();
    }
    m.close();
    m.close();
}

fn index(m: &mut Markup, results: &Results) {
    section(m, "raw-data", "Raw-data index");
    // What is there now, where somebody has looked; else what the run says that it left.
    let files = results.evidence.as_ref().map_or(&results.record.files, |evidence| &evidence.files);
    if files.is_empty() {
        m.element("p", &[], "No files recorded.");
        return m.close();
    }
    m.open("table", &[]);
    table_head(m, &[("", "File"), ("n", "Size, bytes"), ("", "SHA-256")]);
    m.open("tbody", &[]);
    for file in files {
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], &file.file);
        m.element("td", &[("class", "n")], &number::grouped(file.size_bytes));
        m.within("td", &[], |m| m.element("code", &[("class", "digest")], &file.sha256));
        m.close();
    }
    m.close();
    m.close();
    m.close();
}

#[cfg(test)]
mod tests {
    use crate::{html, sample};

    /// The part of the page from this anchor to the end of its section.
    fn part<'a>(page: &'a str, id: &str) -> &'a str {
        let from = page.find(&format!("id=\"{id}\"")).expect("the section is there");
        page[from..].split("</section>").next().expect("a section ends")
    }

    #[test]
    fn a_waiver_stands_in_summary_matrix_and_list_and_changes_no_verdict() {
        let with = sample::results();
        let mut without = with.clone();
        without.record.waivers.clear();
        assert_eq!(with.findings, without.findings);
        let page = html::render(&with);
        for id in ["waivers", "requirement-FRC-AZ"] {
            assert!(part(&page, id).contains("W-17"), "{id}");
        }
        assert!(page.contains("Waiver W-17."), "beside the shortfall");
        assert!(!page.contains("EXPIRED"));
        assert!(part(&html::render(&without), "waivers").contains("None on record."));
    }

    #[test]
    fn a_waiver_that_held_until_yesterday_is_marked_and_its_shortfall_stays_open() {
        let mut results = sample::results();
        results.record.waivers[0].expiry = "2026-11-20".to_owned();
        let page = html::render(&results);
        assert!(page.contains("Waiver W-17, EXPIRED."));
        assert!(page.contains("Shortfalls without a valid waiver: FRC-AZ"), "named as open");
    }

    #[test]
    fn questions_stand_with_their_answers_and_who_gave_them() {
        let page = html::render(&sample::results());
        let section = part(&page, "prompts");
        for text in ["nobody near it?", "<td>yes</td>", "A. Tester", "terminal", "2026-11-21T15:00:02Z"] {
            assert!(section.contains(text), "{text}");
        }
    }

    #[test]
    fn a_procedure_that_took_longer_than_planned_is_named_on_the_first_page() {
        let mut results = sample::results();
        let named = "AZ-FRICTION (7 min 30 s instead of 6 min 42 s)";
        assert!(html::render(&results).contains(named), "449.5 s are 12 % above 402 s");
        results.record.attempts[0].ran_s = Some(430.0);
        assert!(!html::render(&results).contains(named), "power-up and stops are in no plan");
    }
}
