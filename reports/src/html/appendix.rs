//! Deviations, test bench, raw-data index, and the end of the report.

use super::{section, table_head, title};
use crate::markup::Markup;
use crate::number;
use crate::record::{Results, Status};

/// Everything after the procedures and the safety page.
pub(super) fn write(m: &mut Markup, results: &Results) {
    deviations(m, results);
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
        m.element("td", &[], if device.real { "real" } else { "SIMULATED" });
        m.element("td", &[], &device.grounds);
        m.close();
    }
    m.close();
    m.close();
}

fn index(m: &mut Markup, results: &Results) {
    section(m, "raw-data", "Raw-data index");
    if results.record.files.is_empty() {
        m.element("p", &[], "No files recorded.");
        return m.close();
    }
    m.open("table", &[]);
    table_head(m, &[("", "File"), ("n", "Size, bytes"), ("", "SHA-256")]);
    m.open("tbody", &[]);
    for file in &results.record.files {
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], &file.file);
        m.element("td", &[("class", "n")], &grouped(file.size_bytes));
        m.within("td", &[], |m| m.element("code", &[("class", "digest")], &file.sha256));
        m.close();
    }
    m.close();
    m.close();
    m.close();
}

/// Digits in groups of three, thin spaces between.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    out
}
