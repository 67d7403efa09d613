//! The result on one page: verdict, what stands in its way, margins worst first, coverage, durations, open points.

use super::{anchor, badge, table_head};
use crate::coverage::{Coverage, completed};
use crate::markup::Markup;
use crate::number;
use crate::record::{Findings, Origin, Results, Status};
use crate::row::{self, Row, margin, shortfall};
use crate::{safety, words};

/// Rows of the table of margins: what is farther from its limit stands in the matrix.
const MARGINS: usize = 10;
/// Ids in a cell: more make the page longer than a sheet.
const IDS: usize = 12;

const SHORTFALL_HEAD: [(&str, &str); 4] = [("", "Requirement"), ("", "Verdict"), ("", "Why"), ("", "Where")];
const MARGIN_HEAD: [(&str, &str); 8] = [
    ("", "Requirement"),
    ("n", "Value"),
    ("", "Limit"),
    ("n", "U"),
    ("n", "Margin"),
    ("n", "of limit"),
    ("n", "in U"),
    ("", "Worst at"),
];

/// The whole section.
pub(super) fn write(m: &mut Markup, results: &Results) {
    let findings = &results.findings;
    m.open("section", &[("id", "result")]);
    banner(m, findings);
    alarm(m, findings);
    let rows = row::rows(findings);
    shortfalls(m, &rows);
    margins(m, &rows);
    m.open("div", &[("class", "facts")]);
    facts(m, "Coverage", &coverage(findings));
    facts(m, "Durations", &durations(results));
    m.close();
    open_points(m, results, &rows);
    conformity(m, findings);
    m.close();
}

fn banner(m: &mut Markup, findings: &Findings) {
    let sign = words::overall(findings.overall);
    let class = format!("banner {}", sign.class);
    m.open("div", &[("class", &class), ("role", "status")]);
    m.within("p", &[("class", "overall")], |m| {
        m.element("span", &[("class", "symbol"), ("aria-hidden", "true")], sign.symbol);
        m.text(" ");
        m.text(sign.word);
    });
    let tally = words::tally(findings);
    let counts: Vec<String> = tally.iter().map(|(sign, n)| format!("{n} {}", sign.word)).collect();
    let of = Coverage::of(findings).all();
    m.open("div", &[("class", "tally")]);
    m.element("p", &[], &format!("{of} requirements: {}", counts.join(" · ")));
    m.close();
    m.close();
}

fn alarm(m: &mut Markup, findings: &Findings) {
    if let Some(alarm) = safety::alarm(findings) {
        m.within("p", &[("class", "alarm"), ("role", "status")], |m| {
            m.element("strong", &[], "Safety: ");
            m.text(&alarm);
            m.text(". ");
            m.element("a", &[("href", "#safety")], "See the safety page");
        });
    }
}

