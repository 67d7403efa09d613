//! The sections of a regression as text and as Markdown.

use std::fmt::Write as _;

use super::Regression;
use super::sections::{self, Section};
use crate::markdown;
use crate::printable;
use crate::terminal;

pub(super) fn text(found: &Regression) -> String {
    let mut out = String::new();
    for fact in sections::facts(found) {
        let _ = writeln!(out, "{fact}");
    }
    out.push('\n');
    for section in sections::all(found) {
        let head = section.head.iter().map(|&cell| cell.to_owned()).collect();
        let rows: Vec<Vec<String>> = std::iter::once(head).chain(section.rows).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{}\n{}\n", section.heading, terminal::table(&rows));
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
        table(&mut out, &section);
    }
    let _ = writeln!(out, "## Rules\n");
    for sentence in sections::rules(found) {
        let _ = writeln!(out, "- {}", markdown::text(&sentence));
    }
    out
}

fn table(out: &mut String, section: &Section) {
    let _ = writeln!(out, "## {}\n", markdown::text(&section.heading));
    let _ = writeln!(out, "| {} |\n|{}", section.head.join(" | "), " --- |".repeat(section.head.len()));
    for row in &section.rows {
        markdown::table_row(out, row);
    }
    out.push('\n');
}
