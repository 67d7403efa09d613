//! Limits that depend on the conditions of a measurement: bands, and curves over a condition.

use std::borrow::Cow;

use super::{Judged, Where};
use crate::condition::{self, Meets};
use crate::measurement::Measurement;
use crate::quantity::{Comparator, Limit};

#[cfg(test)]
mod tests;

/// A limit that holds where all conditions are met.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Where it holds.
    pub conditions: Vec<Where>,
    /// The limit there.
    pub limit: Limit,
}

/// A limit along a condition: a curve mask.
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    /// Name of the condition, e.g. `frequency`.
    pub condition: String,
    /// Corners, ascending: value of the condition (SI, positive) and the limit there. Between corners the bounds run
    /// straight over the logarithm of the condition; outside of them nothing is judged.
    pub corners: Vec<(f64, Limit)>,
}

impl Judged {
    /// Whether anything can be held against a limit.
    pub fn is_limited(&self) -> bool {
        self.limit.is_some() || !self.bands.is_empty() || self.mask.is_some()
    }

    /// The band whose conditions a measurement meets.
    pub(crate) fn band_of(&self, measurement: &Measurement) -> Option<&Band> {
        self.bands.iter().find(|band| band.holds(measurement))
    }

    /// The limit that holds for a measurement: that of the band whose conditions it meets, else of the mask, else the
    /// one for everything. A measurement outside all of them is only reported.
    pub fn limit_of(&self, measurement: &Measurement) -> Option<Cow<'_, Limit>> {
        let band = self.band_of(measurement).map(|band| Cow::Borrowed(&band.limit));
        band.or_else(|| self.mask.as_ref()?.at(measurement).map(Cow::Owned))
            .or_else(|| self.limit.as_ref().map(Cow::Borrowed))
    }

    /// All limits as written, e.g. `<= 5 N*m; <= 4 N*m where velocity <= 2 deg/s`.
    pub fn limit_texts(&self) -> Vec<String> {
        let mut all: Vec<String> = self.limit.iter().map(|limit| limit.text.clone()).collect();
        all.extend(self.special_texts());
        all
    }

    /// Those that hold under conditions only, as written.
    pub fn special_texts(&self) -> Vec<String> {
        self.bands.iter().map(Band::text).chain(self.mask.iter().map(Mask::text)).collect()
    }
}

impl Band {
    /// Whether a measurement meets all conditions; one that lacks a condition does not.
    fn holds(&self, measurement: &Measurement) -> bool {
        let met =
            |w: &Where| measurement.conditions.iter().any(|c| c.name == w.condition && w.meets.holds(c));
        self.conditions.iter().all(met)
    }

    /// Whether some measurement could meet the conditions of both.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        let shared = |a: &Where| {
            let b = other.conditions.iter().find(|b| b.condition == a.condition);
            b.is_none_or(|b| meet(&a.meets, &b.meets))
        };
        self.conditions.iter().all(shared)
    }

    /// `<= 4 N*m where velocity <= 2 deg/s`.
    pub fn text(&self) -> String {
        let all: Vec<String> =
            self.conditions.iter().map(|w| format!("{} {}", w.condition, w.meets.text())).collect();
        format!("{} where {}", self.limit.text, all.join(", "))
    }
}

impl Mask {
    /// The limit at a measurement's condition.
    fn at(&self, measurement: &Measurement) -> Option<Limit> {
        let x = measurement.conditions.iter().find(|c| c.name == self.condition)?.requested;
        let above = self.corners.partition_point(|(corner, _)| *corner < x && !condition::same(*corner, x));
        let (to_x, to) = self.corners.get(above)?;
        if condition::same(*to_x, x) {
            return Some(to.clone());
        }
        let (from_x, from) = self.corners.get(above.checked_sub(1)?)?;
        let part = (x / from_x).ln() / (to_x / from_x).ln();
        let between = |a: Option<f64>, b: Option<f64>| Some(a? + part * (b? - a?));
        let low = between(from.low, to.low);
        let high = between(from.high, to.high);
        let text = written(to, low, high);
        Some(Limit { low, high, text, ..to.clone() })
    }

    /// `<= -15 dB at 1 Hz, <= -6 dB at 3 Hz`.
    pub fn text(&self) -> String {
        let corner = |(x, limit): &(f64, Limit)| {
            format!("{} at {}", limit.text, condition::shown(&self.condition, *x))
        };
        self.corners.iter().map(corner).collect::<Vec<_>>().join(", ")
    }
}

fn written(like: &Limit, low: Option<f64>, high: Option<f64>) -> String {
    let shown = |bound: Option<f64>| bound.map_or_else(String::new, |b| like.kind.format(b));
    match like.comparator {
        Comparator::Within => format!("{} .. {}", shown(low), shown(high)),
        Comparator::Less => format!("< {}", shown(high)),
        Comparator::AtMost => format!("<= {}", shown(high)),
        Comparator::Greater => format!("> {}", shown(low)),
        Comparator::AtLeast => format!(">= {}", shown(low)),
    }
}

/// Whether one value can meet both.
fn meet(a: &Meets, b: &Meets) -> bool {
    match (a, b) {
        (Meets::OneOf { values, .. }, Meets::OneOf { values: others, .. }) => {
            values.iter().any(|v| others.iter().any(|o| condition::same(*v, *o)))
        }
        (Meets::OneOf { values, .. }, Meets::Limit(limit))
        | (Meets::Limit(limit), Meets::OneOf { values, .. }) => values.iter().any(|v| limit.holds(*v)),
        (Meets::Limit(a), Meets::Limit(b)) => {
            let low = a.low.unwrap_or(f64::NEG_INFINITY).max(b.low.unwrap_or(f64::NEG_INFINITY));
            let high = a.high.unwrap_or(f64::INFINITY).min(b.high.unwrap_or(f64::INFINITY));
            low < high || low == high && a.holds(low) && b.holds(low)
        }
    }
}
