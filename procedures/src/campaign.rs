//! A campaign file: which procedures, in which order, and which requirements must get a verdict.

use crate::diagnostic::{Diagnostic, SourceFile};

/// A subset of a procedure's sweep: condition name and the SI values to keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Subset {
    /// E.g. `velocity`.
    pub condition: String,
    /// Values to keep, SI.
    pub values: Vec<f64>,
}

/// One procedure of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// File as written.
    pub file: String,
    /// Points to keep; all if empty.
    pub points: Vec<Subset>,
    /// Where it stands in the campaign file, for diagnostics.
    pub span: std::ops::Range<usize>,
}

/// A campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// E.g. `quick`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Requirements file as written.
    pub requirements: String,
    /// Ids that must get a verdict.
    pub must_measure: Vec<String>,
    /// Procedures in order.
    pub procedures: Vec<Entry>,
    /// The file.
    pub source: SourceFile,
}

impl Campaign {
    /// Parses a campaign file (without opening the files it names).
    ///
    /// # Errors
    /// All mistakes at once.
    pub fn parse(source: SourceFile) -> Result<Self, Vec<Diagnostic>> {
        let _ = source;
        todo!()
    }
}
