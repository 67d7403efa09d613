//! Sum of the harmonics of single sines, against the procedure's own criterion.

use std::collections::BTreeMap;

use super::Point;
use crate::case::Case;
use crate::kinds::fsm_response::keys::Keys;
use crate::kinds::fsm_response::level::Reading;
use crate::kinds::fsm_response::measure::{complete, measurement};
use crate::kinds::fsm_response::record::{TONE_WIDTH, TONES};
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;

pub(in crate::kinds::fsm_response) const DISTORTION: &str = "harmonic-distortion";
const NOT_MET: &str = "not met";

/// One measurement a sine; the judge checks the level of each.
pub(in crate::kinds::fsm_response) fn of_point(
    keys: &Keys,
    case: &Case,
    numbers: &BTreeMap<String, Vec<f64>>,
) -> Vec<Measurement> {
    let Some(criterion) = keys.harmonics.as_ref().map(|h| &h.criterion) else { return Vec::new() };
    let tones = numbers.get(TONES).map_or(&[][..], Vec::as_slice);
    let one = |&[frequency_hz, value, u, level_v]: &[f64; TONE_WIDTH]| {
        let mut m = measurement(DISTORTION, Q::Ratio, case, Ok(Reading { value, u, dof: 4.0, n: 5 }));
        complete(&mut m, keys, case, numbers);
        m.conditions.iter_mut().for_each(|c| c.achieved = Some(level_v));
        m.flags.push(format!("sine of {}", Q::Frequency.format(frequency_hz)));
        let met = if criterion.holds(value) { "met" } else { NOT_MET };
        m.flags.push(format!("criterion {} {met}", criterion.text));
        m
    };
    tones.as_chunks::<TONE_WIDTH>().0.iter().map(one).collect()
}

/// What the point measured, and a remark where the criterion is not met.
pub(super) fn told((case, result): Point<'_>) -> (Vec<Measurement>, Vec<String>) {
    if let (true, Some(reason)) = (result.measurements.is_empty(), &result.inconclusive) {
        return (vec![measurement(DISTORTION, Q::Ratio, case, Err(reason.clone()))], Vec::new());
    }
    let missed = |m: &Measurement| {
        let value = m.value.filter(|_| m.flags.iter().any(|flag| flag.ends_with(NOT_MET)))?;
        let flags = m.flags.iter().rev().take(2).rev().cloned().collect::<Vec<_>>().join(", ");
        Some(format!("{}: harmonics 2 to 5 sum up to {} ({flags})", case.point, Q::Ratio.format(value)))
    };
    (result.measurements.clone(), result.measurements.iter().filter_map(missed).collect())
}
