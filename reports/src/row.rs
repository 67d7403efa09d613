//! Cells of tables as text: one source for HTML, Markdown and JUnit.

use procedures::measurement::{Exclusion, Measurement};
use procedures::verdict::{Judgement, MeasurandOutcome, Outcome, Verdict};

use crate::number::{self, Shown};
use crate::record::{Findings, JudgedFindings, LimitFindings, ProcedureFindings, RequirementFindings};
use crate::words::{self, Sign};

pub(crate) mod margin;
pub(crate) mod shortfall;

const NOT_IN_CAMPAIGN: &str = "not in this campaign";
const NO_KIND: &str = "no kind of procedure measures it yet";

/// One row, cells as printed.
#[derive(Clone, Debug)]
pub(crate) struct Row<'a> {
    pub(crate) requirement: &'a RequirementFindings,
    pub(crate) verdict: Verdict,
    pub(crate) value: String,
    pub(crate) expanded_u: String,
    /// All limits of the requirement.
    pub(crate) limit: String,
    /// The limit that decided.
    pub(crate) decisive_limit: Option<String>,
    /// The band of conditions that the row is about, as a person wrote it.
    pub(crate) band: Option<&'a str>,
    /// Goal and whether it is met.
    pub(crate) goal: Option<String>,
    pub(crate) rule: &'static str,
    pub(crate) margin: String,
    /// Margin over the size of the limit (see [`margin::ratio`]); negative outside.
    pub(crate) margin_ratio: Option<f64>,
    /// Margin over the expanded uncertainty, where that is not zero.
    pub(crate) margin_per_u: Option<f64>,
    /// Distance to the guard band over the expanded uncertainty, where that is not zero; negative inside the band and outside.
    pub(crate) guard_distance_per_u: Option<f64>,
    /// Whether it is the first row of its requirement.
    pub(crate) is_first: bool,
    /// Width of the guard band of the decision rule.
    pub(crate) guard_band: Option<String>,
    pub(crate) probability_outside: Option<String>,
    pub(crate) sign: Sign,
    /// Why there is no verdict, or why it is inconclusive.
    pub(crate) reason: Option<String>,
    /// Procedure and point that decided.
    pub(crate) evidence: Option<Evidence<'a>>,
}

/// Where the number stands.
#[derive(Clone, Debug)]
pub(crate) struct Evidence<'a> {
    pub(crate) procedure: &'a str,
    /// Index of the measurement in the procedure.
    pub(crate) measurement: usize,
    pub(crate) measurand: &'a str,
    pub(crate) point: Option<&'a str>,
    /// How many measurements were judged.
    pub(crate) judged: usize,
    /// The judgement that decided.
    pub(crate) judgement: &'a Judgement,
    /// First place in a log that the number comes from.
    pub(crate) log: Option<&'a procedures::measurement::Evidence>,
}

/// Requirements that the result names without saying what they demand, with the reason why nothing was measured.
pub(crate) fn named_only(findings: &Findings) -> Vec<(&'static str, Vec<&str>)> {
    let lists =
        [(NOT_IN_CAMPAIGN, &findings.not_in_this_campaign), (NO_KIND, &findings.no_kind_measures_it_yet)];
    let mut named = Vec::new();
    for (why, ids) in lists {
        let ids: Vec<&str> =
            ids.iter().map(String::as_str).filter(|id| findings.requirement(id).is_none()).collect();
        if !ids.is_empty() {
            named.push((why, ids));
        }
    }
    named
}

/// All rows in the order of the requirements: one for each limit by which something was measured where a requirement has several,
/// so that no shortfall hides behind another.
pub(crate) fn rows(findings: &Findings) -> Vec<Row<'_>> {
    let mut rows = Vec::new();
    for requirement in &findings.requirements {
        let outcome = findings.outcome(&requirement.id);
        match outcome.map(|o| o.by_measurand.as_slice()) {
            Some(several @ [_, _, ..]) => {
                let own = several.iter().map(|one| row(findings, requirement, Some(one)));
                rows.extend(own.enumerate().map(|(k, row)| Row { is_first: k == 0, ..row }));
            }
            _ => rows.push(row(findings, requirement, None)),
        }
    }
    rows
}

/// All rows, those that did not simply pass first, the worst of them before the others.
pub(crate) fn shortfalls_first<'r, 'a>(rows: &'r [Row<'a>]) -> Vec<&'r Row<'a>> {
    let mut all: Vec<&Row<'a>> = rows.iter().collect();
    // The sort is stable: among equals the order of the requirements.
    all.sort_by_key(|row| std::cmp::Reverse(shortfall::is_one(row).then_some(row.verdict)));
    all
}

