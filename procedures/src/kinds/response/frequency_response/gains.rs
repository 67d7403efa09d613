//! Torque to rate with a loose loop around it, and without one: both must be the axis.

use analysis::estimate::Estimate;
use analysis::frf::Line;

use super::point::Kept;
use crate::case::Case;
use crate::kinds::response::excited::{ELEVATION, GAINS, LEVEL};
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::trace::{Plot, Scale, Series, Style};

pub(super) const NAME: &str = "gains-departure";
const ESTIMATOR: &str = "gains-departure/1";

/// Lines of torque to rate that a point kept.
fn kept(point: &PointResult) -> &[Line] {
    point.reduced.get::<Kept>().map_or(&[], |kept| &kept.plant)
}

/// Points that differ in their gains only, in the order of the plan.
fn groups<'a>(cases: &'a [Case], points: &'a [PointResult]) -> Vec<Vec<(&'a Case, &'a PointResult)>> {
    let with_case =
        |p: &'a PointResult| cases.iter().find(|case| case.point == p.point).map(|case| (case, p));
    let all: Vec<(&Case, &PointResult)> = points.iter().filter_map(with_case).collect();
    let place = |case: &Case| (case.requested(ELEVATION), case.requested(LEVEL));
    all.chunk_by(|a, b| place(a.0) == place(b.0)).map(<[_]>::to_vec).collect()
}

/// Each against the first of its group.
pub(super) fn departures(cases: &[Case], points: &[PointResult]) -> Vec<Measurement> {
    let mut all = Vec::new();
    for group in groups(cases, points) {
        let Some(((_, first), others)) = group.split_first() else { continue };
        all.extend(others.iter().map(|(case, other)| between(case, first, other)));
    }
    all
}

/// A point against the first of its group, under the point's conditions.
fn between(case: &Case, first: &PointResult, other: &PointResult) -> Measurement {
    let told = [first, other].map(|p| p.measurements.first());
    let conditions = told[1].map_or_else(Vec::new, |m| m.conditions.clone());
    let evidence = told.into_iter().flatten().flat_map(|m| m.evidence.clone()).collect();
    let measurement = match departure(kept(first), kept(other)) {
        Some((estimate, flags)) => {
            Measurement { flags, ..Measurement::new(NAME, &case.axis, Q::Ratio, Some(estimate), ESTIMATOR) }
        }
        None => {
            let reason = first.inconclusive.clone().or_else(|| other.inconclusive.clone());
            let reason = reason.unwrap_or_else(|| "fewer than five lines count in both".to_owned());
            Measurement::inconclusive(NAME, &case.axis, Q::Ratio, ESTIMATOR, reason)
        }
    };
    Measurement { conditions, evidence, ..measurement }
}

/// Root mean square of |G₂/G₁ − 1| over the lines that both have, weighted by what each knows, less what their noise makes;
/// its uncertainty is half of what two standard deviations of the square add or take away.
fn departure(first: &[Line], other: &[Line]) -> Option<(Estimate, Vec<String>)> {
    let pair = |a: &Line| {
        let b = other.iter().find(|b| b.frequency_hz == a.frequency_hz)?;
        // Of the complex ratio: twice that of its modulus.
        let variance = 2.0 * (a.relative_sd().powi(2) + b.relative_sd().powi(2));
        Some((a.frequency_hz, (b.value / a.value - 1.0).norm_sqr(), variance)).filter(|_| variance > 0.0)
    };
    let pairs: Vec<(f64, f64, f64)> = first.iter().filter_map(pair).collect();
    if pairs.len() < 5 {
        return None;
    }
    let n = pairs.len() as f64;
    let weight: f64 = pairs.iter().map(|(.., v)| 1.0 / v).sum();
    let chi2: f64 = pairs.iter().map(|(_, square, v)| square / v).sum();
    let square = ((chi2 - n) / weight).max(0.0);
    let value = square.sqrt();
    let scatter = 2.0 * chi2.max(n) / n.sqrt() / weight;
    let [upper, lower] = [square + scatter, square - scatter].map(|s| s.max(0.0).sqrt());
    let u = 0.5 * (upper - value).max(value - lower);
    let estimate = Estimate { value, u, dof: n, n: pairs.len() };
    let worst = pairs.iter().max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)))?;
    let flags = vec![
        format!("chi2/dof {:.2} over {} lines", chi2 / n, pairs.len()),
        format!("most at {:.2} Hz: {:.2} %", worst.0, 100.0 * worst.1.sqrt()),
    ];
    Some((estimate, flags))
}

/// Gains of all points of a group in one picture.
pub(super) fn pictures(cases: &[Case], points: &[PointResult]) -> Vec<Plot> {
    let series = |(case, point): &(&Case, &PointResult)| {
        let lines = kept(point);
        let label = format!("gains {}", Q::Ratio.format(case.requested(GAINS).unwrap_or(1.0)));
        let (x, y) = lines.iter().map(|l| (l.frequency_hz, l.gain_db())).unzip();
        Series::new(label, Style::Line, x, y)
    };
    let picture = |(k, group): (usize, Vec<(&Case, &PointResult)>)| Plot {
        series: group.iter().map(series).filter(|s| !s.x.is_empty()).collect(),
        ..Plot::new(
            format!("plant-by-gains-{k}"),
            "Torque to rate by the gains of the loop around it",
            Scale::logarithmic("frequency", "Hz"),
            Scale::linear("gain, re rad/s/(N*m)", "dB"),
        )
    };
    groups(cases, points).into_iter().enumerate().map(picture).filter(|p| p.series.len() > 1).collect()
}

#[cfg(test)]
mod tests;
