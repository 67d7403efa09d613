//! One value of a table, written by a person or standing in as a default, read as the shape of its field.

use std::borrow::Cow;
use std::ops::Range;

use toml::Spanned;
use toml::de::DeValue;

use super::file::MOST_ENTRIES;
use super::{Field, Shape};
use crate::diagnostic::nearest;
use crate::quantity::{QuantityError, QuantityKind};

/// A value with its place.
#[derive(Clone, Debug)]
pub(super) enum Given<'a> {
    /// As the file has it.
    Written(&'a Spanned<DeValue<'a>>),
    /// The default of an absent key; lists are separated by commas.
    Default(&'static str, Range<usize>),
}

/// What is asked for: a field of a table, or an entry of a map by its free key.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked<'k> {
    pub(super) key: &'k str,
    pub(super) shape: &'static Shape,
}

impl From<&'static Field> for Asked<'static> {
    fn from(field: &'static Field) -> Self {
        Self { key: field.key, shape: &field.shape }
    }
}

/// What is wrong with a value, where, and what to do.
#[derive(Debug)]
pub(super) struct Wrong {
    pub(super) span: Range<usize>,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

type Read<T> = Result<T, Wrong>;

impl<'a> Given<'a> {
    pub(super) fn span(&self) -> Range<usize> {
        match self {
            Self::Written(value) => value.span(),
            Self::Default(_, span) => span.clone(),
        }
    }

    /// A text, or a number or list that stands where a text must.
    pub(super) fn text(&self, asked: &Asked<'_>) -> Read<Cow<'a, str>> {
        match self {
            Self::Default(text, _) => Ok(Cow::Borrowed(text)),
            Self::Written(value) => match value.get_ref() {
                DeValue::String(text) => Ok(text.clone()),
                other => Err(self.mismatch(asked, other)),
            },
        }
    }

    pub(super) fn choice(&self, asked: &Asked<'_>, words: &'static [&'static str]) -> Read<&'static str> {
        let text = self.text(asked)?;
        words.iter().copied().find(|word| *word == text).ok_or_else(|| Wrong {
            span: self.span(),
            message: format!("`{}` must be {}, found `{text}`", asked.key, asked.shape.expectation()),
            help: nearest(&text, words.iter().copied()).map(|near| format!("did you mean `{near}`?")),
        })
    }

    pub(super) fn integer(&self, asked: &Asked<'_>) -> Read<i64> {
        let wrong = |message| Wrong { span: self.span(), message, help: None };
        match self {
            Self::Default(text, _) => text
                .parse()
                .map_err(|_| wrong(format!("the default of `{}`, `{text}`, is no number", asked.key))),
            Self::Written(value) => match value.get_ref() {
                DeValue::Integer(digits) => i64::from_str_radix(digits.as_str(), digits.radix())
                    .map_err(|_| wrong(format!("`{}` is too large a whole number", asked.key))),
                other => Err(self.mismatch(asked, other)),
            },
        }
    }

    /// The whole numbers of a list, each with its place.
    pub(super) fn integers(&self, asked: &Asked<'_>) -> Read<Vec<(i64, Range<usize>)>> {
        let value = match self {
            Self::Default(text, span) => {
                let items = text.split(',').filter_map(|item| item.trim().parse().ok());
                return Ok(items.map(|number| (number, span.clone())).collect());
            }
            Self::Written(value) => *value,
        };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.mismatch(asked, value.get_ref()));
        };
        if let Some(wrong) = Wrong::too_many(asked, items.len(), self.span()) {
            return Err(wrong);
        }
        items.iter().map(|item| Ok((Given::Written(item).integer(asked)?, item.span()))).collect()
    }

    pub(super) fn boolean(&self, asked: &Asked<'_>) -> Read<bool> {
        match self {
            Self::Default(text, _) => Ok(*text == "true"),
            Self::Written(value) => match value.get_ref() {
                DeValue::Boolean(yes) => Ok(*yes),
                other => Err(self.mismatch(asked, other)),
            },
        }
    }

    /// The texts of a list with their places.
    pub(super) fn texts(&self, asked: &Asked<'_>) -> Read<Vec<(String, Range<usize>)>> {
        let value = match self {
            Self::Default(text, span) => {
                let items = text.split(',').map(str::trim).filter(|item| !item.is_empty());
                return Ok(items.map(|item| (item.to_owned(), span.clone())).collect());
            }
            Self::Written(value) => *value,
        };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.mismatch(asked, value.get_ref()));
        };
        if let Some(wrong) = Wrong::too_many(asked, items.len(), self.span()) {
            return Err(wrong);
        }
        let text = |item: &'a Spanned<DeValue<'a>>| match item.get_ref() {
            DeValue::String(text) => Ok((text.clone().into_owned(), item.span())),
            other => Err(Given::Written(item).mismatch(asked, other)),
        };
        items.iter().map(text).collect()
    }

