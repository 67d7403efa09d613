//! How much of the motion of an axis shows on the other one, and whether gyro and encoder see the same motion.

use analysis::estimate::Estimate;
use analysis::frf::Line;
use analysis::periodic::times_jw;

use super::point::{Kept, Point};
use crate::case::Case;
use crate::kinds::response::excited::{Channel, ELEVATION};
use crate::measurement::{Condition, Exclusion, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{Reason, ResponseReason};

#[cfg(test)]
mod tests;

pub(super) const NAMES: &[&str] = &["cross-coupling-low", "cross-coupling-high"];
const ESTIMATOR: &str = "cross-coupling/2";
/// Up to here nothing may be visible (director.md, STR-XAX).
const LOW_HZ: f64 = 10.0;
/// Below this the loop that holds the other axis takes what it sees away, and only noise is left.
const LOWEST_HZ: f64 = 2.0;

/// How much of the motion shows on the other axis, in one point.
pub(super) struct Coupling {
    /// Mean elevation of the point, where it is known.
    elevation_rad: Option<f64>,
    parts: Vec<Part>,
    /// Rate of the other axis over that of this one: frequencies in Hz, magnitudes.
    pub(super) frequency_hz: Vec<f64>,
    pub(super) ratio: Vec<f64>,
}

pub(super) fn evaluate(point: &Point<'_>, result: &mut PointResult) -> Option<Coupling> {
    // The reference is the rate of this axis, whose lines are judged; little of the other one is what is wanted.
    let judged = point.response(Channel::Torque, Channel::Rate);
    let ratio = point.measured.response(Channel::Rate, Channel::OtherRate);
    let (judged, ratio) = match (judged, ratio) {
        (Ok(judged), Ok(ratio)) => (judged, ratio),
        (Err(reason), _) | (_, Err(reason)) => {
            for name in NAMES {
                let axis = &point.case.axis;
                let none = Measurement::inconclusive(name, axis, Q::Ratio, ESTIMATOR, &reason);
                result.measurements.push(point.measurement(none));
            }
            return None;
        }
    };
    let with_own = |line: &'_ Line| {
        let own = judged.lines.iter().find(|l| l.frequency_hz == line.frequency_hz)?;
        Some(own.value.norm_sqr()).filter(|w| *w > 0.0)
    };
    let far = ratio.iter().filter(|line| line.frequency_hz >= LOWEST_HZ);
    let lines: Vec<(&Line, f64)> = far.filter_map(|line| Some((line, with_own(line)?))).collect();
    let elevation = point.conditions.iter().find(|c| c.name == ELEVATION);
    Some(Coupling {
        elevation_rad: elevation.and_then(|c| c.achieved),
        parts: parts(&lines),
        frequency_hz: ratio.iter().map(|l| l.frequency_hz).collect(),
        ratio: ratio.iter().map(|l| l.value.norm()).collect(),
    })
}

/// The coupling that a point shows, if it is one that shows any.
pub(super) fn of_point(point: &PointResult) -> Option<&Coupling> {
    point.reduced.get::<Kept>()?.coupling.as_ref()
}

/// What all levels at an elevation say together, worst part of each band.
///
/// A response does not depend on its level, so the squares of all points at an elevation are averaged with the inverse
/// of their variances: weak levels say little and cost nothing.
pub(super) fn conclude(cases: &[Case], points: &[PointResult]) -> Vec<Measurement> {
    let with = |p: &&PointResult| of_point(p).is_some();
    let elevation = |p: &PointResult| {
        let case = cases.iter().find(|case| case.point == p.point)?;
        Some((case.axis.as_str(), case.requested(ELEVATION).unwrap_or(0.0)))
    };
    let mut all = Vec::new();
    for planned in points.chunk_by(|a, b| elevation(a) == elevation(b)) {
        let Some((axis, elevation_rad)) = elevation(&planned[0]) else { continue };
        let group: Vec<&PointResult> = planned.iter().filter(with).collect();
        let Some(first) = group.first() else {
            all.extend(lost(axis, elevation_rad, planned));
            continue;
        };
        let group = group.as_slice();
        let achieved = of_point(first).and_then(|coupling| coupling.elevation_rad);
        let condition =
            Condition { name: ELEVATION.to_owned(), requested: elevation_rad, achieved, kind: Q::Angle };
        let parts = pooled(group);
        let (low, high): (Vec<Part>, Vec<Part>) = parts.into_iter().partition(|p| p.band_hz[1] <= LOW_HZ);
        for (name, band) in NAMES.iter().zip([low, high]) {
            let evidence =
                group.iter().filter_map(|p| p.measurements.first()).flat_map(|m| m.evidence.clone());
            let conditions = vec![condition.clone()];
            let evidence = evidence.collect::<Vec<_>>();
            let with = |m| Measurement { conditions: conditions.clone(), evidence: evidence.clone(), ..m };
            all.extend(worst(name, axis, &band, group).into_iter().map(with));
        }
    }
    all
}

