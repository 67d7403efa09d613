//! `results.json`: findings and record as data.
//!
//! Two spaces an indent, keys in the order of the structures, a series of numbers on one line, one newline at the
//! end. Numbers are written with the fewest digits that read back to the same bits.

use serde::Serialize;

use crate::record::{Findings, Results, SCHEMA};

mod layout;

use layout::Layout;

/// The whole result.
pub fn render(results: &Results) -> String {
    let mut finite = results.clone();
    finite.make_finite();
    to_text(&finite)
}

/// The findings alone: the bytes that the same seed, limits and program reproduce.
pub fn findings(findings: &Findings) -> String {
    let mut finite = findings.clone();
    finite.make_finite();
    to_text(&finite)
}

pub(crate) fn to_text(value: &impl Serialize) -> String {
    let mut bytes = Vec::new();
    let mut serializer = serde_json::Serializer::with_formatter(&mut bytes, Layout::default());
    value
        .serialize(&mut serializer)
        .expect("the structures have string keys only and a vector takes every byte");
    bytes.push(b'\n');
    String::from_utf8(bytes).expect("serde_json writes UTF-8")
}

/// Why a text is no result.
#[derive(Debug)]
pub enum ReadError {
    /// The text is not JSON, or not of the structure.
    Json(serde_json::Error),
    /// The text is a result of another schema.
    Schema {
        /// The schema that it names.
        found: String,
    },
}

impl std::fmt::Display for ReadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Json(error) => write!(f, "not a result: {error}"),
            Self::Schema { found } => write!(f, "result of schema `{found}`, expected `{SCHEMA}`"),
        }
    }
}

impl std::error::Error for ReadError {}

/// Reads what [`render`] wrote.
///
/// # Errors
/// Text that is not JSON, not of the structure, or of another schema.
pub fn parse(text: &str) -> Result<Results, ReadError> {
    #[derive(serde::Deserialize)]
    struct Head {
        schema: String,
    }
    let head: Head = serde_json::from_str(text).map_err(ReadError::Json)?;
    if head.schema != SCHEMA {
        return Err(ReadError::Schema { found: head.schema });
    }
    serde_json::from_str(text).map_err(ReadError::Json)
}

#[cfg(test)]
mod tests;
