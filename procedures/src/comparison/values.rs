//! Differences of values.

use std::f64::consts::TAU;

use analysis::uncertainty::{Component, combine};

use super::pairing::{self, MeasurementPair, ProcedurePair};
use super::published::PublishedValue;
use super::{Call, Comparison, Difference, Quantity, Value, ValuePair};
use crate::measurement::Measurement;
use crate::quantity::QuantityKind;
use crate::verdict::{coverage_factor, two_sided_tail};

/// Values that are no farther apart than this share of the larger one are the same but for rounding.
const ROUNDING_RATIO: f64 = 1e-9;
/// Values that are no farther apart than this, SI, are the same but for rounding: parts of it are what is left of zero.
const ROUNDING_SI: f64 = 1e-12;

/// Adds the values of a procedure.
pub(super) fn add(comparison: &mut Comparison, pair: &ProcedurePair<'_>, tolerance: Option<f64>) {
    for own in pairing::measurements(pair.a.measurements, pair.b.measurements) {
        match compared(pair.a.procedure, &own, tolerance) {
            Some(pair) => comparison.values.push(pair),
            None => comparison.without_value += 1,
        }
    }
}

/// Adds a measurement beside what was published of its quantity.
pub(super) fn add_published(
    comparison: &mut Comparison,
    procedure: &str,
    own: &Measurement,
    published: &PublishedValue,
    tolerance: Option<f64>,
) {
    let Some(a) = counts(own) else { return };
    let b = published.value;
    let difference = Difference::new(a, b, is_phase(own));
    comparison.values.push(ValuePair {
        quantity: Quantity::new(procedure, own),
        a: Some(a),
        b: Some(b),
        call: first_call(a, b, &difference, tolerance),
        difference: Some(difference),
        reason: None,
    });
}

/// `None` where neither run has a value.
fn compared(procedure: &str, pair: &MeasurementPair<'_>, tolerance: Option<f64>) -> Option<ValuePair> {
    let a = pair.a.and_then(counts);
    let b = pair.b.and_then(counts);
    let named = pair.a.filter(|_| a.is_some()).or(pair.b)?;
    let why = |missing: Option<&Measurement>| missing.and_then(|m| m.inconclusive.clone());
    let difference = a.zip(b).map(|(a, b)| Difference::new(a, b, is_phase(named)));
    let (call, reason) = match (a, b, &difference) {
        (Some(a), Some(b), Some(difference)) => (first_call(a, b, difference, tolerance), None),
        (Some(_), ..) => (Call::OnlyInA, why(pair.b)),
        (None, Some(_), _) => (Call::OnlyInB, why(pair.a)),
        (None, ..) => return None,
    };
    let quantity = Quantity::new(procedure, named);
    Some(ValuePair { quantity, a, b, difference, call, reason })
}

/// Whether whole turns do not count.
fn is_phase(m: &Measurement) -> bool {
    m.kind == QuantityKind::Angle && m.measurand.ends_with("-phase")
}

/// The value of a measurement on which a verdict could rest.
fn counts(m: &Measurement) -> Option<Value> {
    let value = m.value.filter(|value| value.is_finite() && m.inconclusive.is_none())?;
    Some(Value { value, u: m.u, dof: m.dof })
}

/// What is said of a pair alone: `Near` where it is beyond its uncertainty, until all pairs are known.
fn first_call(a: Value, b: Value, difference: &Difference, tolerance: Option<f64>) -> Call {
    let same_bits = |x: f64, y: f64| x.to_bits() == y.to_bits();
    if same_bits(a.value, b.value) && same_bits(a.u, b.u) && a.dof == b.dof {
        return Call::Identical;
    }
    let larger = a.value.abs().max(b.value.abs());
    let allowed = (ROUNDING_RATIO.max(tolerance.unwrap_or(0.0)) * larger).max(ROUNDING_SI);
    let within_u = difference.value.abs() <= difference.expanded_u;
    if difference.value.abs() <= allowed || within_u { Call::Same } else { Call::Near }
}

impl Quantity {
    pub(super) fn new(procedure: &str, m: &Measurement) -> Self {
        Self {
            procedure: procedure.to_owned(),
            measurand: m.measurand.clone(),
            axis: m.axis.clone(),
            point: m.point.clone(),
            conditions: m.conditions.clone(),
            kind: m.kind,
        }
    }
}

impl Difference {
    /// Of a phase the shorter way around counts.
    fn new(a: Value, b: Value, is_phase: bool) -> Self {
        let apart = b.value - a.value;
        let value = if is_phase { apart - TAU * (apart / TAU).round() } else { apart };
        let component = |of: Value| Component { u: of.u, dof: of.dof.unwrap_or(f64::INFINITY) };
        let both = combine(&[component(a), component(b)]);
        let dof = both.dof.is_finite().then_some(both.dof);
        let k = coverage_factor(dof);
        let apart_u = (both.u > 0.0).then(|| value.abs() / both.u);
        // Without any uncertainty a difference is one.
        let p = match apart_u {
            Some(apart_u) => two_sided_tail(apart_u, dof),
            None => f64::from(u8::from(value == 0.0)),
        };
        Self { value, u: both.u, dof, k, expanded_u: k * both.u, apart_u, p, p_family: 1.0 }
    }
}
