//! A regression of controllers on paper: what a candidate changes against a baseline, worst first.
//!
//! [`Regression`] is data; [`text`], [`markdown`], [`junit`] and [`json`] are pure functions of it: the same two arms and criteria
//! give the same bytes.

use procedures::regression::{
    ArmRecord, Call, Controller, Criteria, Decision, Look, Outcome, Pairing, PairingError, Program,
    RegressionError, Scenario, Shard, UnitEnd, decide, pair,
};
use serde::Serialize;

use crate::json::to_text;
use crate::printable::counted;

mod junit;
mod sections;
#[cfg(test)]
mod tests;
mod written;

/// Name and version of the structure of `regression.json`.
const SCHEMA: &str = "regression/1";

/// A candidate beside a baseline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Regression {
    /// Always `regression/1`.
    schema: &'static str,
    /// What the comparison comes to.
    call: Call,
    /// The baseline's controller and program.
    baseline: Side,
    /// The candidate's.
    candidate: Side,
    /// What both were run through.
    scenario: Scenario,
    /// Which part of the units; the decision of a shard alone is not that of the whole.
    shard: Shard,
    /// The call of each criterion.
    decision: Decision,
    /// Runs that ended early.
    ends: Vec<UnitEnd>,
}

/// Controller and program of an arm.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Side {
    /// The controller.
    controller: Controller,
    /// The program that ran it.
    program: Program,
}

/// Why two arms are not decided.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Undecidable {
    /// They were not run alike.
    #[error(transparent)]
    Pairing(#[from] PairingError),
    /// Their samples are wrong.
    #[error(transparent)]
    Samples(#[from] RegressionError),
}

impl Side {
    fn new(arm: &ArmRecord) -> Self {
        Self { controller: arm.controller.clone(), program: arm.program.clone() }
    }
}

impl Regression {
    /// Compares two arms by the criteria.
    ///
    /// # Errors
    /// All that keeps them from being compared, at once.
    pub fn new(
        criteria: &Criteria,
        baseline: &ArmRecord,
        candidate: &ArmRecord,
        look: Look,
    ) -> Result<Self, Vec<Undecidable>> {
        let all =
            |errors: Vec<PairingError>| -> Vec<Undecidable> { errors.into_iter().map(Into::into).collect() };
        let Pairing { criteria, samples, ends } = pair(criteria, baseline, candidate).map_err(all)?;
        let decision = decide(&criteria, &samples, look);
        let decision =
            decision.map_err(|errors| errors.into_iter().map(Undecidable::from).collect::<Vec<_>>())?;
        Ok(Self {
            schema: SCHEMA,
            call: call(&decision, &ends),
            baseline: Side::new(baseline),
            candidate: Side::new(candidate),
            scenario: baseline.scenario.clone(),
            shard: baseline.shard,
            decision,
            ends,
        })
    }

    /// What the comparison comes to.
    pub fn call(&self) -> Call {
        self.call
    }

    /// Outcomes, those first that a person must look at: what blocks, then worse, inconclusive, better, equivalent, identical;
    /// among equals by the mean shift in margins.
    pub fn worst_first(&self) -> Vec<&Outcome> {
        let mut all: Vec<&Outcome> = self.decision.outcomes.iter().collect();
        let in_margins = |outcome: &Outcome| outcome.shift.map_or(0.0, |s| s / outcome.criterion.margin);
        all.sort_by(|a, b| rank(a).cmp(&rank(b)).then_with(|| in_margins(b).total_cmp(&in_margins(a))));
        all
    }

    /// Runs in which the candidate ended early, and the baseline later or not at all.
    pub fn candidate_ends(&self) -> impl Iterator<Item = &UnitEnd> {
        self.ends.iter().filter(|end| end.candidate_first)
    }

    /// What it comes to, in a sentence without its full stop.
    pub fn headline(&self) -> String {
        let all = || self.decision.outcomes.iter();
        let blocking = || all().filter(|outcome| outcome.criterion.blocking);
        let count = |wanted: fn(&Outcome) -> bool| blocking().filter(|outcome| wanted(outcome)).count();
        let criteria = counted(blocking().count(), "blocking comparison");
        let tripped = self.candidate_ends().count();
        let said = match self.call {
            Call::Worse if tripped > 0 => {
                format!("worse: {} ended early with the candidate", counted(tripped, "run"))
            }
            Call::Worse => format!("worse: {} of {criteria} blocked", count(|o| o.blocks)),
            Call::Inconclusive => format!(
                "inconclusive: {} of {criteria} not decided",
                count(|o| !o.blocks && matches!(o.call, Call::Inconclusive | Call::Worse))
            ),
            Call::Identical => format!("identical: {criteria} with the same values"),
            Call::Better => {
                format!("better: {} of {criteria} improved, none worse", count(|o| o.call == Call::Better))
            }
            Call::Equivalent => {
                format!("equivalent: {criteria} inside the margins, {} of them differ", count(|o| o.differs))
            }
        };
        let reported_worse =
            all().filter(|outcome| !outcome.criterion.blocking && outcome.call == Call::Worse).count();
        match reported_worse {
            0 => said,
            _ => format!("{said}; of those that are only reported {reported_worse} worse"),
        }
    }
}

/// A candidate that ends early where the baseline does not is worse, whatever it measured elsewhere; with nothing measured nothing is
/// known.
fn call(decision: &Decision, ends: &[UnitEnd]) -> Call {
    if ends.iter().any(|end| end.candidate_first) {
        Call::Worse
    } else if decision.outcomes.is_empty() {
        Call::Inconclusive
    } else {
        decision.call
    }
}

fn rank(outcome: &Outcome) -> u8 {
    match outcome.call {
        _ if outcome.blocks => 0,
        Call::Worse => 1,
        Call::Inconclusive => 2,
        Call::Better => 3,
        Call::Equivalent if outcome.differs => 4,
        Call::Equivalent => 5,
        Call::Identical => 6,
    }
}

/// The comparison for a terminal.
pub fn text(found: &Regression) -> String {
    written::text(found)
}

/// The comparison for a comment on a pull request.
pub fn markdown(found: &Regression) -> String {
    written::markdown(found)
}

/// The comparison as test cases for a build server: a criterion that blocks and an early end are failures, what is not decided an
/// error.
pub fn junit(found: &Regression) -> String {
    junit::render(found)
}

/// The comparison as data, every unit included.
pub fn json(found: &Regression) -> String {
    to_text(found)
}
