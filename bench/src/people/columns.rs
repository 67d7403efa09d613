//! How wide the terminal of a person is, and text that is broken between words to fit.

use std::io::IsTerminal;

/// How wide text for a person may be; `None` where lines are not to be broken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Columns(pub(crate) Option<usize>);

/// Text that is broken more narrowly than this is not read.
const LEAST_ROOM: usize = 24;

impl Columns {
    /// Lines are broken on a terminal only.
    pub(crate) fn of_stdout() -> Self {
        let terminal = std::io::stdout().is_terminal();
        Self(terminal.then(|| usize::from(console::Term::stdout().size().1)))
    }

    /// As [`Self::of_stdout`], of stderr.
    pub(crate) fn of_stderr() -> Self {
        let terminal = std::io::stderr().is_terminal();
        Self(terminal.then(|| usize::from(console::Term::stderr().size().1)))
    }

    /// Text that begins `width` columns from the left, broken between words where a line would not fit.
    pub(crate) fn hanging(self, width: usize, text: &str) -> String {
        let room = self.0.map_or(usize::MAX, |columns| columns.saturating_sub(width + 1).max(LEAST_ROOM));
        wrapped(text, room).join(&format!("\n{}", " ".repeat(width)))
    }

    /// Lines, each broken between words where it would not fit; what goes on is indented.
    pub(crate) fn lines(self, text: &str) -> String {
        text.split('\n').map(|line| self.hanging(INDENT, line)).collect::<Vec<_>>().join("\n")
    }
}

/// What goes on of a broken line begins so far from the left.
const INDENT: usize = 2;

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