impl Row<'_> {
    /// The limit, with the measurand where the requirement judges several.
    pub(crate) fn named_limit(&self) -> String {
        match &self.evidence {
            Some(found) if self.requirement.judges.len() > 1 => {
                format!("{} {}", found.measurand, self.limit)
            }
            _ => self.limit.clone(),
        }
    }
}

/// The row of one limit of a requirement; of all of them together for `None`.
fn row<'a>(
    findings: &'a Findings,
    requirement: &'a RequirementFindings,
    of: Option<&'a MeasurandOutcome>,
) -> Row<'a> {
    let outcome = findings.outcome(&requirement.id);
    let decided_by = of.map(|one| &one.decided_by).or_else(|| outcome?.decided_by.as_ref());
    let deciding = outcome.zip(decided_by.and_then(|by| findings.deciding(by)));
    let verdict = of.map(|one| one.verdict).or(outcome.map(|o| o.verdict)).unwrap_or(Verdict::None);
    let judged = of.map(|one| one.judged).or(outcome.map(|o| o.judged)).unwrap_or(0);
    let mut row = Row {
        requirement,
        verdict,
        value: "—".to_owned(),
        expanded_u: "—".to_owned(),
        limit: of
            .and_then(|one| own_limit(requirement, outcome?, one))
            .unwrap_or_else(|| limits(requirement, of.map(|one| one.measurand.as_str()))),
        decisive_limit: None,
        band: of.and_then(|one| one.band.as_deref()),
        goal: None,
        rule: requirement.judges.iter().find(|j| j.is_limited()).map_or("—", |j| j.rule.short()),
        margin: "—".to_owned(),
        margin_ratio: None,
        margin_per_u: None,
        guard_distance_per_u: None,
        is_first: true,
        guard_band: None,
        probability_outside: None,
        sign: words::verdict(verdict),
        reason: unmeasured_reason(findings, requirement, outcome),
        evidence: None,
    };
    let mut goal_met = None;
    if let Some((outcome, (procedure, measurement, judgement))) = deciding {
        goal_met = judgement.goal_met;
        row.reason = outcome
            .reason
            .clone()
            .or_else(|| judgement.reason.clone())
            .or_else(|| measurement.inconclusive.clone());
        fill_numbers(&mut row, measurement, judgement);
        name_limit(&mut row, judgement);
        row.evidence = Some(Evidence {
            procedure: &procedure.id,
            measurement: judgement.measurement,
            measurand: &measurement.measurand,
            point: measurement.point.as_deref(),
            judged,
            judgement,
            log: measurement.evidence.first(),
        });
    }
    row.goal = goal(requirement, goal_met);
    row
}

/// The goal beside the limit, and whether it was met.
fn goal(requirement: &RequirementFindings, goal_met: Option<bool>) -> Option<String> {
    let met = match goal_met {
        Some(true) => ": met",
        Some(false) => ": not met",
        None => "",
    };
    let goal = requirement.judges.iter().find_map(|j| j.goal.as_ref())?;
    Some(format!("goal {}{met}", limit_text(goal)))
}

fn unmeasured_reason(
    findings: &Findings,
    requirement: &RequirementFindings,
    outcome: Option<&Outcome>,
) -> Option<String> {
    if outcome.is_some_and(|o| o.judged > 0) {
        return None;
    }
    if let Some(evidence) = &requirement.evidence {
        return Some(format!("declared, by {}; evidence: {evidence}", requirement.method));
    }
    let reason = if findings.no_kind_measures_it_yet.contains(&requirement.id) {
        NO_KIND
    } else if findings.not_in_this_campaign.contains(&requirement.id) {
        NOT_IN_CAMPAIGN
    } else {
        "nothing was measured"
    };
    Some(reason.to_owned())
}

fn fill_numbers(row: &mut Row<'_>, measurement: &Measurement, judgement: &Judgement) {
    let of_all = || row.requirement.judged(&measurement.measurand)?.limit.clone();
    let limit = judgement.limit.as_ref().map(LimitFindings::from).or_else(of_all);
    row.decisive_limit = limit.as_ref().map(limit_text);
    let Some(value) = measurement.value else { return };
    let unit = limit.as_ref().map_or_else(|| Shown::of_kind(measurement.kind), Shown::of_limit);
    let (value_text, u_text) = unit.pair(value, judgement.expanded_u);
    row.value = bounded(measurement, unit.text(&value_text));
    row.expanded_u = unit.text(&u_text);
    if let Some(margin) = judgement.margin {
        row.margin = unit.text(&unit.pair(margin, judgement.expanded_u).0);
        row.margin_ratio = limit.as_ref().and_then(|l| margin::ratio(l, margin));
        let per_u = |distance: f64| (judgement.expanded_u > 0.0).then(|| distance / judgement.expanded_u);
        row.margin_per_u = per_u(margin);
        row.guard_distance_per_u = per_u(margin - judgement.guard_band);
        row.guard_band = (judgement.guard_band > 0.0)
            .then(|| unit.text(&unit.pair(judgement.guard_band, judgement.guard_band).0));
    }
    row.probability_outside = judgement.probability_outside.map(number::percent);
}

