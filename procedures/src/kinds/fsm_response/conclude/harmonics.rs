//! Sum of the harmonics of single sines, against the procedure's own criterion.

use super::Point;
use crate::kinds::fsm_response::keys::Keys;
use crate::kinds::fsm_response::level::Reading;
use crate::kinds::fsm_response::measure::{complete, measurement};
use crate::kinds::fsm_response::record::{TONE_WIDTH, TONES};
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;

pub(in crate::kinds::fsm_response) const DISTORTION: &str = "harmonic-distortion";

/// One measurement a sine, and a remark where the criterion is not met.
pub(super) fn measurements(keys: &Keys, point: Point<'_>) -> (Vec<Measurement>, Vec<String>) {
    let (case, result) = point;
    let (mut all, mut remarks) = (Vec::new(), Vec::new());
    let Some(criterion) = keys.harmonics.as_ref().map(|h| &h.criterion) else { return (all, remarks) };
    let tones = result.numbers.get(TONES).map_or(&[][..], Vec::as_slice);
    for &[frequency_hz, value, u] in tones.as_chunks::<TONE_WIDTH>().0 {
        let frequency = Q::Frequency.format(frequency_hz);
        let mut m = measurement(DISTORTION, Q::Ratio, case, Ok(Reading { value, u, dof: 4.0, n: 5 }));
        complete(&mut m, keys, case, &result.numbers);
        m.flags.push(format!("sine of {frequency}"));
        let met = criterion.holds(value);
        m.flags.push(format!("criterion {} {}", criterion.text, if met { "met" } else { "not met" }));
        if !met {
            let share = Q::Ratio.format(value);
            remarks.push(format!(
                "{}: harmonics 2 to 5 of {frequency} sum up to {share}, criterion {}",
                case.point, criterion.text
            ));
        }
        all.push(m);
    }
    if let Some(reason) = result.inconclusive.clone().filter(|_| all.is_empty()) {
        all.push(measurement(DISTORTION, Q::Ratio, case, Err(reason)));
    }
    (all, remarks)
}
