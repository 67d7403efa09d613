//! The sections of a comparison as text and as Markdown.

use std::fmt::Write as _;

use super::RunComparison;
use super::sections;
use crate::markdown;
use crate::printable;
use crate::section::rules_markdown;
use crate::terminal;

/// Rows of a section that a terminal shows; Markdown and data have them all.
const MOST_ROWS: usize = 30;

pub(super) fn text(compared: &RunComparison) -> String {
    let [a, b] = &compared.names;
    let mut out = format!("A: {a}\nB: {b}\n\n");
    for section in sections::differing(compared) {
        section.text(&mut out, MOST_ROWS);
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
        section.markdown(&mut out);
    }
    rules_markdown(&mut out, &sections::rules(compared));
    out
}