/// What is told in place of a limit.
const REPORT_ONLY: &str = "report only";

/// The limit of a row that shares its measurand with rows of bands, as printed; `None`: it has the measurand for itself.
fn own_limit(requirement: &RequirementFindings, outcome: &Outcome, one: &MeasurandOutcome) -> Option<String> {
    if let Some(band) = &one.band {
        return Some(number::typeset(band));
    }
    let bands = || outcome.by_measurand.iter().filter(|o| o.measurand == one.measurand && o.band.is_some());
    bands().next()?;
    let limit = requirement.judged(&one.measurand)?.limit.as_ref().map(limit_text);
    Some(limit.unwrap_or_else(|| REPORT_ONLY.to_owned()))
}

/// Names the limit that held: the band of the row, or the one that holds under the conditions of this measurement.
fn name_limit(row: &mut Row<'_>, judgement: &Judgement) {
    match (row.band, &judgement.limit) {
        (Some(band), _) => row.decisive_limit = Some(number::typeset(band)),
        (None, Some(special)) => {
            row.limit = format!("{} (here {})", row.limit, number::typeset(&special.text));
        }
        (None, None) => {}
    }
}

/// The limits of a requirement as printed, or those of one measurand; those that nothing measures yet as a person wrote them.
fn limits(requirement: &RequirementFindings, measurand: Option<&str>) -> String {
    let is_asked = |j: &&JudgedFindings| measurand.is_none_or(|name| j.measurand == name);
    let of = |j: &JudgedFindings| {
        let special = j.special.iter().map(|text| number::typeset(text));
        j.limit.iter().map(limit_text).chain(special).collect::<Vec<_>>()
    };
    let mut all: Vec<String> = requirement.judges.iter().filter(is_asked).flat_map(of).collect();
    all.dedup(); // several measurands often share one limit
    match (all.is_empty(), requirement.limit_text.is_empty()) {
        (false, _) => all.join("; "),
        (true, false) => requirement.limit_text.clone(),
        (true, true) => REPORT_ONLY.to_owned(),
    }
}

/// A limit as a person wrote it, in signs of print.
pub(crate) fn limit_text(limit: &LimitFindings) -> String {
    number::typeset(&limit.text)
}

/// The unit in which a measurement stands in tables.
pub(crate) fn unit_of(m: &Measurement) -> Shown {
    Shown::of_size(m.kind, m.value.map_or(0.0, f64::abs).max(m.u.abs()))
}

/// Value and expanded uncertainty; the standard uncertainty, marked as such, where nothing judged it.
pub(crate) fn value_cells(procedure: &ProcedureFindings, index: usize, m: &Measurement) -> (String, String) {
    let Some(value) = m.value else { return ("—".to_owned(), "—".to_owned()) };
    let judged = procedure.judgements_of(index).next();
    let u = judged.map_or(m.u, |j| j.expanded_u);
    let unit = unit_of(m);
    let (value, u_text) = unit.pair(value, u);
    let prefix = if judged.is_none() && u > 0.0 { "u = " } else { "" };
    (bounded(m, unit.text(&value)), format!("{prefix}{}", unit.text(&u_text)))
}

/// A printed value behind the sign of what it bounds.
fn bounded(m: &Measurement, value: String) -> String {
    m.bound.as_ref().map(|bound| format!("{} {value}", bound.sign())).unwrap_or(value)
}

/// Flags, reason and exclusions of a measurement.
pub(crate) fn measurement_notes(m: &Measurement) -> Vec<String> {
    let reason = m.inconclusive.iter().cloned();
    reason.chain(m.flags.iter().cloned()).chain(m.excluded.iter().map(exclusion)).collect()
}

/// `120 samples left out: turn-round: outside the plateau`.
pub(crate) fn exclusion(e: &Exclusion) -> String {
    format!("{} {} left out: {}", e.count, e.of, e.reason)
}
