//! Verdicts on paper: what a run found, as data and as documents.
//!
//! A caller fills [`record::Results`]; each renderer of [`FORMATS`] is a pure function from it to the bytes of a file. Nothing here
//! reads a clock, a file or a locale: the same results give the same bytes.

pub mod comparison;
mod coverage;
pub mod csv;
pub mod html;
pub mod json;
pub mod junit;
pub mod markdown;
mod markup;
mod number;
pub mod plot;
pub mod population;
pub mod printable;
pub mod record;
pub mod regression;
mod row;
mod safety;
#[cfg(test)]
#[path = "../examples/sample/mod.rs"]
mod sample;
mod section;
pub mod terminal;
mod words;

pub use words::screening;

// The sample is shared with an example, which sees this crate from outside.
#[cfg(test)]
extern crate self as reports;

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
    /// The renderer: content of the file.
    pub render: fn(&Results) -> Vec<u8>,
}

/// Every format there is. A new format is one file and one line here.
pub const FORMATS: &[Format] = &[
    Format {
        name: "html",
        file: "report.html",
        doc: "One self-contained page with figures; prints on A4",
        render: |results| html::render(results).into_bytes(),
    },
    Format {
        name: "json",
        file: "results.json",
        doc: "Findings and record as JSON",
        render: |results| json::render(results).into_bytes(),
    },
    Format {
        name: "junit",
        file: "junit.xml",
        doc: "A test case for each requirement and limit, in JUnit format for build servers",
        render: |results| junit::render(results).into_bytes(),
    },
    Format {
        name: "csv",
        file: "results.csv",
        doc: "A row for each measurement and requirement: SI and the unit of the limit, a column for each condition",
        render: |results| csv::render(results).into_bytes(),
    },
    Format {
        name: "requirements-csv",
        file: "requirements.csv",
        doc: "A row for each requirement and limit, with the measurement that decided",
        render: |results| csv::requirements::render(results).into_bytes(),
    },
    Format {
        name: "md",
        file: "report.md",
        doc: "Tables in Markdown, for merge requests",
        render: |results| markdown::render(results).into_bytes(),
    },
];

/// The format of this name.
pub fn format(name: &str) -> Option<&'static Format> {
    FORMATS.iter().find(|f| f.name == name)
}

#[cfg(test)]
mod tests;
