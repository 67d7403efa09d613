//! Verdicts on paper: what a run found, as data and as documents.
//!
//! A caller fills [`record::Results`]; each renderer of [`FORMATS`] is a pure function from it to text. Nothing here
//! reads a clock, a file or a locale: the same results give the same bytes.

pub mod html;
pub mod json;
mod markup;
mod number;
pub mod plot;
pub mod record;
mod row;
mod words;

use record::Results;

/// A format in which results are written.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Name on the command line, e.g. `html`.
    pub name: &'static str,
    /// File name in the run folder.
    pub file: &'static str,
    /// One sentence: what it is for.
    pub doc: &'static str,
    /// The renderer.
    pub render: fn(&Results) -> String,
}

/// Every format there is. A new format is one file and one line here.
pub const FORMATS: &[Format] = &[Format {
    name: "json",
    file: "results.json",
    doc: "Findings and record as data",
    render: json::render,
}];

/// The format of this name.
pub fn format(name: &str) -> Option<&'static Format> {
    FORMATS.iter().find(|f| f.name == name)
}
