//! The sections of a regression as text and as Markdown.

use std::fmt::Write as _;

use super::Regression;
use super::sections;
use crate::markdown;
use crate::printable;
use crate::section::rules_markdown;
use crate::terminal;

pub(super) fn text(found: &Regression) -> String {
    let mut out = String::new();
    for fact in sections::facts(found) {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{fact}");
    }
    out.push('\n');
    for section in sections::all(found) {
        section.text(&mut out, usize::MAX);
    }
    for sentence in sections::rules(found) {
        let _ = writeln!(out, "{sentence}");
    }
    let _ = write!(out, "{}", found.headline());
    printable::text(&terminal::plain(&out))
}

pub(super) fn markdown(found: &Regression) -> String {
    let mut out = format!("# Servo regression: {}\n\n", markdown::text(&found.headline()));
    for fact in sections::facts(found) {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "- {}", markdown::text(&fact));
    }
    out.push('\n');
    for section in sections::all(found) {
        section.markdown(&mut out);
    }
    rules_markdown(&mut out, &sections::rules(found));
    out
}
