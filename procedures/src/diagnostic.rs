//! Mistakes in files that people wrote: where, what was expected, what was found, what to do.

use std::fmt;
use std::ops::Range;

/// A file that a person wrote, kept for pointing into it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// Name as the person gave it.
    pub name: String,
    /// Its text.
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
    /// The line's text and the column range inside it, for underlining.
    pub excerpt: Option<(String, Range<usize>)>,
    /// What is wrong: expected and found.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
}

impl Diagnostic {
    /// A mistake without a place.
    pub fn new(message: impl Into<String>) -> Self {
        Self { file: None, span: None, line: None, excerpt: None, message: message.into(), help: None }
    }

    /// The same with advice.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The same with its place in a file.
    #[must_use]
    pub fn at(self, source: &SourceFile, span: Range<usize>) -> Self {
        let _ = (source, span);
        todo!()
    }
}

/// The way compilers do: message, file:line:column, the line, carets, help.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let _ = f;
        todo!()
    }
}

/// The nearest of `known` to a misspelt `word`, if near enough to be meant.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let _ = (word, known.into_iter());
    todo!()
}
