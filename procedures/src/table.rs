//! Reads people's TOML by key, collects all mistakes with their places, reports keys that nobody asked for.

use crate::diagnostic::{Diagnostic, SourceFile};
use crate::quantity::QuantityKind;

mod file;
mod reader;
mod value;

#[cfg(test)]
mod tests;

pub use file::{MOST_BYTES, MOST_ENTRIES, MOST_MISTAKES, MOST_STEPS, SIZE_HELP, read_file, size_message};
pub use reader::{MapEntry, TableReader};

/// What a key holds.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Any text.
    Text,
    /// A list of texts.
    Texts,
    /// A whole number.
    Integer,
    /// A list of whole numbers.
    Integers,
    /// true or false.
    Boolean,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A quoted quantity, `"10 deg/s"`.
    Quantity(QuantityKind),
    /// A list of quoted quantities.
    Quantities(QuantityKind),
    /// A list of quoted quantities, each of one of these kinds; the first is the usual one.
    QuantitiesOf(&'static [QuantityKind]),
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
    /// The key must be there.
    Required,
    /// The key may be left out and then nothing takes its place.
    Optional,
    /// The key may be left out; this text then stands in its place.
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

/// The version of our file formats that this program reads; every file starts with `schema = 1`.
pub const SCHEMA: i64 = 1;

/// The field `schema` that every file has; read it with [`TableReader::schema`].
pub const SCHEMA_FIELD: Field = Field {
    key: "schema",
    shape: Shape::Integer,
    need: Need::Required,
    doc: "Version of the file format: 1.",
};

impl Field {
    /// A key that must be there.
    pub const fn required(key: &'static str, shape: Shape, doc: &'static str) -> Self {
        Self { key, shape, need: Need::Required, doc }
    }

    /// A key that may be left out.
    pub const fn optional(key: &'static str, shape: Shape, doc: &'static str) -> Self {
        Self { key, shape, need: Need::Optional, doc }
    }

    /// A key that reads as `text` if it is left out.
    pub const fn default(key: &'static str, shape: Shape, text: &'static str, doc: &'static str) -> Self {
        Self { key, shape, need: Need::Default(text), doc }
    }
}

impl Shape {
    /// What should stand there, in words, with an example.
    pub fn expectation(&self) -> String {
        match self {
            Self::Text => "text in quotes".to_owned(),
            Self::Texts => "a list of texts such as `[\"…\", \"…\"]`".to_owned(),
            Self::Integer => "a whole number".to_owned(),
            Self::Integers => "a list of whole numbers such as `[5, 10]`".to_owned(),
            Self::Boolean => "`true` or `false`".to_owned(),
            Self::Choice(words) => format!("one of {}", quoted(words.iter().copied())),
            Self::Quantity(kind) => format!("{} such as `\"{}\"`", kind.noun(), kind.example()),
            Self::Quantities(kind) => format!("a list such as `[\"{}\"]`", kind.example()),
            Self::QuantitiesOf(kinds) => {
                let lists = kinds.iter().map(|kind| format!("`[\"{}\"]`", kind.example()));
                format!("a list such as {}", lists.collect::<Vec<_>>().join(" or "))
            }
            Self::Range(kind) => format!("a range such as `\"{}\"`", kind.range_example()),
            Self::Limit(kind) => format!("a limit such as `\"<= {}\"`", kind.example()),
            Self::Table(_) | Self::Map(_) => "a table".to_owned(),
            Self::Tables(_) => "an array of tables".to_owned(),
        }
    }
}

/// Words as `a`, `b`, `c`, for messages.
pub fn quoted<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    words.into_iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

/// `did you mean …?` if a known word is near, otherwise the list of known words.
pub fn suggestion<'a>(word: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
    match crate::diagnostic::nearest(word, known.clone()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if known.clone().into_iter().next().is_none() => "there is none".to_owned(),
        None => format!("known: {}", quoted(known)),
    }
}

/// Name of a value in a table of names such as [`TableReader::named_values`] reads; empty for a value that has none.
pub(crate) fn name_of<T: PartialEq>(known: &[(&'static str, T)], value: &T) -> &'static str {
    known.iter().find(|(_, each)| each == value).map_or("", |(name, _)| name)
}

/// Value of a name in such a table.
pub(crate) fn value_of<T: Copy>(known: &[(&'static str, T)], name: &str) -> Option<T> {
    known.iter().find(|(each, _)| *each == name).map(|(_, value)| *value)
}

/// The order in which mistakes are reported: by place, those without one first.
pub(crate) fn sort_by_place(mistakes: &mut Vec<Diagnostic>) {
    mistakes.sort_by_key(|m| m.span.as_ref().map(|s| (s.start, s.end)));
    mistakes.dedup();
}

/// A mistake at a place of a file.
pub(crate) fn mistake_in(
    source: &SourceFile,
    span: std::ops::Range<usize>,
    message: impl Into<String>,
    help: Option<String>,
) -> Diagnostic {
    let mistake = Diagnostic::new(message).at(source, span);
    Diagnostic { help, ..mistake }
}
