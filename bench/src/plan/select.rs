//! A selection: what of a campaign is run.

use std::ops::Range;

use procedures::procedure::Procedure;
use procedures::requirement::Requirement;

use super::{CampaignPlan, PlanError, PlannedProcedure};
use crate::model::signs;

/// Keeps the procedures that a selection means (by requirement id, procedure id, stage, axis or kind), each once, and
/// what closes their loops safely: the checks of polarity of their build states, and of the signs of trackers and mirror.
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
        p.procedure.kind == signs::POLARITY && plan.procedures.iter().any(relies)
    };
    // A loop over a tracker is closed on a sign that was seen, in a selection, too.
    let shows_a_sign = |p: &PlannedProcedure| {
        let needs = |stage: usize| p.stage.is_some_and(|own| plan.needed(stage).contains(&own));
        let relies = |other: &PlannedProcedure| meant(other) && other.stage.is_some_and(needs);
        signs::SHOW_SIGNS.contains(&p.procedure.kind) && plan.procedures.iter().any(relies)
    };
    // A requirement counts when it was named, or when procedures that were named otherwise serve it.
    let whole = |p: &&PlannedProcedure| plan.is_judged(p) && select.iter().any(|w| names(&plan, p, w));
    let served = |r: &Requirement| plan.procedures.iter().filter(whole).any(|p| serves(&p.procedure, r));
    let counts = |id: &String| select.contains(id) || plan.requirements.get(id).is_some_and(served);
    let must_measure = plan.must_measure.iter().filter(|id| counts(id)).cloned().collect();
    let kept: Vec<bool> = plan.procedures.iter().map(|p| meant(p) || proves(p) || shows_a_sign(p)).collect();
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

/// A stage that another one needs, and where its campaign says so.
type Need = (String, Range<usize>);

impl CampaignPlan {
    /// Takes out the stages that a selection leaves empty, and the gates on what it leaves out.
    pub(super) fn drop_empty_stages(&mut self) {
        let (needs, waived): (Vec<_>, Vec<_>) = (0..self.stages.len()).map(|k| self.needs_left(k)).unzip();
        for (stage, (needs, waived)) in self.stages.iter_mut().zip(needs.into_iter().zip(waived)) {
            stage.stage.needs = needs;
            stage.waived.extend(waived);
        }
        let used: Vec<bool> =
            (0..self.stages.len()).map(|k| self.procedures.iter().any(|p| p.stage == Some(k))).collect();
        let place = |k: usize| used[..k].iter().filter(|used| **used).count();
        for planned in &mut self.procedures {
            planned.stage = planned.stage.map(place);
        }
        let mut flags = used.iter();
        self.stages.retain(|_| *flags.next().unwrap_or(&false));
        for index in 0..self.stages.len() {
            self.drop_unmeasured(index);
        }
    }

    /// What a stage needs of the stages that are left, and what it does not wait for, in words. Who needs a stage that is not
    /// run needs what that one needed.
    fn needs_left(&self, index: usize) -> (Vec<Need>, Vec<String>) {
        let (mut kept, mut waived): (Vec<Need>, Vec<String>) = (Vec::new(), Vec::new());
        let mut all = self.stages[index].stage.needs.clone();
        let mut next = 0;
        while let Some((id, span)) = all.get(next).cloned() {
            next += 1;
            let of = self.stages.iter().position(|s| s.stage.id == id);
            if of.is_some_and(|of| self.procedures.iter().any(|p| p.stage == Some(of))) {
                kept.push((id, span));
                continue;
            }
            waived.push(format!("stage `{id}`"));
            let further = of.map_or(&[][..], |of| self.stages[of].stage.needs.as_slice());
            let new: Vec<Need> =
                further.iter().filter(|(id, _)| all.iter().all(|(other, _)| other != id)).cloned().collect();
            all.extend(new);
        }
        (kept, waived)
    }

    /// A requirement that nothing of the selection measures before a stage is no gate of it.
    fn drop_unmeasured(&mut self, index: usize) {
        let mut passes = std::mem::take(&mut self.stages[index].stage.needs_pass);
        let before = self.before(index);
        let measured = |id: &str| {
            self.requirements.get(id).is_some_and(|r| {
                before
                    .iter()
                    .any(|&k| self.is_judged(&self.procedures[k]) && serves(&self.procedures[k].procedure, r))
            })
        };
        let gone: Vec<String> = passes
            .iter()
            .filter(|(id, _)| !measured(id))
            .map(|(id, _)| format!("requirement {id}"))
            .collect();
        passes.retain(|(id, _)| measured(id));
        let stage = &mut self.stages[index];
        stage.stage.needs_pass = passes;
        stage.waived.extend(gone);
    }

    /// Procedures of the stages that a stage needs, directly or through others.
    fn before(&self, index: usize) -> Vec<usize> {
        let stages = self.needed(index);
        let belongs = |p: &PlannedProcedure| p.stage.is_some_and(|s| stages.contains(&s));
        (0..self.procedures.len()).filter(|&k| belongs(&self.procedures[k])).collect()
    }

    /// Stages that a stage needs, directly or through others.
    fn needed(&self, index: usize) -> Vec<usize> {
        let mut stages = vec![index];
        let mut k = 0;
        while let Some(&stage) = stages.get(k) {
            for (id, _) in &self.stages[stage].stage.needs {
                let found = self.stages.iter().position(|s| s.stage.id == *id);
                stages.extend(found.filter(|found| !stages.contains(found)));
            }
            k += 1;
        }
        stages.split_off(1)
    }
}

/// Whether a procedure yields something that a requirement judges.
pub(super) fn serves(procedure: &Procedure, requirement: &Requirement) -> bool {
    let yields = procedure.experiment.yields();
    requirement.axis.as_ref().is_none_or(|axis| *axis == procedure.axis)
        && requirement.measurands().any(|m| yields.contains(&m))
}
