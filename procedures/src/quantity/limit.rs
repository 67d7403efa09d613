//! Limits: a comparator and its bounds.

use serde::{Deserialize, Serialize};

use super::QuantityKind;

/// Comparator of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum Comparator {
    Less,
    AtMost,
    Greater,
    AtLeast,
    /// Inside [low, high].
    Within,
}

/// A limit: comparator and bounds in SI units. `low` is set for Greater, AtLeast, Within; `high` for the rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// How to compare.
    pub comparator: Comparator,
    /// Lower bound.
    pub low: Option<f64>,
    /// Upper bound.
    pub high: Option<f64>,
    /// Kind of quantity of the bounds.
    pub kind: QuantityKind,
    /// As a person wrote it.
    pub text: String,
}

impl Limit {
    /// Whether a value meets the limit, without uncertainty; NaN never does.
    pub fn holds(&self, value: f64) -> bool {
        self.holds_with(value, self.low, self.high)
    }

    /// Compares a value with other bounds, e.g. those of a guard band.
    pub(crate) fn holds_with(&self, value: f64, low: Option<f64>, high: Option<f64>) -> bool {
        let strict = matches!(self.comparator, Comparator::Less | Comparator::Greater);
        let above = low.is_none_or(|low| if strict { value > low } else { value >= low });
        let below = high.is_none_or(|high| if strict { value < high } else { value <= high });
        above && below && !value.is_nan()
    }
}
