//! What the campaign covers, how long it took, what is open, and the statement of conformity.

use crate::coverage::{Coverage, completed};
use crate::markup::Markup;
use crate::number;
use crate::record::{Attempt, Findings, Origin, Results, RunRecord, Status};
use crate::row::{Row, shortfall};
use crate::words;

/// Ids in a cell: more make the page longer than a sheet.
const IDS: usize = 12;
/// So many procedures that took longer than planned are named.
const OVERS: usize = 3;
/// Longer than so many times the plan is told: power-up and stops are in no plan.
const OVER_PLAN: f64 = 1.1;

/// All of it.
pub(super) fn write(m: &mut Markup, results: &Results, rows: &[Row<'_>]) {
    m.open("div", &[("class", "facts")]);
    facts(m, "Coverage", &coverage(&results.findings));
    facts(m, "Durations", &durations(results));
    m.close();
    open_points(m, results, rows);
    conformity(m, &results.findings);
}

type Facts = Vec<(&'static str, String)>;

fn facts(m: &mut Markup, heading: &str, facts: &Facts) {
    m.open("div", &[]);
    m.element("h2", &[], heading);
    m.open("table", &[]);
    m.open("tbody", &[]);
    for (name, value) in facts {
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], name);
        m.element("td", &[], value);
        m.close();
    }
    m.close();
    m.close();
    m.close();
}

fn coverage(findings: &Findings) -> Facts {
    let coverage = Coverage::of(findings);
    let [[procedures, of_procedures], [points, of_points]] = completed(findings);
    let named = |ids: &[&str]| match ids {
        [] => "0".to_owned(),
        ids if ids.len() > IDS => format!("{} (listed after the matrix)", ids.len()),
        ids => format!("{}: {}", ids.len(), ids.join(", ")),
    };
    vec![
        ("Judged", format!("{} of {} requirements", coverage.judged.len(), coverage.all())),
        ("Covered in part", named(&coverage.screened)),
        ("Inconclusive", named(&coverage.inconclusive)),
        ("Reported without limit", named(&coverage.reported)),
        ("Declared", named(&coverage.declared)),
        ("Required, not measured", named(&coverage.missing)),
        ("Not in this campaign", named(&coverage.elsewhere)),
        ("Not yet measurable (no kind)", named(&coverage.without_kind)),
        ("Completed", format!("{procedures} of {of_procedures} procedures, {points} of {of_points} points")),
    ]
}

fn durations(results: &Results) -> Facts {
    let record = &results.record;
    let on_rig = if results.findings.origin == Origin::Real { "On the rig" } else { "Simulated" };
    let utc = |time: &Option<String>| time.clone().unwrap_or_else(|| "—".to_owned());
    // A log that was judged alone has no durations.
    let lasted = |s: f64| if s > 0.0 { words::duration(s) } else { "—".to_owned() };
    let mut facts = vec![
        ("Planned (maximum)", lasted(record.attempts.iter().filter_map(|a| a.planned_s).sum())),
        (on_rig, lasted(record.simulated_s)),
        ("Wall-clock time", lasted(record.wall_s)),
        ("Started", utc(&record.started_utc)),
        ("Ended", utc(&record.ended_utc)),
        ("Interruptions", record.interruptions.len().to_string()),
    ];
    if let Some(over) = over_plan(record) {
        facts.push(("Longer than planned", over));
    }
    if let Some(factor) = record.speed_factor {
        facts.push(("Simulated per processor time", number::short(factor, 3)));
    }
    facts
}

/// Procedures that took longer than was planned for them, the most exceeded first.
fn over_plan(record: &RunRecord) -> Option<String> {
    let over = |a: &'_ Attempt| Some((a.procedure.clone(), a.planned_s?, a.ran_s?));
    let mut all: Vec<(String, f64, f64)> = record.attempts.iter().filter_map(over).collect();
    if all.is_empty() {
        return None;
    }
    all.retain(|(_, planned_s, ran_s)| *ran_s > OVER_PLAN * planned_s);
    all.sort_by(|a, b| (b.2 - b.1).total_cmp(&(a.2 - a.1)));
    let one = |(id, planned_s, ran_s): &(String, f64, f64)| {
        format!("{id} ({} instead of {})", words::duration(*ran_s), words::duration(*planned_s))
    };
    let named: Vec<String> = all.iter().take(OVERS).map(one).collect();
    Some(match all.len() {
        0 => "none".to_owned(),
        n if n > OVERS => format!("{n}: {}, …; see procedures", named.join(", ")),
        _ => named.join(", "),
    })
}

fn open_points(m: &mut Markup, results: &Results, rows: &[Row<'_>]) {
    let lines = open_lines(results, rows);
    m.element("h2", &[], "Open points");
    if lines.is_empty() {
        m.element("p", &[], "None.");
        return;
    }
    m.open("ul", &[]);
    for line in lines {
        m.element("li", &[], &line);
    }
    m.close();
}

fn open_lines(results: &Results, rows: &[Row<'_>]) -> Vec<String> {
    let findings = &results.findings;
    let record = &results.record;
    let mut lines = Vec::new();
    let missing = record.missing_for_final();
    if !missing.is_empty() {
        lines.push(format!("Draft: a final report needs {}.", missing.join(", ")));
    }
    if findings.campaign.partial {
        lines.push("Only part of the campaign was run.".to_owned());
    }
    lines.extend(findings.campaign.left_out.iter().map(|left| format!("{left}.")));
    let broken: Vec<String> = findings
        .procedures
        .iter()
        .filter(|p| p.status != Status::Completed)
        .map(|p| format!("{} ({})", p.id, p.status.word()))
        .collect();
    if !broken.is_empty() {
        lines.push(format!("Procedures that did not complete: {}.", broken.join(", ")));
    }
    let unwaived = |row: &&&Row<'_>| record.waivers_of(&row.requirement.id).all(|w| record.has_expired(w));
    let short = shortfall::all(rows);
    let without: Vec<&str> = short.iter().filter(unwaived).map(|r| r.requirement.id.as_str()).collect();
    if !record.waivers.is_empty() && !without.is_empty() {
        lines.push(format!("Shortfalls without a valid waiver: {}.", without.join(", ")));
    }
    let repeats = record.attempts.iter().filter(|a| a.attempt > 1).count();
    if repeats > 0 {
        lines.push(format!("Repeated procedures: {repeats}; see deviations and incidents."));
    }
    let unmet: Vec<&str> = rows
        .iter()
        .filter(|r| r.goal.as_deref().is_some_and(|g| g.ends_with("not met")))
        .map(|r| r.requirement.id.as_str())
        .collect();
    if !unmet.is_empty() {
        lines.push(format!("Additional goals that are not met: {}.", unmet.join(", ")));
    }
    lines
}

fn conformity(m: &mut Markup, findings: &Findings) {
    m.open("div", &[("id", "conformity")]);
    m.element("h2", &[], "Statement of conformity");
    for sentence in words::statement(findings) {
        m.element("p", &[], &sentence);
    }
    m.element(
        "p",
        &[("class", "note")],
        "Conditional pass: inside the limit, but by less than the guard band. Conditional fail: outside the limit by \
         less than the guard band. U = k·u is the expanded uncertainty with k = t(0.97725, ν). P(outside) is the \
         probability that the true value lies outside the limit.",
    );
    m.close();
}
