//! What two runs found of the same quantities, and which of them differ beyond their uncertainties.
//!
//! Pure: from findings to a comparison. Two values are compared by their difference over its standard uncertainty, the root of
//! the sum of both squared (JCGM 100:2008, 5.1.2), with the degrees of freedom by Welch–Satterthwaite (G.4) and the two-sided
//! tail of Student's t. A run has hundreds of quantities, of which one in twenty would differ by more than its U by chance. So
//! the tails of all values and curves of a comparison are adjusted together (S. Holm, Scand. J. Statist. 6, 65, 1979): the
//! probability that any quantity is said to differ, though none does, is at most [`LEVEL`].
//!
//! Uncertainties that both runs share, such as that of one calibrated instrument, count twice: the comparison then finds less,
//! never more.

use analysis::family_wise::holm;
use serde::Serialize;

use crate::measurement::{Condition, Measurement};
use crate::quantity::QuantityKind;
use crate::trace::Plot;

mod curves;
mod pairing;
mod published;
#[cfg(test)]
mod tests;
mod values;

pub use curves::{Band, CurvePair, WorstPoint};
pub use published::{FIELDS as PUBLISHED_FIELDS, PublishedTable, PublishedValue};

/// Probability that a comparison of two equal units finds any difference.
pub const LEVEL: f64 = 0.05;

/// What a procedure of a run found.
#[derive(Clone, Copy, Debug)]
pub struct Found<'a> {
    /// Id of the procedure.
    pub procedure: &'a str,
    /// Its measurements.
    pub measurements: &'a [Measurement],
    /// Its pictures.
    pub plots: &'a [Plot],
}

/// What a comparison says of a quantity or a curve. Order is from what matters most to what matters least.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Call {
    /// The difference is beyond its uncertainty, also among so many others.
    Differs,
    /// The difference is beyond its U, as one in twenty is by chance; not beyond what chance makes of so many.
    Near,
    /// Only the first run has a value.
    OnlyInA,
    /// Only the second run has a value.
    OnlyInB,
    /// No difference beyond the uncertainty or the tolerance.
    Same,
    /// The same numbers, bit for bit.
    Identical,
    /// A curve without uncertainty, and nobody said which tolerance it has: shown, not judged.
    NotJudged,
}

/// A value of one run, SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Value {
    /// The value.
    pub value: f64,
    /// Standard uncertainty.
    pub u: f64,
    /// Degrees of freedom; `None`: infinite.
    pub dof: Option<f64>,
}

/// The second value less the first one, SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Second value less first value.
    pub value: f64,
    /// Standard uncertainty of the difference.
    pub u: f64,
    /// Its degrees of freedom; `None`: infinite.
    pub dof: Option<f64>,
    /// Coverage factor k = t(0.97725, ν).
    pub k: f64,
    /// Expanded uncertainty U = k·u.
    pub expanded_u: f64,
    /// Size of the difference over u; `None` where neither value has an uncertainty.
    pub apart_u: Option<f64>,
    /// Probability of such a difference by chance.
    pub p: f64,
    /// The same among all that is compared (Holm).
    pub p_family: f64,
}

/// What was measured, and where.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// Id of the procedure.
    pub procedure: String,
    /// Name of the measurand.
    pub measurand: String,
    /// Axis.
    pub axis: String,
    /// Point; `None` where it rests on several.
    pub point: Option<String>,
    /// Conditions, as the first run that has a value asked for and reached them.
    pub conditions: Vec<Condition>,
    /// Kind of quantity of value and u.
    pub kind: QuantityKind,
}

/// A quantity with what each run says of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValuePair {
    /// The quantity.
    pub quantity: Quantity,
    /// Value of the first run; `None` where it has none that counts.
    pub a: Option<Value>,
    /// Value of the second run; `None` where it has none that counts.
    pub b: Option<Value>,
    /// Second less first; `None` where one is missing.
    pub difference: Option<Difference>,
    /// What the comparison says.
    pub call: Call,
    /// Why a run has no value, where it was asked for one.
    pub reason: Option<String>,
}

