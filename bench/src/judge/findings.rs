//! From judged logs to the findings of a campaign.

use std::path::Path;

use procedures::requirement::{Requirement, Requirements};
use procedures::verdict::{Outcome, Overall, Verdict, roll_up};
use reports::record::{CampaignFindings, Findings, Origin, ProcedureFindings, RequirementFindings, Status};

use super::known::{Known, Settled, settled};
use super::{JudgedLog, compared, judge_log, safety, try_log};
use crate::judge::stage::Progress;
use crate::record::journal::sha256;
use crate::record::page::{Page, PlannedLog};

/// What the findings of a campaign are folded by.
pub struct Fold<'a> {
    /// Title page of the run.
    pub page: &'a Page,
    /// Requirements to judge by.
    pub requirements: &'a Requirements,
    /// Text of the requirements.
    pub requirements_text: &'a str,
    /// Folder of the logs, from which they are judged again by what others found.
    pub folder: &'a Path,
}

/// Findings from the judged logs, in the order of the page's procedures (`None`: no log).
pub fn fold(by: &Fold<'_>, judged: &[Option<JudgedLog>]) -> Findings {
    let page = by.page;
    let logs: Vec<Option<&JudgedLog>> = judged.iter().map(Option::as_ref).collect();
    // The run had no more than this when it opened or closed its gates.
    let so_far = Progress { page, requirements: by.requirements, judged: &logs };
    let again = |index: usize, known: &Known| {
        let planned = page.procedures.get(index)?;
        let path = by.folder.join(&planned.log);
        Some(try_log(judge_log, &path, planned, by.requirements, known, page.seed).log)
    };
    let Settled { logs: settled, sources_of_constants, mut disagreements } =
        settled(judged, &again, by.requirements);
    let mut procedures: Vec<ProcedureFindings> = page
        .procedures
        .iter()
        .enumerate()
        .map(|(i, planned)| match settled.get(i) {
            Some(Some(log)) => ProcedureFindings { stage: planned.stage.clone(), ..log.findings.clone() },
            _ => not_run(planned, so_far.held_back(i)),
        })
        .collect();
    disagreements.extend(compared::compare_all(&mut procedures, &sources_of_constants, by.requirements));
    let verifies = procedures.iter().filter(|p| p.state.is_none());
    let measured: Vec<_> = verifies.map(|p| (p.id.clone(), p.measurements.clone())).collect();
    let (mut outcomes, mut overall) = roll_up(by.requirements, &measured, &page.must_measure, page.claim);
    unfinished(by, &procedures, &mut outcomes, &mut overall);
    if !disagreements.is_empty() {
        overall = overall.max(Overall::Inconclusive);
    }
    let [not_in_this_campaign, no_kind_measures_it_yet] = unmeasured(by, &outcomes);
    let mut findings = Findings {
        campaign: CampaignFindings {
            id: page.campaign.clone(),
            title: page.title.clone(),
            partial: page.partial,
            left_out: page.left_out.clone(),
            sha256: page.campaign_file.as_ref().map(|f| sha256(f.text.as_bytes())),
            requirements_sha256: Some(sha256(by.requirements_text.as_bytes())),
        },
        unit: page.unit.clone(),
        origin: origin(page, judged),
        seed: page.seed,
        overall,
        requirements: in_findings(by),
        outcomes,
        not_in_this_campaign,
        no_kind_measures_it_yet,
        disagreements,
        not_enforced: if procedures.iter().any(|p| p.safety.is_some()) {
            safety::not_enforced()
        } else {
            Vec::new()
        },
        procedures,
    };
    findings.make_finite();
    findings
}

/// Ids of the requirements that nothing was judged by and the campaign need not measure: those that some kind measures, and those
/// that none does yet.
fn unmeasured(by: &Fold<'_>, outcomes: &[Outcome]) -> [Vec<String>; 2] {
    let [mut in_another_campaign, mut by_no_kind] = [Vec::new(), Vec::new()];
    for outcome in outcomes.iter().filter(|o| o.judged == 0 && !o.required) {
        let judgeable = by.requirements.get(&outcome.requirement).is_some_and(|r| !r.judges.is_empty());
        let list = if judgeable { &mut in_another_campaign } else { &mut by_no_kind };
        list.push(outcome.requirement.clone());
    }
    [in_another_campaign, by_no_kind]
}

fn in_findings(by: &Fold<'_>) -> Vec<RequirementFindings> {
    let one = |r: &Requirement| RequirementFindings::new(r, by.page.must_measure.contains(&r.id));
    by.requirements.all.iter().map(one).collect()
}

/// What a procedure that did not complete serves passes in no case: the part that is missing might have failed.
fn unfinished(
    by: &Fold<'_>,
    procedures: &[ProcedureFindings],
    outcomes: &mut [Outcome],
    overall: &mut Overall,
) {
    let planned = by.page.procedures.iter().zip(procedures);
    for (planned, found) in planned.filter(|(_, found)| found.status != Status::Completed) {
        *overall = (*overall).max(Overall::Incomplete);
        for (requirement, outcome) in by.requirements.all.iter().zip(outcomes.iter_mut()) {
            let axis = requirement.axis.as_ref().is_none_or(|axis| *axis == planned.axis);
            let serves = planned.state.is_none()
                && axis
                && requirement.measurands().any(|m| planned.yields.iter().any(|y| y == m));
            if serves
                && matches!(outcome.verdict, Verdict::Screened | Verdict::Pass | Verdict::ConditionalPass)
            {
                outcome.verdict = Verdict::Inconclusive;
                outcome.before_coverage = outcome.before_coverage.max(Verdict::Inconclusive);
                outcome.reason = Some(format!("{}: {}", planned.id, found.status.word()));
                for one in &mut outcome.by_measurand {
                    one.verdict = one.verdict.max(Verdict::Inconclusive);
                }
                *overall = (*overall).max(Overall::Inconclusive);
            }
        }
    }
}

/// The least real of what the title page says and what the logs say: a changed word takes no watermark away.
fn origin(page: &Page, judged: &[Option<JudgedLog>]) -> Origin {
    let all = judged.iter().flatten().map(|log| log.origin).chain([page.origin]);
    let reality = |origin: &Origin| match origin {
        Origin::Imported => 0,
        Origin::Simulated => 1,
        Origin::Mixed => 2,
        Origin::Real => 3,
    };
    all.min_by_key(reality).unwrap_or(page.origin)
}

fn not_run(planned: &PlannedLog, held_back: Option<String>) -> ProcedureFindings {
    match held_back {
        Some(reason) => without(planned, Status::Skipped, reason),
        None => without(planned, Status::NotRun, "no log: the procedure was not run".to_owned()),
    }
}

/// A procedure without a single number.
pub(super) fn without(planned: &PlannedLog, status: Status, remark: String) -> ProcedureFindings {
    ProcedureFindings {
        id: planned.id.clone(),
        title: planned.title.clone(),
        kind: planned.kind.clone(),
        axis: planned.axis.clone(),
        stage: planned.stage.clone(),
        state: planned.state.clone(),
        method: procedures::kinds::kind(&planned.kind).map_or("", |k| k.doc).to_owned(),
        status,
        remarks: vec![remark],
        ..ProcedureFindings::default()
    }
}
