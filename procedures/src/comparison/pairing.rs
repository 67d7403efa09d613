//! Which findings of two runs are about the same.

use super::Found;
use crate::agreement::is_same;
use crate::measurement::Measurement;

/// A procedure with what each run found by it.
pub(super) struct ProcedurePair<'a> {
    pub(super) a: Found<'a>,
    pub(super) b: Found<'a>,
}

/// Every procedure of either run, in the order of the first one; those of the second one alone follow.
pub(super) fn procedures<'a>(a: &[Found<'a>], b: &[Found<'a>]) -> Vec<ProcedurePair<'a>> {
    let nothing = |procedure| Found { procedure, measurements: &[], plots: &[] };
    let found_by = |all: &[Found<'a>], id: &str| all.iter().find(|found| found.procedure == id).copied();
    let from_a = a.iter().map(|&own| ProcedurePair {
        a: own,
        b: found_by(b, own.procedure).unwrap_or_else(|| nothing(own.procedure)),
    });
    let alone = b.iter().filter(|own| found_by(a, own.procedure).is_none());
    from_a.chain(alone.map(|&own| ProcedurePair { a: nothing(own.procedure), b: own })).collect()
}

/// A quantity with what each run says of it; at least one of them does.
pub(super) struct MeasurementPair<'a> {
    pub(super) a: Option<&'a Measurement>,
    pub(super) b: Option<&'a Measurement>,
}

/// Pairs measurements of one procedure by measurand, axis, conditions asked for, mode of the structure, and point. Where a point
/// has another name, all the rest suffices. Of several alike the first belongs to the first.
pub(super) fn measurements<'a>(a: &'a [Measurement], b: &'a [Measurement]) -> Vec<MeasurementPair<'a>> {
    let mut partner: Vec<Option<usize>> = vec![None; a.len()];
    let mut taken = vec![false; b.len()];
    for must_be_same_point in [true, false] {
        let suits = |own: &Measurement, other: &Measurement| !must_be_same_point || own.point == other.point;
        for (own, place) in a.iter().zip(&mut partner).filter(|(_, place)| place.is_none()) {
            *place = (0..b.len()).find(|&k| !taken[k] && is_of_same(own, &b[k]) && suits(own, &b[k]));
            if let Some(k) = *place {
                taken[k] = true;
            }
        }
    }
    let from_a = a.iter().zip(partner).map(|(own, k)| MeasurementPair { a: Some(own), b: k.map(|k| &b[k]) });
    let left = b.iter().zip(taken).filter(|(_, taken)| !taken);
    from_a.chain(left.map(|(other, _)| MeasurementPair { a: None, b: Some(other) })).collect()
}

fn is_of_same(a: &Measurement, b: &Measurement) -> bool {
    is_same(a, b) && mode(a) == mode(b)
}

/// Number of the mode that a measurement is about, as its first flag tells it: `mode 2 at 17.87 Hz`.
fn mode(m: &Measurement) -> Option<&str> {
    m.flags.first()?.strip_prefix("mode ")?.split(' ').next()
}