fn shortfalls(m: &mut Markup, rows: &[Row<'_>]) {
    let all = shortfall::all(rows);
    m.element("h2", &[], "Shortfalls");
    if all.is_empty() {
        m.element(
            "p",
            &[],
            "None: every requirement that was judged passed, and all that must be measured was.",
        );
        return;
    }
    m.open("table", &[("class", "result")]);
    table_head(m, &SHORTFALL_HEAD);
    m.open("tbody", &[]);
    for row in all {
        m.open("tr", &[]);
        name(m, row);
        m.within("td", &[], |m| badge(m, row.sign));
        m.element("td", &[], &shortfall::sentence(row));
        m.element("td", &[], &place(row));
        m.close();
    }
    m.close();
    m.close();
}

/// The id, leading to the row of the matrix.
fn name(m: &mut Markup, row: &Row<'_>) {
    let to = format!("#{}", anchor(&row.requirement.id));
    m.within("th", &[("scope", "row")], |m| m.element("a", &[("href", &to)], &row.requirement.id));
}

/// Procedure, point, and what was measured where the requirement judges several measurands.
fn place(row: &Row<'_>) -> String {
    let Some(evidence) = &row.evidence else { return "—".to_owned() };
    let several = row.requirement.judges.len() > 1;
    let parts = [Some(evidence.procedure), evidence.point, several.then_some(evidence.measurand)];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn margins(m: &mut Markup, rows: &[Row<'_>]) {
    let all = margin::worst_first(rows);
    let zero = margin::at_zero(rows);
    if all.is_empty() && zero.is_empty() {
        return;
    }
    m.element("h2", &[], "Margins, worst first");
    m.open("table", &[("class", "result")]);
    table_head(m, &MARGIN_HEAD);
    m.open("tbody", &[]);
    for row in all.iter().take(MARGINS) {
        m.open("tr", &[]);
        name(m, row);
        m.element("td", &[("class", "n")], &row.value);
        m.element("td", &[("class", "limit")], row.decisive_limit.as_deref().unwrap_or(&row.limit));
        for cell in [&row.expanded_u, &row.margin] {
            m.element("td", &[("class", "n")], cell);
        }
        for cell in [row.margin_percent(), row.margin_in_u()] {
            m.element("td", &[("class", "n")], cell.as_deref().unwrap_or("—"));
        }
        m.element("td", &[], &place(row));
        m.close();
    }
    m.close();
    m.close();
    m.element("p", &[("class", "note")], &margins_note(all.len(), &zero));
}

fn margins_note(count: usize, zero: &[&Row<'_>]) -> String {
    let mut text = match count.saturating_sub(MARGINS) {
        0 => String::new(),
        more => format!("{more} more, with larger margins, stand in the matrix. "),
    };
    text += "A margin is a percentage of the limit, or of half the width of a range.";
    if !zero.is_empty() {
        let one = |r: &&Row<'_>| match r.margin_in_u() {
            Some(multiple) => format!("{} {} ({multiple})", r.requirement.id, r.margin),
            None => format!("{} {}", r.requirement.id, r.margin),
        };
        text +=
            &format!(" Limits at zero have none: {}.", zero.iter().map(one).collect::<Vec<_>>().join(", "));
    }
    text
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
        ids if ids.len() > IDS => format!("{} (named behind the matrix)", ids.len()),
        ids => format!("{}: {}", ids.len(), ids.join(", ")),
    };
    vec![
        ("Measured", format!("{} of {} requirements", coverage.measured.len(), coverage.all())),
        ("Declared", named(&coverage.declared)),
        ("Required, not measured", named(&coverage.missing)),
        ("Not in this campaign", named(&coverage.elsewhere)),
        ("No kind measures it yet", named(&coverage.without_kind)),
        ("Completed", format!("{procedures} of {of_procedures} procedures, {points} of {of_points} points")),
    ]
}

fn durations(results: &Results) -> Facts {
    let record = &results.record;
    let on_rig = if results.findings.origin == Origin::Real { "On the rig" } else { "Simulated" };
    let utc = |time: &Option<String>| time.clone().unwrap_or_else(|| "—".to_owned());
    let mut facts = vec![
        (on_rig, words::duration(record.simulated_s)),
        ("By the clock", words::duration(record.wall_s)),
        ("Started", utc(&record.started_utc)),
        ("Ended", utc(&record.ended_utc)),
        ("Interruptions", record.interruptions.len().to_string()),
    ];
    if let Some(factor) = record.speed_factor {
        facts.push(("Simulated per processor time", number::short(factor, 3)));
    }
    facts
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
    let (findings, record) = (&results.findings, &results.record);
    let mut lines = Vec::new();
    let missing = record.missing_for_final();
    if !missing.is_empty() {
        lines.push(format!("Draft: a final report needs {}.", missing.join(", ")));
    }
    if findings.campaign.partial {
        lines.push("Only a selection of the campaign was run.".to_owned());
    }
    let broken: Vec<String> = findings
        .procedures
        .iter()
        .filter(|p| p.status != Status::Completed)
        .map(|p| format!("{} ({})", p.id, p.status.word()))
        .collect();
    if !broken.is_empty() {
        lines.push(format!("Procedures that did not complete: {}.", broken.join(", ")));
    }
    let repeats = record.attempts.iter().filter(|a| a.attempt > 1).count();
    if repeats > 0 {
        lines.push(format!("{repeats} procedures were repeated; see deviations and incidents."));
    }
    let unmet: Vec<&str> = rows
        .iter()
        .filter(|r| r.goal.as_deref().is_some_and(|g| g.ends_with("not met")))
        .map(|r| r.requirement.id.as_str())
        .collect();
    if !unmet.is_empty() {
        lines.push(format!("Goals beside the limit that are not met: {}.", unmet.join(", ")));
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
