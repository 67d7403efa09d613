//! The sections of a comparison as text and as Markdown.

use std::fmt::Write as _;

use super::RunComparison;
use super::sections::{self, Section};
use crate::markdown;
use crate::printable;
use crate::terminal;

/// Rows of a section that a terminal shows; Markdown and data have them all.
const MOST_ROWS: usize = 30;

pub(super) fn text(compared: &RunComparison) -> String {
    let [a, b] = &compared.names;
    let mut out = format!("A: {a}\nB: {b}\n\n");
    for section in sections::differing(compared) {
        let head = section.head.iter().map(|&cell| cell.to_owned()).collect();
        let more = section.rows.len().saturating_sub(MOST_ROWS);
        let shown = section.rows.into_iter().take(MOST_ROWS);
        let mut rows: Vec<Vec<String>> = std::iter::once(head).chain(shown).collect();
        if more > 0 {
            rows.push(vec![format!("and {more} more")]);
        }
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{}\n{}\n", section.heading, terminal::table(&rows));
    }
    for sentence in sections::rules(compared) {
        let _ = writeln!(out, "{sentence}");
    }
    let _ = write!(out, "{}", compared.headline());
    printable::text(&terminal::plain(&out))
}

pub(super) fn markdown(compared: &RunComparison) -> String {
    let mut out = String::new();
    let [a, b] = compared.names.each_ref().map(|name| markdown::text(name));
    // Writing to a string cannot fail.
    let _ =
        writeln!(out, "# Comparison\n\n- A: {a}\n- B: {b}\n\n**{}**\n", markdown::text(&compared.headline()));
    for section in sections::differing(compared).into_iter().chain(sections::same(compared)) {
        markdown_section(&mut out, &section);
    }
    let _ = writeln!(out, "## Rules\n");
    for sentence in sections::rules(compared) {
        let _ = writeln!(out, "- {}", markdown::text(&sentence));
    }
    out
}

fn markdown_section(out: &mut String, section: &Section) {
    let _ = writeln!(out, "## {}\n", markdown::text(&section.heading));
    let _ = writeln!(out, "| {} |\n|{}", section.head.join(" | "), " --- |".repeat(section.head.len()));
    for row in &section.rows {
        markdown::table_row(out, row);
    }
    out.push('\n');
}
