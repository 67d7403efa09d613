//! Results on stdout, everything else on stderr.

use procedures::diagnostic::Diagnostic;
use procedures::table::MOST_MISTAKES;

use crate::exit;
use crate::plan::PlanError;

pub(super) use crate::people::columns::Columns;
pub(super) use crate::people::console::{note, say, say_parts};
pub(super) use reports::terminal::table;

/// How the program was called, for the record; what is not UTF-8 is replaced.
pub(super) fn command_line() -> String {
    std::env::args_os().map(|a| a.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

/// An error on stderr.
pub(super) fn error(text: &str) {
    note(&format!("error: {text}"));
}

/// An error on stderr that the person can mend; gives the exit code for it.
pub(super) fn mistake(text: &str) -> u8 {
    error(text);
    exit::USAGE
}

/// The first mistakes on stderr, with the count of all.
pub(super) fn mistakes(found: &[Diagnostic]) -> u8 {
    // The last one of a file may be the count of those that are not told.
    const MOST_SHOWN: usize = MOST_MISTAKES + 1;
    for mistake in found.iter().take(MOST_SHOWN) {
        note(&format!("{mistake}"));
    }
    if found.len() > MOST_SHOWN {
        note(&format!("and {} more", found.len() - MOST_SHOWN));
    }
    if found.len() > 1 {
        note(&format!("{} mistakes", found.len()));
    }
    exit::USAGE
}

/// Prints a plan error; `refusal` is the exit code where only the rig says no.
pub(super) fn plan_error(found: &PlanError, refusal: u8) -> u8 {
    match found {
        PlanError::Mistakes(all) => mistakes(all),
        PlanError::Refused(all) => {
            mistakes(all);
            refusal
        }
        PlanError::NothingSelected(message) => {
            error(message);
            exit::NOTHING_SELECTED
        }
    }
}
