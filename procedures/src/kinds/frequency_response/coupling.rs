//! How much of the motion of an axis shows on the other one.

use super::point::Point;
use crate::analysis::frf::Line;
use crate::kinds::excited::Channel;
use crate::measurement::{Estimate, Exclusion, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const NAMES: &[&str] = &["cross-coupling-low", "cross-coupling-high"];
const ESTIMATOR: &str = "cross-coupling/1";
/// Up to here nothing may be visible (director.md, STR-XAX).
const LOW_HZ: f64 = 10.0;

pub(super) fn evaluate(point: &Point<'_>, result: &mut PointResult) {
    // The reference is the rate of this axis, whose lines are judged; little of the other one is what is wanted.
    let judged = point.response(Channel::Torque, Channel::Rate);
    let ratio = point.measured.response(Channel::Rate, Channel::OtherRate);
    let (judged, ratio) = match (judged, ratio) {
        (Ok(judged), Ok(ratio)) => (judged, ratio),
        (Err(reason), _) | (_, Err(reason)) => {
            for name in NAMES {
                let axis = &point.case.axis;
                let none = Measurement::inconclusive(name, axis, Q::Ratio, ESTIMATOR, reason.as_str());
                result.measurements.push(point.measurement(none));
            }
            return;
        }
    };
    let counts = |line: &&Line| judged.lines.iter().any(|l| l.frequency_hz == line.frequency_hz);
    let lines: Vec<&Line> = ratio.iter().filter(counts).collect();
    let (low, high): (Vec<&Line>, Vec<&Line>) = lines.into_iter().partition(|l| l.frequency_hz <= LOW_HZ);
    for (name, band) in NAMES.iter().zip([low, high]) {
        let measurement = worst(name, &point.case.axis, &band, &judged.excluded);
        result.measurements.push(point.measurement(measurement));
    }
    result.numbers.insert("coupling-hz".to_owned(), ratio.iter().map(|l| l.frequency_hz).collect());
    result.numbers.insert("coupling".to_owned(), ratio.iter().map(|l| l.value.norm()).collect());
}

/// The largest ratio of a band. Its noise only ever adds to it, so it is not taken off.
fn worst(name: &str, axis: &str, band: &[&Line], excluded: &[Exclusion]) -> Measurement {
    let largest = band.iter().max_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
    let Some(line) = largest else {
        let reason = "no line of the band was excited enough".to_owned();
        return Measurement {
            excluded: excluded.to_vec(),
            ..Measurement::inconclusive(name, axis, Q::Ratio, ESTIMATOR, reason)
        };
    };
    let u = (0.5 * line.variance).sqrt();
    let estimate = Estimate { value: line.value.norm(), u, dof: 2.0 * line.dof, n: band.len() };
    Measurement {
        flags: vec![format!("at {:.2} Hz", line.frequency_hz)],
        excluded: excluded.to_vec(),
        ..Measurement::new(name, axis, Q::Ratio, Some(estimate), ESTIMATOR)
    }
}
