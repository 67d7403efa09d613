//! Reduces a campaign to the part named with `--select`.

use std::ops::Range;

use procedures::diagnostic::nearest;
use procedures::kinds::KINDS;
use procedures::procedure::Procedure;
use procedures::requirement::Requirement;

use super::{CampaignPlan, PlanError, PlannedProcedure};
use crate::model::signs;

/// Keeps the selected procedures, each once. A word selects by requirement id, procedure id, stage, axis or kind.
///
/// Also keeps what must run before them so that their loops are closed with the right sign: the polarity checks of their
/// build states, and the procedures that show the signs of trackers and mirror; and, where a requirement of torques is
/// selected, those that measure the torque constants by which it is judged. An empty selection keeps everything.
pub(super) fn select(mut plan: CampaignPlan, select: &[String]) -> Result<CampaignPlan, PlanError> {
    if select.is_empty() {
        return Ok(plan);
    }
    let matches_word = |p: &PlannedProcedure, word: &str| {
        let by_requirement = plan.requirements.get(word).is_some_and(|r| serves(&p.procedure, r));
        names(&plan, p, word) || plan.is_judged(p) && by_requirement
    };
    for word in select {
        if !plan.procedures.iter().any(|p| matches_word(p, word)) {
            return Err(PlanError::NothingSelected(unknown(&plan, word)));
        }
    }
    let selected = |p: &PlannedProcedure| select.iter().any(|word| matches_word(p, word));
    let build_state = |p: &PlannedProcedure| plan.state_of(p).map(|state| state.id.clone());
    let proves_polarity = |p: &PlannedProcedure| {
        let relies_on_it = |other: &PlannedProcedure| {
            selected(other) && other.needs_polarity() && build_state(other) == build_state(p)
        };
        p.procedure.kind == signs::POLARITY && plan.procedures.iter().any(relies_on_it)
    };
    // A tracker loop is closed only with a sign that this run has seen. A selection is no exception.
    let shows_sign = |p: &PlannedProcedure| {
        let needs_its_stage = |stage: usize| p.stage.is_some_and(|own| plan.needed(stage).contains(&own));
        let relies_on_it =
            |other: &PlannedProcedure| selected(other) && other.stage.is_some_and(needs_its_stage);
        signs::SHOW_SIGNS.contains(&p.procedure.kind) && plan.procedures.iter().any(relies_on_it)
    };
    let tells_torque = |p: &PlannedProcedure| {
        let rests_on_it =
            |r: &Requirement| judges_torque(r) && r.axis.as_ref().is_none_or(|a| *a == p.procedure.axis);
        p.procedure.kind == signs::TORQUE_CONSTANT
            && select.iter().filter_map(|word| plan.requirements.get(word)).any(rests_on_it)
    };
    // A requirement must get a verdict if it is selected itself, or if a procedure serves it that is selected by its own
    // id, stage, axis or kind. A procedure that another requirement selects does not count.
    let selected_by_name =
        |p: &&PlannedProcedure| plan.is_judged(p) && select.iter().any(|word| names(&plan, p, word));
    let is_served =
        |r: &Requirement| plan.procedures.iter().filter(selected_by_name).any(|p| serves(&p.procedure, r));
    let must_be_measured =
        |id: &String| select.contains(id) || plan.requirements.get(id).is_some_and(is_served);
    let must_measure = plan.must_measure.iter().filter(|id| must_be_measured(id)).cloned().collect();
    let keep = |p| selected(p) || proves_polarity(p) || shows_sign(p) || tells_torque(p);
    let kept: Vec<bool> = plan.procedures.iter().map(keep).collect();
    let mut flags = kept.into_iter();
    plan.procedures.retain(|_| flags.next().unwrap_or(false));
    plan.must_measure = must_measure;
    plan.partial = true;
    plan.drop_empty_stages();
    Ok(plan)
}

