//! Keys by name, from one table.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::file::MOST_STEPS;
use super::value::{Asked, Given, Wrong};
use super::{Field, SCHEMA, Shape, suggestion, value_of};
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::quantity::{Limit, QuantityKind};

mod keys;

/// Takes keys by name from one table.
///
/// Every getter takes a key that stands in the `fields` it was made with (anything else is a programming error and
/// panics), returns `None` when the key is absent or wrong, and leaves a [`Diagnostic`] when it is wrong or missing
/// though required. [`Need::Default`](super::Need::Default) texts are parsed as if they had been written; lists in them
/// are separated by commas, and an absent table with any default reads as an empty one.
#[derive(Debug)]
pub struct TableReader<'a> {
    source: &'a SourceFile,
    /// `None` where an absent table has a default: an empty one.
    entries: Option<&'a DeTable<'a>>,
    place: Range<usize>,
    fields: Vec<&'static Field>,
    found: Vec<Found>,
    /// How many more mistakes may be kept, and how many were found beyond that.
    room: usize,
    untold: usize,
    any_key: bool,
}

/// A mistake, and whether it is a key that is not there.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) mistake: Diagnostic,
    pub(super) missing: bool,
}

/// An entry of a [`Shape::Map`] whose values are texts or lists of texts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapEntry {
    /// The free key.
    pub key: String,
    /// Where the key stands.
    pub key_span: Range<usize>,
    /// Text of the value, or all texts of its list, each with its place.
    pub texts: Vec<(String, Range<usize>)>,
}

impl<'a> TableReader<'a> {
    pub(super) fn new(
        source: &'a SourceFile,
        entries: Option<&'a DeTable<'a>>,
        place: Range<usize>,
        fields: &'static [Field],
        room: usize,
    ) -> Self {
        let fields = fields.iter().collect();
        Self { source, entries, place, fields, found: Vec::new(), room, untold: 0, any_key: false }
    }

    /// Text, or one of a [`Shape::Choice`].
    pub fn text(&mut self, key: &'static str) -> Option<String> {
        let (asked, given) = self.take(key)?;
        let read = match asked.shape {
            Shape::Text => given.text(&asked).map(|text| text.into_owned()),
            Shape::Choice(words) => given.choice(&asked, words).map(str::to_owned),
            _ => misuse(key, "text"),
        };
        self.keep(read)
    }

    /// List of texts.
    pub fn texts(&mut self, key: &'static str) -> Option<Vec<String>> {
        Some(self.spanned_texts(key)?.into_iter().map(|(text, _)| text).collect())
    }

    /// List of texts, each with its place, for mistakes about one of them.
    pub fn spanned_texts(&mut self, key: &'static str) -> Option<Vec<(String, Range<usize>)>> {
        let (asked, given) = self.take(key)?;
        let read = match asked.shape {
            Shape::Texts => given.texts(&asked),
            _ => misuse(key, "texts"),
        };
        self.keep(read)
    }

