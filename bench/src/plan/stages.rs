//! Stages of a plan: build states, gates that a selection leaves, and who waits for whom.

use procedures::campaign::{Campaign, Stage};
use procedures::diagnostic::Diagnostic;
use procedures::procedure::{Prompt, PromptClass};

use super::{CampaignPlan, PlannedProcedure, pointed};
use crate::files::unit::{in_state, load_state};
use crate::model::rig::Rig;
use crate::model::signs;
use crate::site::unit::{BuildState, Unit};

/// A stage with what its build state is.
#[derive(Clone, Debug)]
pub struct PlannedStage {
    /// As the campaign says.
    pub stage: Stage,
    /// What differs in it from the finished unit; `None` in the final state.
    pub state: Option<BuildState>,
    /// Gates of the campaign that a selection leaves out, in words.
    pub waived: Vec<String>,
}

/// A question and who asks it.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// Stage or procedure that asks.
    pub owner: &'a str,
    /// The question.
    pub prompt: &'a Prompt,
    /// The prompt asks for a build state, or for something that a simulation has by itself: where every device is simulated the
    /// bench itself brings it.
    pub brought: bool,
    /// Longest wait between the answer and the motion that it allows, s: the point may have to cool down first.
    pub wait_s: f64,
}

/// The stages of a campaign with the files of their build states.
pub(super) fn read(campaign: &Campaign) -> Result<Vec<PlannedStage>, Vec<Diagnostic>> {
    let mut all = Vec::new();
    let mut mistakes = Vec::new();
    for stage in &campaign.stages {
        let named = stage.state.as_ref().filter(|_| !stage.is_final());
        let state = named.map(|name| load_state(name, Some(&campaign.source.name))).transpose();
        match state {
            Ok(state) => all.push(PlannedStage { stage: stage.clone(), state, waived: Vec::new() }),
            Err(found) => mistakes.extend(pointed(found, &campaign.source, &stage.span)),
        }
    }
    if mistakes.is_empty() { Ok(all) } else { Err(mistakes) }
}

impl PlannedStage {
    /// The rig as it is in this build state; `None` where nothing of it differs.
    pub(super) fn rig(&self, rig: &Rig) -> Result<Option<Box<Rig>>, Vec<Diagnostic>> {
        if self.stage.inertia_kg_m2.is_empty() {
            return Ok(None);
        }
        let built = rig.with_inertia(&self.stage.inertia_kg_m2).map_err(|reason| {
            let found = Diagnostic::new(format!("stage `{}`: {reason}", self.stage.id));
            let help =
                "`inertia` may only name axes of the rig, and no value may exceed that of the finished unit";
            vec![found.help(help)]
        })?;
        Ok(Some(Box::new(built)))
    }

    fn asks(&self, wait_s: f64) -> impl Iterator<Item = Asked<'_>> {
        let brings = self.stage.state.is_some();
        self.stage.prompts.iter().map(move |prompt| Asked {
            owner: &self.stage.id,
            prompt,
            brought: prompt.simulated || (brings && prompt.class == PromptClass::Safety),
            wait_s,
        })
    }
}

impl PlannedProcedure {
    /// How long a point may cool down before it moves, s.
    fn wait_s(&self) -> f64 {
        self.procedure.cool_down_s.unwrap_or(0.0)
    }

    /// Questions of the stage itself.
    fn asks(&self) -> impl Iterator<Item = Asked<'_>> {
        self.procedure.prompts.iter().map(|prompt| Asked {
            owner: &self.procedure.id,
            prompt,
            brought: prompt.simulated,
            wait_s: self.wait_s(),
        })
    }
}

impl CampaignPlan {
    /// The stage of a procedure.
    pub fn stage_of(&self, planned: &PlannedProcedure) -> Option<&PlannedStage> {
        self.stages.get(planned.stage?)
    }

    /// Build state of a procedure; `None` for the final one.
    pub fn state_of(&self, planned: &PlannedProcedure) -> Option<&BuildState> {
        self.stage_of(planned)?.state.as_ref()
    }

    /// Every question before the points of a procedure: its stage's, then its own.
    pub fn asked<'a>(&'a self, planned: &'a PlannedProcedure) -> Vec<Asked<'a>> {
        let of_stage = self.stage_of(planned).into_iter().flat_map(|stage| stage.asks(planned.wait_s()));
        of_stage.chain(planned.asks()).collect()
    }

    /// Every question of the plan, each once.
    pub fn questions(&self) -> Vec<Asked<'_>> {
        let own = self.procedures.iter().flat_map(PlannedProcedure::asks);
        self.stages.iter().flat_map(|stage| stage.asks(0.0)).chain(own).collect()
    }

    /// The simulated unit of each stage, where its build state differs from the finished one.
    ///
    /// # Errors
    /// Where a state does not fit the unit.
    pub fn units(&self, unit: &Unit) -> Result<Vec<Option<Unit>>, Vec<Diagnostic>> {
        self.stages.iter().map(|s| s.state.as_ref().map(|state| in_state(unit, state)).transpose()).collect()
    }

    /// For each procedure the indices of those that must be over before it begins: all of the stages that its own
    /// needs, and where it closes loops the checks of polarity in its build state.
    pub fn waits(&self) -> Vec<Vec<usize>> {
        let waits_for = |index: usize| {
            let planned = &self.procedures[index];
            let needs = self.stage_of(planned).map_or(&[][..], |s| s.stage.needs.as_slice());
            let is_needed = |other: &PlannedProcedure| {
                let stage = self.stage_of(other);
                stage.is_some_and(|s| needs.iter().any(|(id, _)| *id == s.stage.id))
            };
            let proves = |other: &PlannedProcedure| {
                let state = |p: &PlannedProcedure| self.state_of(p).map(|s| s.id.clone());
                planned.needs_polarity()
                    && other.procedure.kind == signs::POLARITY
                    && state(other) == state(planned)
            };
            let all = self.procedures.iter().enumerate();
            all.filter(|(k, other)| *k != index && (is_needed(other) || proves(other)))
                .map(|(k, _)| k)
                .collect()
        };
        (0..self.procedures.len()).map(waits_for).collect()
    }

    /// A check of polarity that would wait for what waits for it.
    pub(super) fn circle(&self) -> Option<Diagnostic> {
        let waits = self.waits();
        let reached = |from: usize| {
            let mut seen = Vec::new();
            let mut left = waits[from].clone();
            while let Some(next) = left.pop() {
                if !seen.contains(&next) {
                    seen.push(next);
                    left.extend(&waits[next]);
                }
            }
            seen
        };
        let caught = (0..waits.len()).find(|&index| reached(index).contains(&index))?;
        let id = &self.procedures[caught].procedure.id;
        let message = format!(
            "circular dependency: the stage of {id} needs a stage whose procedures close loops in the same \
             build state"
        );
        Some(
            Diagnostic::new(message)
                .help("a stage that checks polarity must not need a stage that relies on that check"),
        )
    }

    /// Whether what a procedure measures is judged: in an earlier build state it is only reported.
    pub fn is_judged(&self, planned: &PlannedProcedure) -> bool {
        self.state_of(planned).is_none()
    }
}

#[cfg(test)]
pub(super) mod tests;
