//! How a procedure ended, and its line in the journal.

use std::sync::Mutex;

use reports::record::Status;

use super::Setup;
use crate::exit;
use crate::people::{Denied, signals};
use crate::record::journal::{Entry, Journal};

/// How a procedure ended.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcedureRun {
    /// Status.
    pub status: Status,
    /// Why it did not complete.
    pub reason: Option<String>,
    /// Loop time of its points.
    pub loop_s: f64,
    /// What it means for the program's exit.
    pub exit_code: u8,
}

impl ProcedureRun {
    /// A worker that vanished.
    pub(super) fn crashed() -> Self {
        let reason = Some("internal error: the worker of this procedure panicked".to_owned());
        Self { status: Status::Errored, reason, loop_s: 0.0, exit_code: exit::INTERNAL }
    }

    /// Not begun, because a signal came first.
    pub(super) fn not_run(code: u8) -> Self {
        let reason = Some("stopped before it began".to_owned());
        Self { status: Status::NotRun, reason, loop_s: 0.0, exit_code: code }
    }

    /// Not begun, because a gate of the run is closed.
    pub(super) fn held_back(reason: String) -> Self {
        Self { status: Status::Skipped, reason: Some(reason), loop_s: 0.0, exit_code: exit::INCONCLUSIVE }
    }

    pub(super) fn stopped(&mut self, code: u8) {
        self.status = Status::Aborted;
        self.reason = Some(signals::cause(code).to_owned());
        self.exit_code = exit::worse(self.exit_code, code);
    }

    /// Not begun, because a prompt was not answered with yes.
    pub(super) fn denied(denied: Denied) -> Self {
        match denied {
            Denied::Stopped(code) => Self::not_run(code),
            Denied::Refused(reason) => {
                Self { status: Status::Skipped, reason: Some(reason), loop_s: 0.0, exit_code: exit::REFUSED }
            }
        }
    }

    /// Refused after some of its points, because a prompt was not answered with yes.
    pub(super) fn denied_in_between(&mut self, denied: Denied) {
        match denied {
            Denied::Stopped(code) => self.stopped(code),
            Denied::Refused(reason) => {
                self.status = Status::Aborted;
                self.reason = Some(reason);
                self.exit_code = exit::worse(self.exit_code, exit::REFUSED);
            }
        }
    }

    pub(super) fn errored(reason: String, exit_code: u8) -> Self {
        Self { status: Status::Errored, reason: Some(reason), loop_s: 0.0, exit_code }
    }
}

/// Writes the end of a procedure into the journal.
pub(super) fn note_end(
    setup: &Setup<'_>,
    index: usize,
    journal: &Mutex<Journal>,
    run: &mut ProcedureRun,
    log: Option<String>,
) {
    let procedure = setup.plan.procedures[index].procedure.id.clone();
    let status = run.status.word().to_owned();
    let reason = run.reason.clone();
    keep(journal, Entry::ProcedureEnded { procedure, status, log, reason }, run);
}

/// A journal that cannot be written any more makes the run a bench failure, but stops nothing that is in motion.
pub(super) fn keep(journal: &Mutex<Journal>, entry: Entry, run: &mut ProcedureRun) {
    let written = journal.lock().map(|mut j| j.write(entry));
    if !matches!(written, Ok(Ok(()))) {
        run.exit_code = exit::worse(run.exit_code, exit::BENCH);
        run.reason.get_or_insert_with(|| "the journal can no longer be written".to_owned());
    }
}
