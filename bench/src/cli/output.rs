//! Results on stdout, everything else on stderr.

use std::io::IsTerminal;

use procedures::diagnostic::Diagnostic;
use procedures::table::MOST_MISTAKES;

use crate::exit;
use crate::plan::PlanError;

pub(super) use crate::people::console::{note, say, say_parts};

/// How the program was called, for the record; what is not UTF-8 is replaced.
pub(super) fn command_line() -> String {
    std::env::args_os().map(|a| a.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

/// An error on stderr.
pub(super) fn error(text: &str) {
    note(&format!("error: {text}"));
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

/// How wide text for a person may be; `None` where lines are not to be broken.
#[derive(Clone, Copy, Debug)]
pub(super) struct Columns(pub(super) Option<usize>);

impl Columns {
    /// Lines are broken on a terminal only.
    pub(super) fn of_stdout() -> Self {
        let terminal = std::io::stdout().is_terminal();
        Self(terminal.then(|| usize::from(console::Term::stdout().size().1)))
    }

    /// Text that begins `width` columns from the left, broken between words where a line would not fit.
    pub(super) fn hanging(self, width: usize, text: &str) -> String {
        let room = self.0.map_or(usize::MAX, |columns| columns.saturating_sub(width + 1).max(LEAST_ROOM));
        wrapped(text, room).join(&format!("\n{}", " ".repeat(width)))
    }
}

/// Text that is broken more narrowly than this is not read.
const LEAST_ROOM: usize = 24;

fn wrapped(text: &str, room: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.last_mut().expect("there is always a line");
        let wide = last.chars().count() + 1 + word.chars().count() > room;
        match (last.is_empty(), wide) {
            (true, _) => last.push_str(word),
            (false, true) => lines.push(word.to_owned()),
            (false, false) => {
                last.push(' ');
                last.push_str(word);
            }
        }
    }
    lines
}

/// Rows as aligned columns, the header first.
pub(super) fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells: Vec<String> = row
            .iter()
            .zip(&widths)
            .map(|(cell, &w)| format!("{cell}{}", " ".repeat(w - cell.chars().count())))
            .collect();
        cells.join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}