/// An elevation that no point tells anything of, and that did not say so itself.
fn lost(axis: &str, elevation_rad: f64, planned: &[PointResult]) -> Vec<Measurement> {
    if planned.iter().all(|p| p.measurements.iter().any(|m| NAMES.contains(&m.measurand.as_str()))) {
        return Vec::new();
    }
    let reason = planned.iter().find_map(|p| p.inconclusive.clone());
    let reason = reason.unwrap_or_else(|| ResponseReason::NoResponseAtElevation.into());
    let at =
        Condition { name: ELEVATION.to_owned(), requested: elevation_rad, achieved: None, kind: Q::Angle };
    let none = |name: &&str| Measurement {
        conditions: vec![at.clone()],
        ..Measurement::inconclusive(name, axis, Q::Ratio, ESTIMATOR, &reason)
    };
    NAMES.iter().map(none).collect()
}

/// The parts of several points: those that begin in the same part of an octave, together.
fn pooled(group: &[&PointResult]) -> Vec<Part> {
    let mut all: Vec<Part> = Vec::new();
    for point in group {
        for own in of_point(point).map_or(&[][..], |coupling| &coupling.parts) {
            match all.iter_mut().find(|p| index(p.band_hz[0]) == index(own.band_hz[0])) {
                Some(part) => part.join(own),
                None => all.push(*own),
            }
        }
    }
    all.sort_by(|a, b| a.band_hz[0].total_cmp(&b.band_hz[0]));
    all
}

/// The part of a band that is surely the largest: of the others only noise is larger. And, where that is another one, the part
/// in which the largest coupling might hide. Octaves up to 10 Hz, where no mode makes it sharp, third octaves above.
fn worst(name: &str, axis: &str, band: &[Part], group: &[&PointResult]) -> Vec<Measurement> {
    let excluded: Vec<Exclusion> =
        group.iter().filter_map(|p| p.measurements.first()).flat_map(|m| m.excluded.clone()).collect();
    let least = |p: &Part| (p.square - 2.0 * p.variance.sqrt()).max(0.0);
    let largest =
        band.iter().max_by(|a, b| least(a).total_cmp(&least(b)).then(a.upper().total_cmp(&b.upper())));
    let Some(largest) = largest else {
        let reason = ResponseReason::NotExcitedEnough;
        let none = Measurement::inconclusive(name, axis, Q::Ratio, ESTIMATOR, reason);
        return vec![Measurement { excluded, ..none }];
    };
    let hidden = band.iter().max_by(|a, b| a.upper().total_cmp(&b.upper()));
    let hidden = hidden.filter(|p| p.band_hz != largest.band_hz).map(|p| (p, "least certain"));
    let measurement = |(part, word): (&Part, &str)| {
        let value = part.square.max(0.0).sqrt();
        // Half of what two standard deviations of the square add to the ratio: right near zero, too.
        let estimate = Estimate { value, u: 0.5 * (part.upper() - value), dof: f64::INFINITY, n: part.lines };
        Measurement {
            flags: vec![
                format!("{word} from {:.2} Hz to {:.2} Hz", part.band_hz[0], part.band_hz[1]),
                format!("{} points together", group.len()),
            ],
            excluded: excluded.clone(),
            ..Measurement::new(name, axis, Q::Ratio, Some(estimate), ESTIMATOR)
        }
    };
    [(largest, "worst")].into_iter().chain(hidden).map(measurement).collect()
}

/// An octave, or a third of one.
#[derive(Clone, Copy)]
struct Part {
    band_hz: [f64; 2],
    /// Mean square ratio, without noise; may be below zero by noise.
    square: f64,
    variance: f64,
    lines: usize,
}

impl Part {
    /// The ratio at two standard deviations above.
    fn upper(&self) -> f64 {
        (self.square.max(0.0) + 2.0 * self.variance.sqrt()).sqrt()
    }

