//! One run of one arm: a unit, a seed, a controller; what was judged of it.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU16;

use procedures::measurement::Measurement;
use procedures::regression::{End, Replicate, ReplicateValue};
use procedures::verdict::{Judgement, Verdict};
use reports::record::{Findings, Status};

use super::work::Arm;
use crate::campaign::simulated::{NoResult, Simulated};
use crate::campaign::{ProcedureRun, RunResult};
use crate::exit;
use crate::judge::{Fold, fold};
use crate::model::rig::Rig;
use crate::people::signals;
use crate::plan::CampaignPlan;
use crate::site::unit::Unit;

/// Why a run says nothing of its controller.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unit {unit}, seed {seed}: {why}")]
pub struct RunFailure {
    /// Number of the unit.
    pub unit: u32,
    /// Seed.
    pub seed: u64,
    /// What failed.
    pub why: String,
    /// What it means for the program's exit.
    pub exit_code: u8,
}

/// What a run is made of.
pub(super) struct Job<'a> {
    pub(super) plan: &'a CampaignPlan,
    pub(super) rig: &'a Rig,
    pub(super) arm: &'a Arm,
    pub(super) unit: &'a Unit,
    pub(super) number: u32,
    /// Digest of the unit.
    pub(super) unit_sha256: String,
    pub(super) seed: u64,
    /// Run folder, not existing.
    pub(super) folder: &'a Path,
    pub(super) stop: &'a Arc<AtomicU16>,
}

impl Job<'_> {
    fn failure(&self, why: String, exit_code: u8) -> RunFailure {
        RunFailure { unit: self.number, seed: self.seed, why, exit_code }
    }

    /// Runs it.
    ///
    /// # Errors
    /// Where the bench failed or was stopped: the controller had no part in that.
    pub(super) fn run(&self) -> Result<Replicate, RunFailure> {
        let mistakes = |found: Vec<procedures::diagnostic::Diagnostic>| {
            let texts: Vec<String> = found.iter().map(ToString::to_string).collect();
            self.failure(texts.join("\n"), exit::USAGE)
        };
        let unit = self.arm.laid_over(self.unit).map_err(mistakes)?;
        let simulated = Simulated {
            plan: self.plan,
            rig: self.rig,
            gains: &self.arm.gains,
            laws: &self.arm.laws,
            unit: &unit,
            seed: self.seed,
            folder: self.folder,
            stop: self.stop,
        };
        let result = simulated.run().map_err(|NoResult { why, exit_code }| self.failure(why, exit_code))?;
        self.replicate(result)
    }

    fn replicate(&self, result: RunResult) -> Result<Replicate, RunFailure> {
        let stopped = signals::exit_code(self.stop);
        if stopped != exit::PASS {
            return Err(self.failure("stopped by a signal".to_owned(), stopped));
        }
        let end = self.end(&result)?;
        let by = Fold {
            page: &result.page,
            requirements: &self.plan.requirements,
            requirements_text: &self.plan.requirements_source.text,
            folder: self.folder,
        };
        let findings = fold(&by, &result.judged);
        let closed = result.journal.close(result.exit_code);
        closed.map_err(|error| self.failure(format!("{}: {error}", self.folder.display()), exit::BENCH))?;
        Ok(Replicate {
            unit: self.number,
            unit_id: self.unit.id.clone(),
            unit_sha256: self.unit_sha256.clone(),
            seed: self.seed,
            end,
            values: values(&findings),
        })
    }

    /// How the run ended. An axis that met an end stop did so by its controller; a disk that is full is nobody's fault.
    fn end(&self, result: &RunResult) -> Result<End, RunFailure> {
        let named = || self.plan.procedures.iter().zip(&result.runs);
        let is_ours =
            |run: &ProcedureRun| matches!(run.exit_code, exit::BENCH | exit::INTERNAL | exit::REFUSED);
        if let Some((planned, run)) = named().find(|(_, run)| is_ours(run)) {
            return Err(self.failure(why(&planned.procedure.id, run), run.exit_code));
        }
        let early = named().enumerate().find(|(_, (_, run))| run.status != Status::Completed);
        let procedure = early.map_or(0, |(place, _)| place);
        let met = result.must_look.first().cloned();
        Ok(match (met, early) {
            (Some(why), _) => End::Aborted { procedure, why },
            (None, Some((_, (planned, run)))) => {
                End::Aborted { procedure, why: why(&planned.procedure.id, run) }
            }
            (None, None) => End::Completed,
        })
    }
}

/// `AZ-STEP aborted: tracking error of az …`.
fn why(procedure: &str, run: &ProcedureRun) -> String {
    let reason = run.reason.as_deref().unwrap_or("no reason is given");
    format!("{procedure} {}: {reason}", run.status.word())
}

/// Every finding that a requirement judges, in the order of the findings.
fn values(findings: &Findings) -> Vec<ReplicateValue> {
    let mut values: Vec<ReplicateValue> = Vec::new();
    for procedure in findings.procedures.iter().filter(|procedure| procedure.state.is_none()) {
        for judgement in &procedure.judgements {
            let Some(found) = procedure.measurements.get(judgement.measurement) else { continue };
            let place = place(&procedure.id, found);
            let is_same = |value: &&ReplicateValue| {
                value.requirement == judgement.requirement
                    && value.measurand == found.measurand
                    && (value.place == place || value.place.starts_with(&format!("{place} #")))
            };
            let before = values.iter().filter(is_same).count();
            let place = if before == 0 { place } else { format!("{place} #{}", before + 1) };
            values.push(value(judgement, found, place));
        }
    }
    values
}

/// `AZ-VELOCITY-LOOP az, elevation=60 deg`.
fn place(procedure: &str, found: &Measurement) -> String {
    let axis = if found.axis.is_empty() { String::new() } else { format!(" {}", found.axis) };
    let point = found.point.as_deref().filter(|point| !point.is_empty());
    format!("{procedure}{axis}{}", point.map_or_else(String::new, |point| format!(", {point}")))
}

fn value(judgement: &Judgement, found: &Measurement, place: String) -> ReplicateValue {
    let passes = matches!(judgement.verdict, Verdict::Pass | Verdict::ConditionalPass | Verdict::Screened)
        || judgement.verdict == Verdict::None && found.value.is_some();
    // What is inconclusive, in doubt or a bound may be a good number by accident: it counts as none.
    let is_certain = found.inconclusive.is_none() && found.doubt.is_none() && found.bound.is_none();
    ReplicateValue {
        requirement: judgement.requirement.clone(),
        measurand: found.measurand.clone(),
        place,
        value: found.value.filter(|value| value.is_finite() && is_certain),
        u: if found.u.is_finite() { found.u } else { 0.0 },
        passes,
    }
}
