//! One log of several: what is wrong with it costs its own procedure and no other.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use procedures::log::LogError;
use procedures::requirement::Requirements;
use reports::record::{Origin, Status};
use serde::{Deserialize, Serialize};

use super::findings::without;
use super::{HeatSinks, JudgeError, JudgeFn, JudgedLog, Known};
use crate::exit;
use crate::record::page::PlannedLog;

/// What stood in the way of judging a log, in a sentence with its path.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Trouble {
    /// The log was judged as far as it is whole.
    Damaged(String),
    /// Nothing of it could be judged.
    Unreadable(String),
    /// The judge has a defect.
    Panicked(String),
}

impl Trouble {
    /// The sentence.
    pub fn text(&self) -> &str {
        let (Self::Damaged(text) | Self::Unreadable(text) | Self::Panicked(text)) = self;
        text
    }

    /// What it means for the program's exit.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Damaged(_) | Self::Unreadable(_) => exit::DAMAGED,
            Self::Panicked(_) => exit::INTERNAL,
        }
    }
}

/// A log after an attempt to judge it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tried {
    /// What it found; a procedure that errored, without a number, where it could not be judged.
    pub log: JudgedLog,
    /// What stood in the way.
    pub trouble: Option<Trouble>,
}

/// Judges the log of a planned procedure by requirements and by what other logs found; `seed` is that of the run.
pub fn try_log(
    judge: JudgeFn,
    path: &Path,
    planned: &PlannedLog,
    requirements: &Requirements,
    known: &Known,
    seed: u64,
) -> Tried {
    // Whoever opens a pipe waits for its writer.
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        let reason = "the log cannot be judged: not a regular file".to_owned();
        let text = format!("{}: {reason}", path.display());
        return Tried { log: unjudged(planned, seed, reason), trouble: Some(Trouble::Unreadable(text)) };
    }
    match catch_unwind(AssertUnwindSafe(|| judge(path, &planned.log, requirements, known))) {
        Ok(Ok(log)) => {
            let trouble = log.damage.clone().map(Trouble::Damaged);
            Tried { log, trouble }
        }
        Ok(Err(error)) => {
            let log = unjudged(planned, seed, format!("the log cannot be judged: {}", without_path(&error)));
            Tried { log, trouble: Some(Trouble::Unreadable(error.to_string())) }
        }
        Err(_) => {
            let reason = "internal error: the judge panicked".to_owned();
            let log = unjudged(planned, seed, reason.clone());
            Tried { log, trouble: Some(Trouble::Panicked(reason)) }
        }
    }
}

/// Findings name a log by its name in the run folder: where that folder lies must not change them.
fn without_path(error: &JudgeError) -> String {
    match error {
        JudgeError::Log(LogError::Io { source, .. }) => source.to_string(),
        JudgeError::Log(LogError::Foreign { reason, .. }) => reason.clone(),
        JudgeError::Log(LogError::Damaged { reason, .. }) => format!("damaged: {reason}"),
        JudgeError::Attachment { name, mistake, .. } => format!("attached {name}: {mistake}"),
    }
}

/// A procedure whose log was there and is gone: the journal says so.
pub fn missing(planned: &PlannedLog, seed: u64) -> JudgedLog {
    let reason = "its log was removed or replaced while the run was going on".to_owned();
    let mut judged = unjudged(planned, seed, reason);
    judged.findings.log = None;
    judged
}

/// A log that could not be judged.
pub(super) fn unjudged(planned: &PlannedLog, seed: u64, reason: String) -> JudgedLog {
    let mut findings = without(planned, Status::Errored, reason);
    findings.log = Some(planned.log.clone());
    let yields = planned.yields.clone();
    // Nothing proves more.
    let origin = Origin::Simulated;
    let heat_sinks_degc = HeatSinks::new();
    JudgedLog {
        findings,
        damage: None,
        size_bytes: 0,
        yields,
        seed,
        origin,
        proof: None,
        heat_sinks_degc,
        outer_axis: None,
        lateness: Vec::new(),
    }
}
