//! Reads people's TOML by key, collects all mistakes with their places, reports keys that nobody asked for.

use std::ops::Range;

use crate::diagnostic::{Diagnostic, SourceFile};
use crate::quantity::{Limit, QuantityKind};

/// What a key holds.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Any text.
    Text,
    /// A list of texts.
    Texts,
    /// A whole number.
    Integer,
    /// true or false.
    Boolean,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A quoted quantity, `"10 deg/s"`.
    Quantity(QuantityKind),
    /// A list of quoted quantities.
    Quantities(QuantityKind),
    /// `"-60 deg .. 60 deg"`.
    Range(QuantityKind),
    /// `"<= 45 N*m"`, `"34 Hz .. 43 Hz"`.
    Limit(QuantityKind),
    /// A table with these keys.
    Table(&'static [Field]),
    /// An array of tables with these keys.
    Tables(&'static [Field]),
    /// A table whose keys are free, each value of this shape.
    Map(&'static Shape),
}

/// Whether a key must be there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// It must.
    Required,
    /// It may be left out and then nothing takes its place.
    Optional,
    /// It may be left out; this text then stands in its place.
    Default(&'static str),
}

/// One key of a table: reading, schema and documentation all come from here.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Key, kebab-case.
    pub key: &'static str,
    /// What it holds.
    pub shape: Shape,
    /// Whether it must be there.
    pub need: Need,
    /// One sentence.
    pub doc: &'static str,
}

/// Takes keys by name from one table.
///
/// Every getter takes a key that stands in the `fields` it was made with (anything else is a programming error),
/// returns `None` when the key is absent or wrong, and leaves a [`Diagnostic`] when it is wrong or missing though
/// required. [`Need::Default`] texts are parsed as if they had been written.
pub struct TableReader<'a> {
    source: &'a SourceFile,
    _todo: &'a (),
}

/// Parses a file and reads its root table.
///
/// `read` gets the root reader; afterwards keys that are left over are reported with the nearest known key.
///
/// # Errors
/// All mistakes at once, in order of their place; also those of TOML's own grammar.
pub fn read_file<T>(
    source: &SourceFile,
    fields: &'static [Field],
    read: impl FnOnce(&mut TableReader<'_>) -> Option<T>,
) -> Result<T, Vec<Diagnostic>> {
    let _ = (source, fields, &read);
    todo!()
}

impl<'a> TableReader<'a> {
    /// Text, or one of a [`Shape::Choice`].
    pub fn text(&mut self, key: &'static str) -> Option<String> {
        let _ = key;
        todo!()
    }
    /// List of texts.
    pub fn texts(&mut self, key: &'static str) -> Option<Vec<String>> {
        let _ = key;
        todo!()
    }
    /// Whole number ≥ `least`.
    pub fn integer(&mut self, key: &'static str, least: i64) -> Option<i64> {
        let _ = (key, least);
        todo!()
    }
    /// true or false.
    pub fn boolean(&mut self, key: &'static str) -> Option<bool> {
        let _ = key;
        todo!()
    }
    /// Quantity of the kind that the field says, in SI units.
    pub fn quantity(&mut self, key: &'static str) -> Option<f64> {
        let _ = key;
        todo!()
    }
    /// The same, and it must be > 0.
    pub fn positive(&mut self, key: &'static str) -> Option<f64> {
        let _ = key;
        todo!()
    }
    /// Non-empty list of quantities in SI units, in the order written.
    pub fn quantities(&mut self, key: &'static str) -> Option<Vec<f64>> {
        let _ = key;
        todo!()
    }
    /// Range [low, high] in SI units, low < high.
    pub fn range(&mut self, key: &'static str) -> Option<[f64; 2]> {
        let _ = key;
        todo!()
    }
    /// A limit of the kind that the field says.
    pub fn limit(&mut self, key: &'static str) -> Option<Limit> {
        let _ = key;
        todo!()
    }
    /// A table below this one.
    pub fn table<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut TableReader<'_>) -> Option<T>,
    ) -> Option<T> {
        let _ = (key, &read);
        todo!()
    }
    /// An array of tables below this one; mistakes in one do not keep the others from being read.
    pub fn tables<T>(
        &mut self,
        key: &'static str,
        read: impl FnMut(&mut TableReader<'_>) -> Option<T>,
    ) -> Option<Vec<T>> {
        let _ = (key, &read);
        todo!()
    }
    /// Entries of a [`Shape::Map`] of limits, quantities or texts, as (key, raw text) pairs with their spans.
    pub fn map(&mut self, key: &'static str) -> Option<Vec<(String, String, Range<usize>)>> {
        let _ = key;
        todo!()
    }
    /// Whether the key was written by the person.
    pub fn has(&self, key: &str) -> bool {
        let _ = key;
        todo!()
    }
    /// Where the value of this key stands (the table itself if the key is absent).
    pub fn span(&self, key: &str) -> Range<usize> {
        let _ = key;
        todo!()
    }
    /// Adds a mistake at the value of this key.
    pub fn mistake(&mut self, key: &str, message: impl Into<String>, help: Option<String>) {
        let _ = (key, message.into(), help, self.source);
        todo!()
    }
    /// Lets a kind read its own keys from this same table: `extra` fields become known here.
    pub fn extend(&mut self, extra: &'static [Field]) {
        let _ = extra;
        todo!()
    }
}
