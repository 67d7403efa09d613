//! A whole file that people write: its size, grammar, then keys, then what is left over, all mistakes together.

use std::ops::Range;

use toml::de::DeTable;

use super::reader::{Found, TableReader};
use super::{Field, mistake_in, sort_by_place};
use crate::diagnostic::{Diagnostic, SourceFile};

/// Largest file that people write, bytes: the longest shipped one has 60 kB.
pub const MOST_BYTES: usize = 1 << 20;

/// Mistakes of one file that are told; a file with more is not what it was taken for.
pub const MOST_MISTAKES: usize = 100;

/// Largest number of values in a list, of tables in an array, of entries in a table with free keys.
pub const MOST_ENTRIES: usize = 1000;

/// Largest number of steps (points, or segments of a point) that the lists and counts of one procedure may multiply to: the
/// longest shipped one has 500.
pub const MOST_STEPS: usize = 10_000;

/// Why a text is not even parsed.
fn too_large(source: &SourceFile) -> Option<Diagnostic> {
    (source.text.len() > MOST_BYTES)
        .then(|| Diagnostic::new(size_message(source.text.len() as u64)).in_file(source).help(SIZE_HELP))
}

/// What is wrong with a file of this size that people are said to have written.
pub fn size_message(bytes: u64) -> String {
    format!("the file has {bytes} bytes; expected at most {MOST_BYTES}")
}

/// What to do about it.
pub const SIZE_HELP: &str = "this is not a file of the bench: check its name";

/// What stands in the place of mistakes that are not told.
fn and_more(source: &SourceFile, more: usize) -> Diagnostic {
    let message = format!("and {more} more mistakes in this file");
    Diagnostic::new(message).in_file(source).help("correct the first ones and check again")
}

/// Parses a file and reads its root table.
///
/// `read` gets the root reader; afterwards keys that are left over are reported with the nearest known key.
///
/// # Errors
/// All mistakes at once, in order of their place; also those of TOML's own grammar. Where the grammar is broken,
/// missing keys are not reported: what follows a broken line may have been swallowed with it.
pub fn read_file<T>(
    source: &SourceFile,
    fields: &'static [Field],
    read: impl FnOnce(&mut TableReader<'_>) -> Option<T>,
) -> Result<T, Vec<Diagnostic>> {
    if let Some(mistake) = too_large(source) {
        return Err(vec![mistake]);
    }
    let (root, grammar) = DeTable::parse_recoverable(&source.text);
    let mut table = TableReader::new(source, Some(root.get_ref()), 0..0, fields, MOST_MISTAKES);
    let result = read(&mut table);
    let of_root: Vec<&str> = table.known_keys();
    let (found, untold) = table.finish();
    let grammar = without_consequences(source, &grammar);
    let untold = untold + grammar.len().saturating_sub(MOST_MISTAKES);
    let mut mistakes: Vec<Diagnostic> = grammar
        .into_iter()
        .take(MOST_MISTAKES)
        .map(|(message, span)| {
            let help = grammar_help(source, &message, &span);
            mistake_in(source, span, sentence(&message), help)
        })
        .collect();
    let broken = !mistakes.is_empty();
    let broken_lines: Vec<_> = mistakes.iter().map(|m| m.line).collect();
    let kept = found.into_iter().filter(|f| !broken || !f.missing && !broken_lines.contains(&f.mistake.line));
    mistakes.extend(kept.map(|Found { mistake, .. }| of_the_top(source, mistake, &of_root)));
    match result {
        Some(value) if mistakes.is_empty() => Ok(value),
        None if mistakes.is_empty() => {
            Err(vec![Diagnostic::new("the file cannot be read and no reason was given").in_file(source)])
        }
        _ => {
            sort_by_place(&mut mistakes);
            let untold = untold + mistakes.len().saturating_sub(MOST_MISTAKES);
            mistakes.truncate(MOST_MISTAKES);
            mistakes.extend((untold > 0).then(|| and_more(source, untold)));
            Err(mistakes)
        }
    }
}

/// The parser's words, marked as TOML's own grammar.
fn sentence(message: &str) -> String {
    format!("not TOML: {message}")
}

const DUPLICATE: &str = "duplicate key";

/// Whether a place stands in the head of a table, `[name]`.
fn is_head(source: &SourceFile, span: &Range<usize>) -> bool {
    let start = source.text[..span.start.min(source.text.len())].rfind('\n').map_or(0, |at| at + 1);
    source.text[start..].trim_start().starts_with('[')
}

/// Mistakes of the grammar with their places. Where a table comes a second time, so do all of its keys: only the first head is told.
fn without_consequences(source: &SourceFile, grammar: &[toml::de::Error]) -> Vec<(String, Range<usize>)> {
    let all = grammar.iter().map(|error| (error.message().to_owned(), error.span().unwrap_or(0..0)));
    let all: Vec<(String, Range<usize>)> = all.collect();
    let twice = |(message, span): &(String, Range<usize>)| message == DUPLICATE && is_head(source, span);
    let Some(first) = all.iter().position(twice) else { return all };
    let told = |(k, (message, _)): &(usize, (String, Range<usize>))| *k == first || message != DUPLICATE;
    all.into_iter().enumerate().filter(told).map(|(_, mistake)| mistake).collect()
}

/// What to do about a mistake of the grammar, where that can be told.
fn grammar_help(source: &SourceFile, message: &str, span: &Range<usize>) -> Option<String> {
    if message != DUPLICATE {
        return None;
    }
    let name = source.text.get(span.clone()).unwrap_or_default();
    Some(match is_head(source, span) {
        true => format!("a table that may occur more than once needs double brackets: `[[{name}]]`"),
        false => format!("`{name}` is already defined: remove one of the two"),
    })
}

/// A key that nobody knows in a table, and that belongs to the top of the file: TOML takes what follows the head of a table for a
/// part of it.
fn of_the_top(source: &SourceFile, mistake: Diagnostic, of_root: &[&str]) -> Diagnostic {
    let word = mistake.message.strip_prefix("unknown ").and_then(|rest| rest.split('`').nth(1));
    let Some(word) = word.filter(|word| of_root.contains(word)) else { return mistake };
    let before = mistake.span.as_ref().map_or("", |span| &source.text[..span.start.min(source.text.len())]);
    let head = before.lines().rev().find(|line| line.trim_start().starts_with('['));
    let Some(head) = head else { return mistake };
    let help = format!(
        "`{word}` belongs at the top of the file: write it above the first table, not under `{}`",
        head.trim()
    );
    mistake.help(help)
}
