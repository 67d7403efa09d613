//! The end of a run as a person or a program reads it: verdict, what stands in its way, what did not come to its end, the report.

use std::path::{Path, PathBuf};

use procedures::verdict::{Overall, Verdict};
use reports::record::{Results, Status};
use reports::terminal;

use crate::campaign::RunResult;
use crate::cli::output::Columns;
use crate::people::event::{Part, RunEvent, Shortfall};

/// Procedures that ended alike, and not as planned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Unfinished {
    /// How they ended.
    pub(super) status: Status,
    /// Why.
    pub(super) reason: String,
    /// Their ids.
    pub(super) procedures: Vec<String>,
}

/// Procedures that did not come to their end, those with one reason together.
pub(super) fn unfinished(result: &RunResult) -> Vec<Unfinished> {
    let mut all: Vec<Unfinished> = Vec::new();
    for (planned, run) in result.page.procedures.iter().zip(&result.runs) {
        if run.status == Status::Completed {
            continue;
        }
        let reason = run.reason.clone().unwrap_or_default();
        match all.iter_mut().find(|other| other.status == run.status && other.reason == reason) {
            Some(other) => other.procedures.push(planned.id.clone()),
            None => {
                all.push(Unfinished { status: run.status, reason, procedures: vec![planned.id.clone()] });
            }
        }
    }
    all
}

/// What a run came to.
pub(super) struct End<'a> {
    pub(super) results: &'a Results,
    pub(super) unfinished: &'a [Unfinished],
    /// The overall verdict in words.
    pub(super) overall: &'a str,
    pub(super) folder: &'a Path,
}

/// Requirements with one verdict for one reason.
struct Together {
    word: &'static str,
    verdict: Verdict,
    requirements: Vec<String>,
    why: String,
    place: String,
}

impl End<'_> {
    /// For programs.
    pub(super) fn event(&self, exit_code: u8) -> RunEvent {
        let shortfalls = terminal::shortfalls(&self.results.findings).into_iter().map(|one| Shortfall {
            requirement: one.requirement,
            verdict: one.word.to_owned(),
            why: one.why,
            place: one.place,
        });
        RunEvent::RunEnded {
            overall: self.overall.to_owned(),
            exit_code,
            counts: terminal::counts(&self.results.findings),
            shortfalls: shortfalls.collect(),
            report: self.report().map(|path| path.display().to_string()),
        }
    }

    fn report(&self) -> Option<PathBuf> {
        Some(self.folder.join("report.html")).filter(|path| path.is_file())
    }

    /// For people.
    pub(super) fn parts(&self, columns: Columns) -> Vec<Part> {
        let findings = &self.results.findings;
        let mut parts = vec![
            Part::plain(format!("{}: ", findings.campaign.id)),
            Part::coloured(self.overall, colour(findings.overall)),
        ];
        let together = self.together();
        let width = together.iter().map(|one| one.word.len()).max().unwrap_or(0) + INDENT;
        for one in &together {
            let place = if one.place.is_empty() { String::new() } else { format!(" ({})", one.place) };
            let text = columns.hanging(width, &format!("{}: {}{place}", one.requirements.join(" "), one.why));
            let gap = " ".repeat(width - INDENT / 2 - one.word.len());
            parts.push(Part::plain(format!("\n{}", " ".repeat(INDENT / 2))));
            parts.push(Part::coloured(one.word, one.verdict));
            parts.push(Part::plain(format!("{gap}{text}")));
        }
        let tail = self.tail().into_iter().map(|line| columns.hanging(INDENT / 2, &line));
        parts.extend(tail.map(|line| Part::plain(format!("\n{}{line}", " ".repeat(INDENT / 2)))));
        parts
    }

    /// What follows the shortfalls.
    fn tail(&self) -> Vec<String> {
        let Results { findings, record, .. } = self.results;
        let counts = Some(terminal::counts(findings)).filter(|counts| !counts.is_empty());
        let mut lines: Vec<String> =
            counts.map(|counts| format!("requirements: {counts}")).into_iter().collect();
        for one in self.unfinished {
            let reason = if one.reason.is_empty() { String::new() } else { format!(": {}", one.reason) };
            lines.push(format!("{} {}{reason}", one.status.word(), one.procedures.join(" ")));
        }
        lines.extend(findings.disagreements.iter().map(|sentence| format!("estimates disagree: {sentence}")));
        lines.extend(findings.campaign.left_out.iter().cloned());
        let speed = record.speed_factor.map_or(String::new(), |f| format!(", {f:.0} simulated s per CPU s"));
        lines.push(format!("{:.0} s of rig time in {:.1} s{speed}", record.simulated_s, record.wall_s));
        lines.extend(self.report().map(|report| format!("report: {}", report.display())));
        lines
    }

    /// Shortfalls in their order, those with one verdict for one reason together.
    fn together(&self) -> Vec<Together> {
        let mut all: Vec<Together> = Vec::new();
        for one in terminal::shortfalls(&self.results.findings) {
            match all.iter_mut().find(|other| other.word == one.word && other.why == one.why) {
                Some(other) => {
                    if !other.requirements.contains(&one.requirement) {
                        other.requirements.push(one.requirement);
                    }
                    if other.place != one.place {
                        other.place.clear();
                    }
                }
                None => all.push(Together {
                    word: one.word,
                    verdict: one.verdict,
                    requirements: vec![one.requirement],
                    why: one.why,
                    place: one.place,
                }),
            }
        }
        all
    }
}

/// Columns before and after a verdict, together.
const INDENT: usize = 4;

/// The verdict in whose colour an overall one stands.
fn colour(overall: Overall) -> Verdict {
    match overall {
        Overall::Pass => Verdict::Pass,
        Overall::ConditionalPass => Verdict::ConditionalPass,
        Overall::Screening => Verdict::Screened,
        Overall::Incomplete | Overall::Inconclusive => Verdict::Inconclusive,
        Overall::ConditionalFail | Overall::Fail => Verdict::Fail,
    }
}