    /// Values that a list of texts names. A text that is not `known` is a mistake: an unknown `what`.
    pub fn named_values<T: Copy>(
        &mut self,
        key: &'static str,
        what: &str,
        known: &[(&'static str, T)],
    ) -> Option<Vec<T>> {
        let mut values = Vec::new();
        for (text, span) in self.spanned_texts(key)? {
            match value_of(known, &text) {
                Some(value) => values.push(value),
                None => {
                    let help = suggestion(&text, known.iter().map(|(name, _)| *name));
                    self.mistake_at(span, format!("unknown {what} `{text}`"), Some(help));
                }
            }
        }
        Some(values)
    }

    /// Whole number ≥ `least`.
    pub fn integer(&mut self, key: &'static str, least: i64) -> Option<i64> {
        let (asked, given) = self.take(key)?;
        let read = match asked.shape {
            Shape::Integer => given.integer(&asked),
            _ => misuse(key, "integer"),
        };
        let value = self.keep(read)?;
        if value < least {
            self.mistake(key, format!("`{key}` must be at least {least}, found {value}"), None);
            return None;
        }
        Some(value)
    }

    /// List of whole numbers, each with its place, for mistakes about one of them.
    pub fn integers(&mut self, key: &'static str) -> Option<Vec<(i64, Range<usize>)>> {
        let (asked, given) = self.take(key)?;
        let read = match asked.shape {
            Shape::Integers => given.integers(&asked),
            _ => misuse(key, "integers"),
        };
        self.keep(read)
    }

    /// Whole number from `least` to 10 000: more cycles, points or repeats than any test has.
    pub fn count(&mut self, key: &'static str, least: i64) -> Option<u32> {
        const MOST: u32 = 10_000;
        let number = self.integer(key, least)?;
        let fitting = u32::try_from(number).ok().filter(|n| *n <= MOST);
        if fitting.is_none() {
            self.mistake(key, format!("`{key}`: {number} is too many"), Some(format!("at most {MOST}")));
        }
        fitting
    }

    /// Refuses lists and counts whose product is more than [`super::MOST_STEPS`], before anything is made of them; `key`
    /// is the one that the mistake points at.
    pub fn check_steps(&mut self, key: &str, factors: &[usize]) {
        let steps = factors.iter().fold(1_usize, |product, &factor| product.saturating_mul(factor));
        if steps > MOST_STEPS {
            let message = format!("this procedure would have {steps} steps; expected at most {MOST_STEPS}");
            let help = "use fewer values or repeats, or split it into several procedures";
            self.mistake(key, message, Some(help.to_owned()));
        }
    }

    /// true or false.
    pub fn boolean(&mut self, key: &'static str) -> Option<bool> {
        let (asked, given) = self.take(key)?;
        let read = match asked.shape {
            Shape::Boolean => given.boolean(&asked),
            _ => misuse(key, "boolean"),
        };
        self.keep(read)
    }

    /// Quantity of the kind that the field says, in SI units.
    pub fn quantity(&mut self, key: &'static str) -> Option<f64> {
        let (asked, given) = self.take(key)?;
        let read = match asked.shape {
            Shape::Quantity(kind) => given.parsed(&asked, |text| kind.parse(text)),
            _ => misuse(key, "quantity"),
        };
        self.keep(read)
    }

    /// A quantity that must be > 0.
    pub fn positive(&mut self, key: &'static str) -> Option<f64> {
        let value = self.quantity(key)?;
        if value > 0.0 {
            return Some(value);
        }
        self.mistake(key, format!("`{key}` must be above zero"), None);
        None
    }

    /// Non-empty list of quantities in SI units, in the order written.
    pub fn quantities(&mut self, key: &'static str) -> Option<Vec<f64>> {
        Some(self.spanned_quantities(key)?.into_iter().map(|(value, _)| value).collect())
    }

    /// Quantities, each with its place, for mistakes about one of them.
    pub fn spanned_quantities(&mut self, key: &'static str) -> Option<Vec<(f64, Range<usize>)>> {
        let (asked, given) = self.take(key)?;
        let read = match asked.shape {
            Shape::Quantities(kind) => given.quantities(&asked, *kind),
            _ => misuse(key, "quantities"),
        };
        self.keep_all(read)
    }

    /// Non-empty list of quantities of any of the kinds that the field says: kind and SI value, in the order written.
    pub fn quantities_of(&mut self, key: &'static str) -> Option<Vec<(QuantityKind, f64)>> {
        let (asked, given) = self.take(key)?;
        let read = match asked.shape {
            Shape::QuantitiesOf(kinds) => given.quantities_of(&asked, kinds),
            _ => misuse(key, "quantities"),
        };
        self.keep_all(read)
    }

    /// A list as read; else all that is wrong in it becomes mistakes.
    fn keep_all<T>(&mut self, read: Result<Vec<T>, Vec<Wrong>>) -> Option<Vec<T>> {
        match read {
            Ok(values) => Some(values),
            Err(all) => {
                for wrong in all {
                    self.wrong(wrong);
                }
                None
            }
        }
    }

    /// Range [low, high] in SI units, low < high.
    pub fn range(&mut self, key: &'static str) -> Option<[f64; 2]> {
        let (asked, given) = self.take(key)?;
        let read = match asked.shape {
            Shape::Range(kind) => given.parsed(&asked, |text| kind.parse_range(text)),
            _ => misuse(key, "range"),
        };
        self.keep(read)
    }

    /// A limit of the kind that the field says.
    pub fn limit(&mut self, key: &'static str) -> Option<Limit> {
        let (asked, given) = self.take(key)?;
        let read = match asked.shape {
            Shape::Limit(kind) => given.parsed(&asked, |text| kind.parse_limit(text)),
            _ => misuse(key, "limit"),
        };
        self.keep(read)
    }

    /// A table below this one.
    pub fn table<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut TableReader<'_>) -> Option<T>,
    ) -> Option<T> {
        let (asked, given) = self.take(key)?;
        let Shape::Table(fields) = asked.shape else { misuse(key, "table") };
        let entries = match &given {
            Given::Default(..) => None,
            Given::Written(value) => match value.get_ref() {
                DeValue::Table(entries) => Some(entries),
                other => return self.keep(Err(given.mismatch(&asked, other))),
            },
        };
        self.below(entries, given.span(), fields, read)
    }

    /// An array of tables below this one; mistakes in one do not keep the others from being read.
    pub fn tables<T>(
        &mut self,
        key: &'static str,
        mut read: impl FnMut(&mut TableReader<'_>) -> Option<T>,
    ) -> Option<Vec<T>> {
        let (asked, given) = self.take(key)?;
        let Shape::Tables(fields) = asked.shape else { misuse(key, "tables") };
        let Given::Written(value) = given else { return Some(Vec::new()) };
        let DeValue::Array(items) = value.get_ref() else {
            return self.keep(Err(given.mismatch(&asked, value.get_ref())));
        };
        if let Some(wrong) = Wrong::too_many(&asked, items.len(), given.span()) {
            return self.keep(Err(wrong));
        }
        let mut all = Vec::with_capacity(items.len());
        for item in items {
            match item.get_ref() {
                DeValue::Table(entries) => {
                    all.extend(self.below(Some(entries), item.span(), fields, &mut read))
                }
                other => self.wrong(Given::Written(item).mismatch(&asked, other)),
            }
        }
        Some(all)
    }

    /// Tables of a [`Shape::Map`], each with its name, in the order written; mistakes in one do not keep the others from being
    /// read. `read` gets the name and where it stands.
    pub fn named_tables<T>(
        &mut self,
        key: &'static str,
        mut read: impl FnMut(&mut TableReader<'_>, &str, Range<usize>) -> Option<T>,
    ) -> Option<Vec<T>> {
        let (asked, given) = self.take(key)?;
        let Shape::Map(inner @ Shape::Table(fields)) = asked.shape else { misuse(key, "named tables") };
        let Given::Written(value) = given else { return Some(Vec::new()) };
        let DeValue::Table(entries) = value.get_ref() else {
            return self.keep(Err(given.mismatch(&asked, value.get_ref())));
        };
        if let Some(wrong) = Wrong::too_many(&asked, entries.len(), given.span()) {
            return self.keep(Err(wrong));
        }
        let mut written: Vec<_> = entries.iter().collect();
        written.sort_by_key(|(name, _)| name.span().start);
        let mut all = Vec::with_capacity(written.len());
        for (name, value) in written {
            let asked = Asked { key: name.get_ref(), shape: inner };
            match value.get_ref() {
                DeValue::Table(entries) => {
                    let read = |t: &mut TableReader<'_>| read(t, name.get_ref(), name.span());
                    all.extend(self.below(Some(entries), value.span(), fields, read));
                }
                other => self.wrong(Given::Written(value).mismatch(&asked, other)),
            }
        }
        Some(all)
    }

    /// Entries of a [`Shape::Map`] of limits, quantities or texts, as (key, raw text) pairs with their spans, in the
    /// order written.
    pub fn map(&mut self, key: &'static str) -> Option<Vec<(String, String, Range<usize>)>> {
        let entries =
            self.map_with(key, |given, asked| Ok(vec![(given.text(asked)?.into_owned(), given.span())]))?;
        let only = |entry: MapEntry| {
            entry.texts.into_iter().map(move |(text, span)| (entry.key.clone(), text, span))
        };
        Some(entries.into_iter().flat_map(only).collect())
    }

    /// Entries of a [`Shape::Map`] whose values are a text or a list of texts, in the order written.
    pub fn lists(&mut self, key: &'static str) -> Option<Vec<MapEntry>> {
        self.map_with(key, |given, asked| given.text_or_texts(asked))
    }

    /// The key `schema`, which must be [`SCHEMA`]; an older or newer file is refused.
    pub fn schema(&mut self) -> Option<()> {
        let version = self.integer("schema", 0)?;
        if version == SCHEMA {
            return Some(());
        }
        let message = format!("the file has schema {version}, but this program reads schema {SCHEMA}");
        self.mistake("schema", message, None);
        None
    }

    /// Whether the key was written by the person.
    pub fn has(&self, key: &str) -> bool {
        self.value(key).is_some()
    }

    /// Where the value of this key stands (the table itself if the key is absent).
    pub fn span(&self, key: &str) -> Range<usize> {
        self.value(key).map_or_else(|| self.place.clone(), Spanned::span)
    }

    /// Where the table stands (its header), e.g. for mistakes about it that appear later.
    pub fn place(&self) -> Range<usize> {
        self.place.clone()
    }

    /// How many mistakes were found in this table and below it so far.
    pub fn mistakes(&self) -> usize {
        self.found.len() + self.untold
    }

    /// The file that is read.
    pub fn source(&self) -> &SourceFile {
        self.source
    }

    /// Adds a mistake at the value of this key.
    pub fn mistake(&mut self, key: &str, message: impl Into<String>, help: Option<String>) {
        self.mistake_at(self.span(key), message, help);
    }

    /// Adds a mistake at a place of the file.
    pub fn mistake_at(&mut self, span: Range<usize>, message: impl Into<String>, help: Option<String>) {
        self.wrong(Wrong { span, message: message.into(), help });
    }

    /// Lets a kind read its own keys from this same table: `extra` fields become known here.
    pub fn extend(&mut self, extra: &'static [Field]) {
        self.fields.extend(extra);
    }

    /// Keys that nobody knows are no mistake in this table: used where it cannot be told which keys belong to it.
    pub fn accept_any_key(&mut self) {
        self.any_key = true;
    }
}

/// A getter and a field that do not fit each other: a mistake in this program, not in a file.
fn misuse(key: &str, getter: &str) -> ! {
    panic!("`{key}` is not among the fields of this table, or is not of the shape that `{getter}` reads")
}
