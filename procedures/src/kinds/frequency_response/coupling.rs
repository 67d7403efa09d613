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

/// The largest of the third octaves of a band.
fn worst(name: &str, axis: &str, band: &[&Line], excluded: &[Exclusion]) -> Measurement {
    let octaves = third_octaves(band);
    let largest = octaves.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let Some(third) = largest else {
        let reason = "no line of the band was excited enough".to_owned();
        return Measurement {
            excluded: excluded.to_vec(),
            ..Measurement::inconclusive(name, axis, Q::Ratio, ESTIMATOR, reason)
        };
    };
    let estimate = Estimate { value: third.ratio, u: third.u, dof: f64::INFINITY, n: third.lines };
    Measurement {
        flags: vec![format!("third octave from {:.2} Hz", third.from_hz)],
        excluded: excluded.to_vec(),
        ..Measurement::new(name, axis, Q::Ratio, Some(estimate), ESTIMATOR)
    }
}

/// A third of an octave.
struct ThirdOctave {
    from_hz: f64,
    ratio: f64,
    u: f64,
    lines: usize,
}

/// Root mean square ratio in each third octave, less what noise adds to it: with n lines of variance σ² and weights 1/σ²,
/// C² = Σ w·(|H|² − σ²)/Σ w, and Var |H|² = σ⁴ + 2·|H|²·σ² of a complex normal.
fn third_octaves(lines: &[&Line]) -> Vec<ThirdOctave> {
    let index = |l: &Line| (3.0 * l.frequency_hz.log2()).floor();
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
            ThirdOctave { from_hz: part[0].frequency_hz, ratio: square.sqrt(), u, lines: part.len() }
        })
        .collect()
}
