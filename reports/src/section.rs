//! A heading with a table below it, as text and as Markdown: what comparisons, regressions and populations are written in.

use std::fmt::Write as _;

use crate::{markdown, terminal};

/// A heading and the table below it.
pub(crate) struct Section {
    heading: String,
    head: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Section {
    pub(crate) fn new(heading: impl Into<String>, head: &[&str], rows: Vec<Vec<String>>) -> Self {
        Self { heading: heading.into(), head: head.iter().map(|&cell| cell.to_owned()).collect(), rows }
    }

    /// Whether there is nothing below the heading.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// For a terminal, with at most so many rows.
    pub(crate) fn text(&self, out: &mut String, most_rows: usize) {
        let shown = self.rows.iter().take(most_rows).cloned();
        let mut rows: Vec<Vec<String>> = std::iter::once(self.head.clone()).chain(shown).collect();
        let more = self.rows.len().saturating_sub(most_rows);
        if more > 0 {
            rows.push(vec![format!("and {more} more")]);
        }
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{}\n{}\n", self.heading, terminal::table(&rows));
    }

    pub(crate) fn markdown(&self, out: &mut String) {
        let _ = writeln!(out, "## {}\n", markdown::text(&self.heading));
        let head: Vec<&str> = self.head.iter().map(String::as_str).collect();
        markdown::table(out, &head, &self.rows);
    }
}

/// The rules by which the tables were made, as the last section of a page.
pub(crate) fn rules_markdown(out: &mut String, rules: &[String]) {
    *out += "## Rules\n\n";
    for sentence in rules {
        let _ = writeln!(out, "- {}", markdown::text(sentence));
    }
}