/// What two runs found of the same quantities.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// Quantities of which at least one run has a value, in the order of the first run, then of the second one.
    pub values: Vec<ValuePair>,
    /// Curves of both runs, in the same order.
    pub curves: Vec<CurvePair>,
    /// Quantities that both runs looked for and neither has a value of.
    pub without_value: usize,
    /// Curves that only one of the runs has.
    pub curves_alone: usize,
}

/// Compares what two runs found.
///
/// `tolerance` is a share of the larger value, or of the height of a curve, below which a difference is of no interest; `None`
/// for none. Curves without an uncertainty are judged only where there is one.
pub fn compare(a: &[Found<'_>], b: &[Found<'_>], tolerance: Option<f64>) -> Comparison {
    let mut comparison = Comparison::default();
    for pair in pairing::procedures(a, b) {
        values::add(&mut comparison, &pair, tolerance);
        curves::add(&mut comparison, &pair, tolerance);
    }
    call(&mut comparison);
    comparison
}

/// Compares what a run found with published values. A value of the run that the table does not have is left out.
pub fn compare_with_published(
    run: &[Found<'_>],
    table: &PublishedTable,
    tolerance: Option<f64>,
) -> Comparison {
    let mut comparison = Comparison::default();
    for published in &table.values {
        let before = comparison.values.len();
        for found in run.iter().filter(|found| published.is_from(found.procedure)) {
            for own in found.measurements.iter().filter(|m| published.is_of(m)) {
                values::add_published(&mut comparison, found.procedure, own, published, tolerance);
            }
        }
        if comparison.values.len() == before {
            comparison.values.push(published.alone());
        }
    }
    call(&mut comparison);
    comparison
}

impl Comparison {
    /// Pairs of values, those that are in one run alone left out.
    pub fn pairs(&self) -> usize {
        self.values.iter().filter(|pair| pair.difference.is_some()).count()
    }

    /// Values and curves of which this is said.
    pub fn count(&self, call: Call) -> usize {
        let values = self.values.iter().filter(|pair| pair.call == call).count();
        values + self.curves.iter().filter(|pair| pair.call == call).count()
    }

    /// Whether every number of both is the same, bit for bit, and none is missing in one of them.
    pub fn is_identical(&self) -> bool {
        let values = self.values.iter().all(|pair| pair.call == Call::Identical);
        values && self.curves.iter().all(|pair| pair.call == Call::Identical) && self.curves_alone == 0
    }

    /// Whether a value or a curve differs beyond its uncertainty.
    pub fn differs(&self) -> bool {
        self.count(Call::Differs) > 0
    }
}

/// Calls every value and curve that has a tail by all of them together.
fn call(comparison: &mut Comparison) {
    let of_value = |pair: &ValuePair| pair.difference.filter(|_| pair.call == Call::Near).map(|d| d.p);
    let of_curve = |pair: &CurvePair| pair.p.filter(|_| pair.call == Call::Near);
    let judged = |pair: &&ValuePair| pair.difference.is_some();
    let tails: Vec<f64> = comparison
        .values
        .iter()
        .filter(judged)
        .map(|pair| of_value(pair).unwrap_or(1.0))
        .chain(comparison.curves.iter().map(|pair| of_curve(pair).unwrap_or(1.0)))
        .collect();
    let mut adjusted = holm(&tails).into_iter();
    for pair in &mut comparison.values {
        let Some(difference) = &mut pair.difference else { continue };
        difference.p_family = adjusted.next().unwrap_or(1.0);
        if pair.call == Call::Near && difference.p_family <= LEVEL {
            pair.call = Call::Differs;
        }
    }
    for (pair, p_family) in comparison.curves.iter_mut().zip(adjusted) {
        if pair.p.is_some() {
            pair.p_family = Some(p_family);
        }
        if pair.call == Call::Near && p_family <= LEVEL {
            pair.call = Call::Differs;
        }
    }
}
