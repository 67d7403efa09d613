//! Text to numbers: `10 deg/s`, `-10 .. 90 deg`, `<= 45 N*m`.

use super::unit::{self, Unit};
use super::{Comparator, Limit, QuantityKind};
use crate::diagnostic::nearest;

/// Why a text is not the quantity that was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum QuantityError {
    /// There is no number at its start.
    #[error("expected {} such as `{}`, found `{found}`", .expected.noun(), .expected.example())]
    NotANumber {
        /// What should stand there.
        expected: QuantityKind,
        /// What stands there.
        found: String,
    },
    /// A number with a comma where a point must stand.
    #[error("`{found}` has a decimal comma")]
    DecimalComma {
        /// What stands there.
        found: String,
        /// The same with a point.
        meant: String,
    },
    /// A number without unit where the kind has one.
    #[error("expected {} such as `{}`, found `{found}` without a unit", .expected.noun(), .expected.example())]
    NoUnit {
        /// What should stand there.
        expected: QuantityKind,
        /// What stands there.
        found: String,
    },
    /// A unit that nobody knows.
    #[error("unknown unit `{unit}`: expected {} such as `{}`", .expected.noun(), .expected.example())]
    UnknownUnit {
        /// What should stand there.
        expected: QuantityKind,
        /// The unit as written.
        unit: String,
    },
    /// A unit of another kind.
    #[error("expected {} such as `{}`, found `{found}`, {}", .expected.noun(), .expected.example(), .is.noun())]
    OtherKind {
        /// What should stand there.
        expected: QuantityKind,
        /// What stands there.
        found: String,
        /// The kind of what stands there.
        is: QuantityKind,
    },
    /// A number beyond what a double holds.
    #[error("`{found}` is too large a number")]
    TooLarge {
        /// What stands there.
        found: String,
    },
    /// No `..` where a range must stand.
    #[error("expected a range such as `{}`, found `{found}`", .expected.range_example())]
    NotARange {
        /// Kind of both ends.
        expected: QuantityKind,
        /// What stands there.
        found: String,
    },
    /// A range with its ends the wrong way round, or of no width.
    #[error("the range `{found}` is empty: write the lower end first; it must be below the upper end")]
    EmptyRange {
        /// What stands there.
        found: String,
    },
    /// Neither comparator nor range where a limit must stand.
    #[error("expected a limit such as `<= {}` or `{}`, found `{found}`", .expected.example(), .expected.range_example())]
    NotALimit {
        /// Kind of the bounds.
        expected: QuantityKind,
        /// What stands there.
        found: String,
    },
}

impl QuantityError {
    /// What to do about it, where that can be told.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::NoUnit { expected, found } => {
                let unit = expected.display_unit();
                Some(format!("write the unit: `{found} {unit}`"))
            }
            Self::UnknownUnit { expected, unit } => {
                let symbols = unit::of_kind(*expected).map(|u| u.symbol);
                nearest(&unit::normalise(unit), symbols).map(|n| format!("did you mean `{n}`?"))
            }
            Self::NotANumber { found, .. } if found.starts_with('.') => Some(format!("write `0{found}`")),
            Self::DecimalComma { meant, .. } => Some(format!("write a point: `{meant}`")),
            Self::NotARange { found, .. } => Some(match ends_of(found) {
                Some((low, high)) => format!("write two points between the ends: `{low} .. {high}`"),
                None => "write both ends with two points between them: `low .. high`".to_owned(),
            }),
            Self::NotALimit { found, .. } if ends_of(found).is_some() => {
                let (low, high) = ends_of(found).unwrap_or_default();
                Some(format!("write two points between the ends: `{low} .. {high}`"))
            }
            Self::EmptyRange { .. } => Some("write `low .. high`".to_owned()),
            Self::NotALimit { .. } => {
                Some("comparators are `<`, `<=`, `>`, `>=` and `low .. high`".to_owned())
            }
            _ => None,
        }
    }
}

/// What people write between the ends of a range elsewhere.
const BETWEEN: [&str; 7] = [" to ", "…", "–", "—", " until ", "~", " - "];

/// Ends of what was meant to be a range.
fn ends_of(text: &str) -> Option<(&str, &str)> {
    let (low, high) = BETWEEN.iter().find_map(|between| text.split_once(between))?;
    Some((low.trim(), high.trim())).filter(|(low, high)| !low.is_empty() && !high.is_empty())
}

pub(super) fn quantity(kind: QuantityKind, text: &str) -> Result<f64, QuantityError> {
    let (number, unit) = split(kind, text)?;
    let unit = resolve(kind, text, unit)?;
    scaled(number, unit, text)
}