/// What is said of a word that selects nothing.
fn unknown(plan: &CampaignPlan, word: &str) -> String {
    let mut known: Vec<&str> = plan.stages.iter().map(|stage| stage.stage.id.as_str()).collect();
    for planned in &plan.procedures {
        let procedure = &planned.procedure;
        known.extend([procedure.id.as_str(), procedure.axis.as_str(), procedure.kind]);
    }
    known.extend(plan.requirements.all.iter().map(|requirement| requirement.id.as_str()));
    let message =
        format!("--select {word}: `{}` has no such procedure, stage, axis, kind or requirement", plan.id);
    if plan.requirements.get(word).is_some() {
        return format!("--select {word}: nothing in `{}` measures this requirement", plan.id);
    }
    match nearest(word, known) {
        Some(near) => format!("{message}; did you mean `{near}`?"),
        None => format!(
            "{message}; `bench plan` lists its stages and procedures, `bench list requirements` lists all \
             requirements"
        ),
    }
}

/// Whether a requirement judges anything in units of torque.
fn judges_torque(requirement: &Requirement) -> bool {
    let measurands = || KINDS.iter().flat_map(|kind| kind.measurands);
    requirement.measurands().any(|name| measurands().any(|m| m.name == name && m.kind.is_of_torque()))
}

/// Whether a word names a procedure, its stage, its axis or its kind.
fn names(plan: &CampaignPlan, planned: &PlannedProcedure, word: &str) -> bool {
    let procedure = &planned.procedure;
    let stage = plan.stage_of(planned).is_some_and(|s| s.stage.id == word);
    stage || procedure.id == word || procedure.axis == word || procedure.kind == word
}

/// Id of a stage that another stage needs, and the place of this need in the campaign file.
type Need = (String, Range<usize>);

impl CampaignPlan {
    /// Removes stages without procedures, and gates of other stages on what is not run. Removed gates go to `waived`.
    pub(super) fn drop_empty_stages(&mut self) {
        // All needs are computed first: each looks at the stages as they were.
        let changes: Vec<_> = (0..self.stages.len()).map(|k| self.needs_left(k)).collect();
        for (stage, (needs, waived)) in self.stages.iter_mut().zip(changes) {
            stage.stage.needs = needs;
            stage.waived.extend(waived);
        }
        let used: Vec<bool> =
            (0..self.stages.len()).map(|k| self.procedures.iter().any(|p| p.stage == Some(k))).collect();
        let new_index = |k: usize| used[..k].iter().filter(|used| **used).count();
        for planned in &mut self.procedures {
            planned.stage = planned.stage.map(new_index);
        }
        let mut flags = used.iter();
        self.stages.retain(|_| *flags.next().unwrap_or(&false));
        for index in 0..self.stages.len() {
            self.drop_unmeasured(index);
        }
    }

    /// The needs of a stage among the stages that are run, and in words the stages that it no longer waits for.
    ///
    /// A stage that is not run passes its own needs on to the stages that need it.
    fn needs_left(&self, index: usize) -> (Vec<Need>, Vec<String>) {
        let (mut kept, mut waived): (Vec<Need>, Vec<String>) = (Vec::new(), Vec::new());
        let mut all = self.stages[index].stage.needs.clone();
        let mut next = 0;
        while let Some((id, span)) = all.get(next).cloned() {
            next += 1;
            let needed = self.stages.iter().position(|s| s.stage.id == id);
            if needed.is_some_and(|needed| self.procedures.iter().any(|p| p.stage == Some(needed))) {
                kept.push((id, span));
                continue;
            }
            waived.push(format!("stage `{id}`"));
            let inherited = needed.map_or(&[][..], |needed| self.stages[needed].stage.needs.as_slice());
            let is_new = |need: &&Need| all.iter().all(|(known, _)| *known != need.0);
            let new: Vec<Need> = inherited.iter().filter(is_new).cloned().collect();
            all.extend(new);
        }
        (kept, waived)
    }

    /// Removes the requirements from a stage's gate that no selected procedure of an earlier stage measures.
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

    /// Indices of the procedures in the stages that a stage needs, directly or through others.
    fn before(&self, index: usize) -> Vec<usize> {
        let stages = self.needed(index);
        let belongs = |p: &PlannedProcedure| p.stage.is_some_and(|s| stages.contains(&s));
        (0..self.procedures.len()).filter(|&k| belongs(&self.procedures[k])).collect()
    }

    /// Indices of the stages that a stage needs, directly or through others.
    fn needed(&self, index: usize) -> Vec<usize> {
        // Breadth-first search: `stages` is both the queue and the set of those seen.
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
    requirement.axis.as_ref().is_none_or(|axis| *axis == procedure.axis)
        && requirement.measurands().any(|m| procedure.yields.contains(&m))
}