    /// Mean with the inverse of the variances.
    fn join(&mut self, other: &Self) {
        let [own, its] = [self.variance, other.variance].map(|v| 1.0 / v.max(f64::MIN_POSITIVE));
        self.square = (own * self.square + its * other.square) / (own + its);
        self.variance = 1.0 / (own + its);
        self.lines += other.lines;
        self.band_hz = [self.band_hz[0].min(other.band_hz[0]), self.band_hz[1].max(other.band_hz[1])];
    }
}

/// Which octave, or third of one, a frequency lies in.
fn index(hz: f64) -> (bool, i32) {
    let low = hz <= LOW_HZ;
    let per_octave = if low { 1.0 } else { 3.0 };
    (low, (per_octave * (hz / LOW_HZ).log2()).ceil() as i32)
}

/// Power of the other axis' rate over that of this one, of the same torque, in each part: C² = Σ w·(|H|² − σ²)/Σ w with
/// w = |G|², G from torque to this axis' rate. Where the axis itself hardly moves (its anti-resonances) a line says little
/// and weighs little. Var(w·|H|²) = n² + 2·w·|H|²·n of a complex normal, n = w·σ².
fn parts(lines: &[(&Line, f64)]) -> Vec<Part> {
    let part = |part: &[(&Line, f64)]| {
        let count = part.len() as f64;
        let sum = |f: &dyn Fn(&Line, f64) -> f64| part.iter().map(|(l, w)| f(l, *w)).sum::<f64>();
        let weight = sum(&|_, w| w);
        // Variances of a few windows scatter: the noise of a part is the mean over its lines.
        let noise = sum(&|l, w| w * l.variance) / count;
        let power = sum(&|l, w| w * l.value.norm_sqr()) / count - noise;
        let variance = count * (noise * noise + 2.0 * power.max(0.0) * noise) / (weight * weight);
        Part {
            band_hz: [part[0].0.frequency_hz, part[part.len() - 1].0.frequency_hz],
            square: count * power / weight,
            variance,
            lines: part.len(),
        }
    };
    lines.chunk_by(|a, b| index(a.0.frequency_hz) == index(b.0.frequency_hz)).map(part).collect()
}

pub(super) const COAXIALITY_NAME: &str = "sensor-coaxiality";
const COAXIALITY_ESTIMATOR: &str = "sensor-coaxiality/1";
/// Up to here the structure is stiff enough to be looked through (first mode at 10 Hz, ζ 0.1).
const STIFF_HZ: f64 = 5.0;

/// Lines that scatter more than this would only show their noise.
const SHARP: f64 = 0.005;

pub(super) fn evaluate_coaxiality(point: &Point<'_>, result: &mut PointResult) {
    let axis = &point.case.axis;
    let measurement = match gyro_over_encoder(point) {
        Ok(lines) => largest_departure(axis, &lines),
        Err(reason) => {
            Measurement::inconclusive(COAXIALITY_NAME, axis, Q::Ratio, COAXIALITY_ESTIMATOR, reason)
        }
    };
    result.measurements.push(point.measurement(measurement));
}

/// Gyro over jω times encoder, both as old as each other: what is common to their delays has gone.
fn gyro_over_encoder(point: &Point<'_>) -> Result<Vec<Line>, Reason> {
    let judged = point.response(Channel::Angle, Channel::Rate)?;
    let lines = times_jw(&judged.lines, -1)?;
    let sharp = |l: &Line| l.frequency_hz <= STIFF_HZ && l.relative_sd() < SHARP;
    Ok(lines.into_iter().filter(sharp).collect())
}

fn largest_departure(axis: &str, lines: &[Line]) -> Measurement {
    let departure = |l: &Line| (l.value.norm() - 1.0).abs();
    let Some(line) = lines.iter().max_by(|a, b| departure(a).total_cmp(&departure(b))) else {
        let reason = ResponseReason::NoLineBelow { up_to_hz: STIFF_HZ };
        return Measurement::inconclusive(COAXIALITY_NAME, axis, Q::Ratio, COAXIALITY_ESTIMATOR, reason);
    };
    let u = (0.5 * line.variance).sqrt();
    let estimate = Estimate { value: departure(line), u, dof: 2.0 * line.dof, n: lines.len() };
    let late_s = -line.value.arg() / (std::f64::consts::TAU * line.frequency_hz);
    Measurement {
        flags: vec![
            format!("at {:.2} Hz", line.frequency_hz),
            format!("gyro {:+.2} ms after the encoder", 1e3 * late_s),
        ],
        ..Measurement::new(COAXIALITY_NAME, axis, Q::Ratio, Some(estimate), COAXIALITY_ESTIMATOR)
    }
}
