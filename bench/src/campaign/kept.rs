//! What a run keeps: every file goes on record in the journal as soon as it is whole, and must still be there in the end.

use std::io::ErrorKind;
use std::path::Path;
use std::sync::Mutex;

use reports::record::{FileHash, Status};

use super::procedure_run::{ProcedureRun, keep};
use super::{RunResult, Setup};
use crate::exit;
use crate::judge;
use crate::record::journal::{Entry, Journal, sha256_of};

/// A file, for the journal.
pub(super) fn entry(file: FileHash) -> Entry {
    let FileHash { file, size_bytes, sha256 } = file;
    Entry::Kept { file, sha256, size_bytes }
}

/// What became of the log of a procedure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Log {
    /// Closed and on record.
    Kept,
    /// The log was written and is gone or cannot be read.
    Missing,
    /// No log was ever written.
    None,
}

/// Puts the closed log of a procedure on record. One that is gone makes the procedure errored, whatever was measured.
pub(super) fn put_on_record(
    path: &Path,
    file: &str,
    journal: &Mutex<Journal>,
    run: &mut ProcedureRun,
) -> Log {
    let reason = match look(path) {
        Ok((sha256, size_bytes)) => {
            keep(journal, entry(FileHash { file: file.to_owned(), size_bytes, sha256 }), run);
            return Log::Kept;
        }
        // Nothing went through the loop: no log was begun, or there is nothing in it.
        Err(error) if error.kind() == ErrorKind::NotFound && run.loop_s <= 0.0 => return Log::None,
        Err(error) => missing(path, &error),
    };
    fail(run, &reason);
    keep(journal, Entry::Missing { file: file.to_owned(), reason }, run);
    Log::Missing
}

/// Puts the log of a session on record.
pub(super) fn keep_session(setup: &Setup<'_>, file: &str, journal: &Mutex<Journal>) {
    let file = file.to_owned();
    let path = setup.folder.join(&file);
    let entry = match look(&path) {
        Ok((sha256, size_bytes)) => entry(FileHash { file, size_bytes, sha256 }),
        Err(error) => Entry::Missing { file, reason: missing(&path, &error) },
    };
    // A journal that cannot be written any more shows itself when it is closed.
    let _ = journal.lock().map(|mut journal| journal.write(entry));
}

/// Digest and length of what lies there itself: not of what a link leads to.
fn look(path: &Path) -> std::io::Result<(String, u64)> {
    if std::fs::symlink_metadata(path)?.is_file() {
        return sha256_of(path);
    }
    Err(std::io::Error::other("no longer a regular file"))
}

fn missing(path: &Path, error: &std::io::Error) -> String {
    let help = "keep other programs out of the run folder, and repeat the procedures whose logs were lost";
    format!("{}: removed or replaced while the run was going on: {error}; {help}", path.display())
}

fn fail(run: &mut ProcedureRun, reason: &str) {
    run.status = Status::Errored;
    run.reason = Some(reason.to_owned());
    run.exit_code = exit::worse(run.exit_code, exit::BENCH);
}

/// Looks at everything on record once more before the results are made: what is gone or changed is not believed.
pub(super) fn look_again(setup: &Setup<'_>, result: &mut RunResult) {
    for kept in result.journal.kept().to_vec() {
        let path = setup.folder.join(&kept.file);
        let reason = match look(&path) {
            Ok((sha256, _)) if sha256 == kept.sha256 => continue,
            Ok(_) => format!("{}: changed while the run was going on", path.display()),
            Err(error) => missing(&path, &error),
        };
        result.exit_code = exit::worse(result.exit_code, exit::BENCH);
        let planned = &result.page.procedures;
        if let Some(index) = planned.iter().position(|planned| planned.log == kept.file) {
            fail(&mut result.runs[index], &reason);
            result.judged[index] = Some(judge::missing(&planned[index], setup.seed));
        }
        // A journal that cannot be written any more shows itself when it is closed.
        let _ = result.journal.write(Entry::Missing { file: kept.file, reason });
    }
}