pub(super) fn range(kind: QuantityKind, text: &str) -> Result<[f64; 2], QuantityError> {
    let Some((low, high)) = text.split_once("..") else {
        return Err(QuantityError::NotARange { expected: kind, found: shown(text) });
    };
    let (high_number, high_unit) = split(kind, high)?;
    let high_unit = resolve(kind, high, high_unit)?;
    let (low_number, low_unit) = split(kind, low)?;
    // `-10 .. 90 deg`: the unit of the upper end counts for both.
    let low_unit = if low_unit.is_empty() { high_unit } else { resolve(kind, low, low_unit)? };
    let ends = [scaled(low_number, low_unit, low)?, scaled(high_number, high_unit, high)?];
    if ends[0] < ends[1] { Ok(ends) } else { Err(QuantityError::EmptyRange { found: shown(text) }) }
}

pub(super) fn limit(kind: QuantityKind, text: &str) -> Result<Limit, QuantityError> {
    const COMPARATORS: [(&str, Comparator); 6] = [
        ("<=", Comparator::AtMost),
        ("≤", Comparator::AtMost),
        (">=", Comparator::AtLeast),
        ("≥", Comparator::AtLeast),
        ("<", Comparator::Less),
        (">", Comparator::Greater),
    ];
    let limit = |comparator, low, high| Limit { comparator, low, high, kind, text: text.trim().to_owned() };
    for (sign, comparator) in COMPARATORS {
        let Some(bound) = text.trim_start().strip_prefix(sign) else { continue };
        let bound = quantity(kind, bound)?;
        return Ok(match comparator {
            Comparator::Less | Comparator::AtMost => limit(comparator, None, Some(bound)),
            _ => limit(comparator, Some(bound), None),
        });
    }
    if !text.contains("..") {
        return Err(QuantityError::NotALimit { expected: kind, found: shown(text) });
    }
    let [low, high] = range(kind, text)?;
    Ok(limit(Comparator::Within, Some(low), Some(high)))
}

/// The number at the start and what follows it, trimmed.
fn split(kind: QuantityKind, text: &str) -> Result<(f64, &str), QuantityError> {
    let text = text.trim();
    let found = || shown(text);
    let digits = number_length(text);
    let (number, unit) = text.split_at(digits);
    if unit.strip_prefix(',').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit())) {
        return Err(QuantityError::DecimalComma { found: found(), meant: found().replacen(',', ".", 1) });
    }
    // Typographic minus is what people paste from documents.
    let number: f64 = number
        .replace('\u{2212}', "-")
        .parse()
        .map_err(|_| QuantityError::NotANumber { expected: kind, found: found() })?;
    if number.is_finite() {
        Ok((number, unit.trim()))
    } else {
        Err(QuantityError::TooLarge { found: found() })
    }
}

/// Bytes of `[sign] digits [. digits] [e [sign] digits]` at the start of `text`; 0 if there is no number.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| text[from..].bytes().take_while(u8::is_ascii_digit).count();
    let sign = |from: usize| {
        let next = text[from..].chars().next();
        next.filter(|c| matches!(c, '+' | '-' | '\u{2212}')).map_or(0, char::len_utf8)
    };
    let whole_from = sign(0);
    let whole = digits(whole_from);
    if whole == 0 {
        return 0;
    }
    let mut end = whole_from + whole;
    if text[end..].starts_with('.') && digits(end + 1) > 0 {
        end += 1 + digits(end + 1);
    }
    if text[end..].starts_with(['e', 'E']) {
        let exponent = end + 1 + sign(end + 1);
        if digits(exponent) > 0 {
            end = exponent + digits(exponent);
        }
    }
    end
}

fn resolve(kind: QuantityKind, text: &str, unit: &str) -> Result<&'static Unit, QuantityError> {
    let symbol = unit::normalise(unit);
    match unit::find(&symbol, kind) {
        Some(unit) if unit.kind == kind => Ok(unit),
        Some(_) if symbol.is_empty() => Err(QuantityError::NoUnit { expected: kind, found: shown(text) }),
        Some(unit) => Err(QuantityError::OtherKind { expected: kind, found: shown(text), is: unit.kind }),
        None => Err(QuantityError::UnknownUnit { expected: kind, unit: shown(unit) }),
    }
}

fn scaled(number: f64, unit: &Unit, text: &str) -> Result<f64, QuantityError> {
    let si = number * unit.factor;
    if si.is_finite() { Ok(si) } else { Err(QuantityError::TooLarge { found: shown(text) }) }
}

/// What a person wrote, short enough for a message.
fn shown(text: &str) -> String {
    const MOST: usize = 60;
    let text = text.trim();
    match text.char_indices().nth(MOST) {
        Some((cut, _)) => format!("{}…", &text[..cut]),
        None => text.to_owned(),
    }
}
