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
/// Below this the loop that holds the other axis takes what it sees away, and only noise is left.
const LOWEST_HZ: f64 = 2.0;

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
    let counts = |line: &&Line| {
        line.frequency_hz >= LOWEST_HZ && judged.lines.iter().any(|l| l.frequency_hz == line.frequency_hz)
    };
    let lines: Vec<&Line> = ratio.iter().filter(counts).collect();
    let (low, high): (Vec<&Line>, Vec<&Line>) = lines.into_iter().partition(|l| l.frequency_hz <= LOW_HZ);
    for (name, band) in NAMES.iter().zip([low, high]) {
        let measurement = worst(name, &point.case.axis, &band, &judged.excluded);
        result.measurements.push(point.measurement(measurement));
    }
    result.numbers.insert("coupling-hz".to_owned(), ratio.iter().map(|l| l.frequency_hz).collect());
    result.numbers.insert("coupling".to_owned(), ratio.iter().map(|l| l.value.norm()).collect());
}

/// The largest part of a band: octaves up to 10 Hz, where no mode makes it sharp, third octaves above.
fn worst(name: &str, axis: &str, band: &[&Line], excluded: &[Exclusion]) -> Measurement {
    let octaves = parts(band);
    let largest = octaves.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let Some(part) = largest else {
        let reason = "no line of the band was excited enough".to_owned();
        return Measurement {
            excluded: excluded.to_vec(),
            ..Measurement::inconclusive(name, axis, Q::Ratio, ESTIMATOR, reason)
        };
    };
    let estimate = Estimate { value: part.ratio, u: part.u, dof: f64::INFINITY, n: part.lines };
    Measurement {
        flags: vec![format!("worst from {:.2} Hz to {:.2} Hz", part.band_hz[0], part.band_hz[1])],
        excluded: excluded.to_vec(),
        ..Measurement::new(name, axis, Q::Ratio, Some(estimate), ESTIMATOR)
    }
}

/// An octave, or a third of one.
struct Part {
    band_hz: [f64; 2],
    ratio: f64,
    u: f64,
    lines: usize,
}

/// Root mean square ratio in each part, less what noise adds to it: with n lines of variance σ² and weights 1/σ²,
/// C² = Σ w·(|H|² − σ²)/Σ w, and Var |H|² = σ⁴ + 2·|H|²·σ² of a complex normal.
fn parts(lines: &[&Line]) -> Vec<Part> {
    let per_octave = |l: &Line| if l.frequency_hz <= LOW_HZ { 1.0 } else { 3.0 };
    let index = |l: &Line| (per_octave(l) * (l.frequency_hz / LOW_HZ).log2()).ceil();
    lines
        .chunk_by(|a, b| index(a) == index(b))
        .map(|part| {
            let weights: f64 = part.iter().map(|l| 1.0 / l.variance.max(f64::MIN_POSITIVE)).sum();
            let mean = |f: &dyn Fn(&Line) -> f64| -> f64 {
                part.iter().map(|l| f(l) / l.variance.max(f64::MIN_POSITIVE)).sum::<f64>() / weights
            };
            let square = mean(&|l| l.value.norm_sqr() - l.variance).max(0.0);
            let spread: f64 = part
                .iter()
                .map(|l| {
                    let share = 1.0 / l.variance.max(f64::MIN_POSITIVE) / weights;
                    share * share * (l.variance * l.variance + 2.0 * square * l.variance)
                })
                .sum();
            // Half of what two standard deviations of the square add to the ratio: right near zero, too.
            let u = 0.5 * ((square + 2.0 * spread.sqrt()).sqrt() - square.sqrt());
            let band_hz = [part[0].frequency_hz, part[part.len() - 1].frequency_hz];
            Part { band_hz, ratio: square.sqrt(), u, lines: part.len() }
        })
        .collect()
}
