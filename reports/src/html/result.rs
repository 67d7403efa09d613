//! The result on one page: verdict, what stands in its way, margins worst first, coverage, durations, open points.

use procedures::verdict::Verdict;

use super::{anchor, badge, table_head};
use crate::coverage::Coverage;
use crate::markup::Markup;
use crate::record::{Findings, Results, RunRecord};
use crate::row::{self, Row, margin, shortfall};
use crate::{safety, words};

mod facts;

/// Rows of the table of margins: what is farther from its limit stands in the matrix.
const MARGINS: usize = 10;

const SHORTFALL_HEAD: [(&str, &str); 4] = [("", "Requirement"), ("", "Verdict"), ("", "Why"), ("", "Where")];
const MARGIN_HEAD: [(&str, &str); 8] = [
    ("", "Requirement"),
    ("n", "Value"),
    ("", "Limit"),
    ("n", "U"),
    ("n", "Margin"),
    ("n", "in U"),
    ("n", "to the guard band"),
    ("", "Worst at"),
];

/// The whole section.
pub(super) fn write(m: &mut Markup, results: &Results) {
    let findings = &results.findings;
    m.open("section", &[("id", "result")]);
    banner(m, findings);
    alarm(m, findings);
    disagreements(m, findings);
    evidence(m, results);
    let rows = row::rows(findings);
    shortfalls(m, &results.record, &rows);
    in_part(m, &rows);
    margins(m, &rows);
    facts::write(m, results, &rows);
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
    if let Some(sentence) = words::screening(findings) {
        m.element("p", &[], &format!("{sentence}."));
    }
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

/// What keeps everything from passing, before anything that would pass.
fn disagreements(m: &mut Markup, findings: &Findings) {
    for sentence in &findings.disagreements {
        m.within("p", &[("class", "alarm"), ("role", "status")], |m| {
            m.element("strong", &[], "Estimates disagree: ");
            m.text(sentence);
        });
    }
}

/// Whether the files behind this page are those of the run; loud where they are not.
fn evidence(m: &mut Markup, results: &Results) {
    let altered = words::evidence_mark(results).is_some();
    let class = if altered { "alarm" } else { "note" };
    m.within("p", &[("class", class), ("role", "status")], |m| {
        m.element("strong", &[], "Evidence: ");
        m.text(&words::evidence(results));
        m.text(".");
    });
}

/// Requirements that a first look did not measure over all that they claim, with what is missing.
fn in_part(m: &mut Markup, rows: &[Row<'_>]) {
    let mut screened: Vec<&Row<'_>> = rows.iter().filter(|row| row.verdict == Verdict::Screened).collect();
    // Limits of one requirement mostly lack the same.
    screened.dedup_by(|next, row| next.requirement.id == row.requirement.id && next.reason == row.reason);
    if screened.is_empty() {
        return;
    }
    m.element("h2", &[], "Covered in part");
    m.open("table", &[("class", "result")]);
    table_head(m, &[("", "Requirement"), ("", "Missing for a verdict")]);
    m.open("tbody", &[]);
    for row in screened {
        m.open("tr", &[]);
        name(m, row);
        m.element("td", &[], row.reason.as_deref().unwrap_or("not measured in full"));
        m.close();
    }
    m.close();
    m.close();
}

fn shortfalls(m: &mut Markup, record: &RunRecord, rows: &[Row<'_>]) {
    let all = shortfall::all(rows);
    m.element("h2", &[], "Shortfalls");
    if all.is_empty() {
        m.element(
            "p",
            &[],
            if rows.iter().any(|row| row.verdict == Verdict::Screened) {
                "None among what was measured."
            } else {
                "None: every judged requirement passed, and every required measurement was made."
            },
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
        m.within("td", &[], |m| {
            m.text(&shortfall::sentence(row));
            for waiver in record.waivers_of(&row.requirement.id) {
                let expired = if record.has_expired(waiver) { ", EXPIRED" } else { "" };
                m.element("strong", &[], &format!(" Waiver {}{expired}.", waiver.number));
            }
        });
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
    let exact = margin::exact(rows);
    if all.is_empty() && exact.is_empty() {
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
        for cell in [row.margin_in_u(), row.guard_distance_in_u()] {
            m.element("td", &[("class", "n")], cell.as_deref().unwrap_or("—"));
        }
        m.element("td", &[], &place(row));
        m.close();
    }
    m.close();
    m.close();
    m.element("p", &[("class", "note")], &margins_note(all.len(), &exact));
}

fn margins_note(count: usize, exact: &[&Row<'_>]) -> String {
    let mut text = match count.saturating_sub(MARGINS) {
        0 => String::new(),
        more => format!("{more} more, with larger margins, are in the matrix. "),
    };
    text += "Sorted by distance to the guard band, in expanded uncertainties.";
    if !exact.is_empty() {
        let one = |r: &&Row<'_>| format!("{} {}", r.requirement.id, r.margin);
        let all: Vec<String> = exact.iter().map(one).collect();
        text += &format!(" Without uncertainty: {}.", all.join(", "));
    }
    text
}
