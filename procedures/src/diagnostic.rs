//! Mistakes in files that people wrote: where, what was expected, what was found, what to do.

use std::fmt;
use std::ops::Range;

#[cfg(test)]
mod tests;

/// A file that a person wrote, kept for pointing into it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// Name as the person gave it.
    pub name: String,
    /// Text of the file.
    pub text: String,
}

/// One mistake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Name of the file, if it lies in one.
    pub file: Option<String>,
    /// Byte range in the file.
    pub span: Option<Range<usize>>,
    /// Line, 1-based, filled in when the span is known.
    pub line: Option<usize>,
    /// The line's text and the range of characters inside it, for underlining; the column is its start + 1.
    pub excerpt: Option<(String, Range<usize>)>,
    /// What is wrong: expected and found.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
}

impl SourceFile {
    /// A file by its name and text.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { name: name.into(), text: text.into() }
    }
}

impl Diagnostic {
    /// A mistake without a place.
    pub fn new(message: impl Into<String>) -> Self {
        Self { file: None, span: None, line: None, excerpt: None, message: message.into(), help: None }
    }

    /// The diagnostic with advice.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The diagnostic with its place in a file. A span beyond the text points at the text's end.
    #[must_use]
    pub fn at(self, source: &SourceFile, span: Range<usize>) -> Self {
        let text = &source.text;
        let start = floor_boundary(text, span.start);
        let end = floor_boundary(text, span.end).max(start);
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
        let line = text[line_start..line_end].trim_end_matches('\r');
        let from = text[line_start..start].chars().count();
        let to = from + text[start..end.min(line_end).max(start)].chars().count();
        // A tab or another control character would move the carets; as a blank it keeps its column.
        let shown: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        Self {
            file: Some(source.name.clone()),
            span: Some(start..end),
            line: Some(1 + text[..start].matches('\n').count()),
            excerpt: Some((shown, from..to)),
            ..self
        }
    }

    /// The diagnostic in a file, without a place inside it.
    #[must_use]
    pub fn in_file(self, source: &SourceFile) -> Self {
        Self { file: Some(source.name.clone()), ..self }
    }
}

fn floor_boundary(text: &str, at: usize) -> usize {
    let at = at.min(text.len());
    (0..=at).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0)
}

/// The way compilers do: message, file:line:column, the line, carets, help.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.message)?;
        let margin = self.line.map_or(1, |line| line.to_string().len());
        if let Some(file) = &self.file {
            write!(f, "\n{:margin$}--> {file}", "")?;
        }
        if let (Some(line), Some((text, columns))) = (self.line, &self.excerpt) {
            write!(f, ":{line}:{}", columns.start + 1)?;
            let (text, columns) = window(text, columns);
            let carets = "^".repeat(columns.len().max(1));
            write!(f, "\n{:margin$} |\n{line} | {text}\n{:margin$} | ", "", "")?;
            write!(f, "{:1$}{carets}", "", columns.start)?;
        }
        match &self.help {
            Some(help) => write!(f, "\n{:margin$} = help: {help}", ""),
            None => Ok(()),
        }
    }
}

/// The part of a very long line that lies around the marked characters.
fn window(text: &str, columns: &Range<usize>) -> (String, Range<usize>) {
    const WIDTH: usize = 140;
    const BEFORE: usize = 40;
    let length = text.chars().count();
    if length <= WIDTH {
        return (text.trim_end().to_owned(), columns.clone());
    }
    let from = columns.start.saturating_sub(BEFORE);
    let part: String = text.chars().skip(from).take(WIDTH).collect();
    let end = columns.end.saturating_sub(from).min(WIDTH);
    (part.trim_end().to_owned(), (columns.start - from)..end)
}

/// The nearest of `known` to a misspelt `word`, if near enough to be meant: at most a third of the longer word's
/// letters wrong (optimal string alignment distance, case ignored), the first in order among equals.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const LONGEST: usize = 100;
    if word.len() > LONGEST {
        return None;
    }
    let lower = word.to_lowercase();
    known
        .into_iter()
        .map(|candidate| (strsim::osa_distance(&lower, &candidate.to_lowercase()), candidate))
        .filter(|(wrong, candidate)| {
            let longer = candidate.chars().count().max(word.chars().count());
            *wrong <= (longer / 3).max(1) && *wrong < candidate.chars().count()
        })
        .min_by_key(|(wrong, _)| *wrong)
        .map(|(_, candidate)| candidate)
}