    /// Like [`Self::texts`]; a single text counts as a list of one.
    pub(super) fn text_or_texts(&self, asked: &Asked<'_>) -> Read<Vec<(String, Range<usize>)>> {
        match self {
            Self::Written(value) if value.get_ref().is_str() => {
                Ok(vec![(self.text(asked)?.into_owned(), self.span())])
            }
            _ => self.texts(asked),
        }
    }

    /// Something parsed from the text by `parse`.
    pub(super) fn parsed<T>(
        &self,
        asked: &Asked<'_>,
        parse: impl FnOnce(&str) -> Result<T, QuantityError>,
    ) -> Read<T> {
        parse(&self.text(asked)?).map_err(|error| Wrong::quantity(asked.key, &error, self.span()))
    }

    /// Non-empty list of quantities, each with its place; the first mistake of all.
    pub(super) fn quantities(
        &self,
        asked: &Asked<'_>,
        kind: QuantityKind,
    ) -> Result<Vec<(f64, Range<usize>)>, Vec<Wrong>> {
        self.each(asked, kind, |text| kind.parse(text))
    }

    /// The same, each of one of several kinds, with its kind. A mistake is that of the first kind.
    pub(super) fn quantities_of(
        &self,
        asked: &Asked<'_>,
        kinds: &[QuantityKind],
    ) -> Result<Vec<(QuantityKind, f64)>, Vec<Wrong>> {
        let usual = kinds.first().copied().unwrap_or(QuantityKind::Ratio);
        let read = |text: &str| {
            let of_any = kinds.iter().find_map(|kind| kind.parse(text).ok().map(|value| (*kind, value)));
            of_any.map_or_else(|| usual.parse(text).map(|value| (usual, value)), Ok)
        };
        let values = self.each(asked, usual, read)?;
        Ok(values.into_iter().map(|(value, _)| value).collect())
    }

    /// Each text of a list that is not empty, read by `read`; `usual` is the kind of the example.
    fn each<T>(
        &self,
        asked: &Asked<'_>,
        usual: QuantityKind,
        read: impl Fn(&str) -> Result<T, QuantityError>,
    ) -> Result<Vec<(T, Range<usize>)>, Vec<Wrong>> {
        let texts = self.texts(asked).map_err(|wrong| vec![wrong])?;
        if texts.is_empty() {
            let message = format!("`{}` is an empty list", asked.key);
            let help = Some(format!("write at least one, e.g. `[\"{}\"]`", usual.example()));
            return Err(vec![Wrong { span: self.span(), message, help }]);
        }
        let mut values = Vec::with_capacity(texts.len());
        let mut wrong = Vec::new();
        for (text, span) in texts {
            match read(&text) {
                Ok(value) => values.push((value, span)),
                Err(error) => wrong.push(Wrong::quantity(asked.key, &error, span)),
            }
        }
        if wrong.is_empty() { Ok(values) } else { Err(wrong) }
    }

    /// What stands there is of another type than its field's shape.
    pub(super) fn mismatch(&self, asked: &Asked<'_>, found: &DeValue<'_>) -> Wrong {
        let number = match found {
            DeValue::Integer(digits) => Some(digits.to_string()),
            DeValue::Float(digits) => Some(digits.to_string()),
            _ => None,
        };
        let help = match (asked.shape, number) {
            (
                Shape::Quantity(kind) | Shape::Quantities(kind) | Shape::QuantitiesOf([kind, ..]),
                Some(number),
            ) => {
                let example = format!("{number} {}", kind.display_unit());
                Some(format!("write a quantity in quotes with its unit, e.g. `\"{}\"`", example.trim()))
            }
            (Shape::Texts | Shape::Quantities(_) | Shape::QuantitiesOf(_), None) if found.is_str() => {
                Some("put it in brackets: `[\"…\"]`".to_owned())
            }
            (Shape::Tables(_), _) if found.is_table() => Some(format!("write `[[{}]]`", asked.key)),
            _ => None,
        };
        let message =
            format!("`{}` must be {}, found {}", asked.key, asked.shape.expectation(), described(found));
        Wrong { span: self.span(), message, help }
    }
}

impl Wrong {
    /// A list or table with more entries than any test has.
    pub(super) fn too_many(asked: &Asked<'_>, count: usize, span: Range<usize>) -> Option<Self> {
        (count > MOST_ENTRIES).then(|| Self {
            span,
            message: format!("`{}` has {count} entries; expected at most {MOST_ENTRIES}", asked.key),
            help: Some("remove some, or use several files".to_owned()),
        })
    }

    pub(super) fn quantity(key: &str, error: &QuantityError, span: Range<usize>) -> Self {
        Self { span, message: format!("`{key}`: {error}"), help: error.help() }
    }
}

/// A value in words.
fn described(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) if text.chars().count() <= 40 => format!("the text `{text}`"),
        DeValue::String(_) => "a text".to_owned(),
        DeValue::Integer(digits) => format!("the number {digits}"),
        DeValue::Float(digits) => format!("the number {digits}"),
        DeValue::Boolean(yes) => format!("`{yes}`"),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
