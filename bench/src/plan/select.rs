//! A selection: what of a campaign is run.

use procedures::procedure::Procedure;
use procedures::requirement::Requirement;

use super::{CampaignPlan, PlanError, PlannedProcedure};
use crate::polarity;

/// Keeps the procedures that a selection means (by requirement id, procedure id, stage, axis or kind), each once, and
/// the checks of polarity of their build states.
pub(super) fn select(mut plan: CampaignPlan, select: &[String]) -> Result<CampaignPlan, PlanError> {
    if select.is_empty() {
        return Ok(plan);
    }
    let means = |p: &PlannedProcedure, word: &str| {
        let by_requirement = plan.requirements.get(word).is_some_and(|r| serves(&p.procedure, r));
        names(&plan, p, word) || plan.is_judged(p) && by_requirement
    };
    for word in select {
        if !plan.procedures.iter().any(|p| means(p, word)) {
            let message =
                format!("--select {word}: no procedure, stage, axis, kind or requirement of `{}`", plan.id);
            return Err(PlanError::NothingSelected(message));
        }
    }
    let meant = |p: &PlannedProcedure| select.iter().any(|word| means(p, word));
    let state = |p: &PlannedProcedure| plan.state_of(p).map(|state| state.id.clone());
    let proves = |p: &PlannedProcedure| {
        let relies =
            |other: &PlannedProcedure| meant(other) && other.needs_polarity() && state(other) == state(p);
        p.procedure.kind == polarity::KIND && plan.procedures.iter().any(relies)
    };
    // A requirement counts when it was named, or when procedures that were named otherwise serve it.
    let whole = |p: &&PlannedProcedure| plan.is_judged(p) && select.iter().any(|w| names(&plan, p, w));
    let served = |r: &Requirement| plan.procedures.iter().filter(whole).any(|p| serves(&p.procedure, r));
    let counts = |id: &String| select.contains(id) || plan.requirements.get(id).is_some_and(served);
    let must_measure = plan.must_measure.iter().filter(|id| counts(id)).cloned().collect();
    let kept: Vec<bool> = plan.procedures.iter().map(|p| meant(p) || proves(p)).collect();
    let mut flags = kept.into_iter();
    plan.procedures.retain(|_| flags.next().unwrap_or(false));
    plan.must_measure = must_measure;
    plan.partial = true;
    plan.drop_empty_stages();
    Ok(plan)
}

/// Whether a word names a procedure, its stage, its axis or its kind.
fn names(plan: &CampaignPlan, planned: &PlannedProcedure, word: &str) -> bool {
    let procedure = &planned.procedure;
    let stage = plan.stage_of(planned).is_some_and(|s| s.stage.id == word);
    stage || procedure.id == word || procedure.axis == word || procedure.kind == word
}

/// Whether a procedure yields something that a requirement judges.
pub(super) fn serves(procedure: &Procedure, requirement: &Requirement) -> bool {
    let yields = procedure.experiment.yields();
    requirement.axis.as_ref().is_none_or(|axis| *axis == procedure.axis)
        && requirement.measurands().any(|m| yields.contains(&m))
}
