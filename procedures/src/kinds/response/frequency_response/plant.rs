//! Torque to rate and angle: what the controller has to do with, how linear it is, whether other gains show the same.

use std::f64::consts::TAU;

use analysis::estimate::Estimate;
use analysis::frf::Line;
use analysis::goodness::Goodness;
use analysis::least_squares::LinearFit;
use analysis::periodic::Distortion;
use analysis::uncertainty::rectangular_u;

use super::point::{self, Judged, Kept, Point};
use crate::case::Case;
use crate::kinds::response::excited::{Channel, ELEVATION, GAINS, LEVEL};
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{Reason, ResponseReason};
use crate::trace::{Plot, Scale, Series, Style};

#[cfg(test)]
mod tests;

pub(super) const PLANT_NAMES: &[&str] = &["distortion", "direct-departure"];
const PLANT_ESTIMATOR: &str = "robust-frf/1";

/// Gives back the lines that count, where points differ in the gains of the loop around the plant.
pub(super) fn evaluate_plant(point: &Point<'_>, result: &mut PointResult) -> Vec<Line> {
    let axis = &point.case.axis;
    let lines = match point.response(Channel::Torque, Channel::Rate) {
        Ok(judged) => {
            let title = format!("Torque to rate, {}", point.case.point);
            result.plots.extend(point::bode(
                &format!("plant-{}", point.slug()),
                &title,
                "rad/s/(N*m)",
                &judged,
            ));
            result.excluded.extend(judged.excluded);
            judged.lines
        }
        Err(reason) => {
            for name in PLANT_NAMES {
                let none = Measurement::inconclusive(name, axis, Q::Ratio, PLANT_ESTIMATOR, &reason);
                result.measurements.push(point.measurement(none));
            }
            return Vec::new();
        }
    };
    let counted_hz: Vec<f64> = lines.iter().map(|l| l.frequency_hz).collect();
    result.measurements.push(point.measurement(distortion(point, &counted_hz)));
    result.measurements.push(point.measurement(direct(point, &counted_hz)));
    if point.case.requested(GAINS).is_some() { lines } else { Vec::new() }
}

/// Median over the lines of what scatters between realisations more than within them, over the response.
fn distortion(point: &Point<'_>, counted_hz: &[f64]) -> Measurement {
    let axis = &point.case.axis;
    let mut lines = point.measured.distortion(Channel::Torque, Channel::Rate);
    lines.retain(|l| counted_hz.contains(&l.response.frequency_hz));
    let mut ratios: Vec<f64> =
        lines.iter().map(|l| l.nonlinear_variance.sqrt() / l.response.value.norm()).collect();
    ratios.sort_by(f64::total_cmp);
    let Some(&median) = ratios.get(ratios.len() / 2) else {
        let reason = ResponseReason::NoSharedLines;
        return Measurement::inconclusive(PLANT_NAMES[0], axis, Q::Ratio, PLANT_ESTIMATOR, reason);
    };
    let distorted = lines.iter().filter(|l| l.is_distorted()).count();
    // Quartiles of the lines as the scatter of their median: 1.253·σ/√n, σ = (q3 − q1)/1.349.
    let quartiles = ratios[3 * ratios.len() / 4] - ratios[ratios.len() / 4];
    let u = 1.253 * quartiles / 1.349 / (ratios.len() as f64).sqrt();
    let estimate = Estimate { value: median, u, dof: (ratios.len() - 1) as f64, n: ratios.len() };
    let mut flags =
        vec![format!("{distorted} of {} lines distorted at a false alarm rate of 1 %", ratios.len())];
    flags.extend(point.measured.left_out().map(left_out));
    Measurement { flags, ..Measurement::new(PLANT_NAMES[0], axis, Q::Ratio, Some(estimate), PLANT_ESTIMATOR) }
}

/// What stands at the lines that the grid leaves out.
fn left_out(found: &Distortion) -> String {
    let db = |db: Option<f64>| match db {
        Some(db) if db.is_finite() => format!("{db:.1} dB"),
        Some(_) => "in the noise".to_owned(),
        None => "none left out".to_owned(),
    };
    let odd = db(found.odd_db);
    let even = db(found.even_db);
    format!("lines left out, over the response: odd {odd}, even {even}, noise {:.1} dB", found.noise_db)
}

/// What an estimate from torque to rate without the excitation as its reference would be off by: in a closed loop the
/// noise of the plant comes back through the controller (Pintelon & Schoukens, *System Identification*, 2nd ed., §2.6).
fn direct(point: &Point<'_>, counted_hz: &[f64]) -> Measurement {
    let axis = &point.case.axis;
    let Some((worst, lines)) = point.measured.direct_departure(Channel::Torque, Channel::Rate, counted_hz)
    else {
        return Measurement::inconclusive(
            PLANT_NAMES[1],
            axis,
            Q::Ratio,
            PLANT_ESTIMATOR,
            ResponseReason::NothingToCompare,
        );
    };
    let estimate = Estimate { value: worst.departure, u: worst.u, dof: f64::INFINITY, n: lines };
    let warning = "a direct estimate in a closed loop is biased: the numbers here are joint input-output";
    let biased = worst.departure > 2.0 * worst.u;
    let mut flags = vec![format!("at {:.2} Hz", worst.frequency_hz)];
    flags.extend(biased.then(|| warning.to_owned()));
    Measurement { flags, ..Measurement::new(PLANT_NAMES[1], axis, Q::Ratio, Some(estimate), PLANT_ESTIMATOR) }
}

pub(super) const GAINS_NAME: &str = "gains-departure";
const GAINS_ESTIMATOR: &str = "gains-departure/1";

/// Lines of torque to rate that a point kept.
fn kept_lines(point: &PointResult) -> &[Line] {
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
    let measurement = match departure(kept_lines(first), kept_lines(other)) {
        Some((estimate, flags)) => Measurement {
            flags,
            ..Measurement::new(GAINS_NAME, &case.axis, Q::Ratio, Some(estimate), GAINS_ESTIMATOR)
        },
        None => {
            let reason = first.inconclusive.clone().or_else(|| other.inconclusive.clone());
            let reason = reason.unwrap_or_else(|| ResponseReason::FewInBoth.into());
            Measurement::inconclusive(GAINS_NAME, &case.axis, Q::Ratio, GAINS_ESTIMATOR, reason)
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
pub(super) fn gains_plots(cases: &[Case], points: &[PointResult]) -> Vec<Plot> {
    let series = |(case, point): &(&Case, &PointResult)| {
        let lines = kept_lines(point);
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

pub(super) const ANGLE_NAMES: &[&str] = &["apparent-inertia"];

const INERTIA: &str = "apparent-inertia/4";
/// Up to here the structure follows the shaft.
const STIFF_HZ: f64 = 5.0;
/// Half of the largest share by which flexible modes let an axis seem heavier at [`STIFF_HZ`]: J·c·ω²/(ω_n² − ω²) over all modes
/// is 3.0 % with those of elevation (17 Hz) and 0.5 % with those of azimuth (42 Hz; modes.md), 3.6 % is allowed for. The other
/// half is the half-width of a rectangular distribution.
const MODES_RATIO: f64 = 0.018;
/// The same of what the way out and back, 3.5 ms at the most, takes off there: 1 − cos ωτ is up to 0.6 %.
const LATE_RATIO: f64 = 0.003;
/// What viscous friction b adds with the same way τ: b·τ/J is up to 0.1 % (274 N·m·s/rad, 1036 kg·m², director.md); half-width of a
/// rectangular distribution.
const VISCOUS_RATIO: f64 = 0.001;

/// Torque to angle, and the inertia that it shows.
pub(super) fn evaluate_angle(point: &Point<'_>, result: &mut PointResult) {
    let mut measurement =
        angle_lines(point, result).and_then(|judged| inertia(&point.case.axis, &judged.lines));
    if let Ok(m) = &mut measurement {
        let constant = m.value.zip(point.limits.torque_constant_nm_per_a);
        m.flags.extend(constant.map(|(kg_m2, nm_per_a)| {
            format!("J/Kt {:.5} A·s²/rad, by the torque constant of the rig file", kg_m2 / nm_per_a)
        }));
    }
    let none =
        |reason| Measurement::inconclusive(ANGLE_NAMES[0], &point.case.axis, Q::Inertia, INERTIA, reason);
    result.measurements.push(point.measurement(measurement.unwrap_or_else(none)));
}

/// Lines of torque to the encoder's angle that slide, with their picture.
fn angle_lines(point: &Point<'_>, result: &mut PointResult) -> Result<Judged, Reason> {
    let judged = point.response(Channel::Torque, Channel::Angle)?;
    let id = format!("torque-to-angle-{}", point.slug());
    let title = format!("Torque to angle, {}", point.case.point);
    result.plots.extend(point::bode(&id, &title, "rad/(N*m)", &judged));
    result.excluded.extend(judged.excluded.iter().cloned());
    match judged.presliding_below_hz {
        Some(corner_hz) => Err(point::presliding(&point.measured, corner_hz).into()),
        None => Ok(judged),
    }
}

/// −Re(1/G)/ω² = J·(1 + ε·(f/f_stiff)²): friction turns by 90 degrees and does not come in; modes and delays grow with the square of
/// the frequency. Lines weigh by what they scatter; what is known of ε beforehand is one more observation, which decides where
/// few or noisy lines cannot.
fn inertia(axis: &str, lines: &[Line]) -> Result<Measurement, Reason> {
    let is_stiff = |l: &&Line| l.frequency_hz <= STIFF_HZ && l.variance > 0.0;
    let stiff: Vec<Line> = lines.iter().filter(is_stiff).copied().collect();
    let too_few = || Reason::from(ResponseReason::FewStiffLines { lines: stiff.len(), up_to_hz: STIFF_HZ });
    if stiff.len() < 3 {
        return Err(too_few());
    }
    let squared = |l: &Line| (TAU * l.frequency_hz).powi(2);
    let mut shown: Vec<f64> = stiff.iter().map(|l| -l.value.inv().re / squared(l)).collect();
    let mut weights: Vec<f64> =
        stiff.iter().map(|l| 2.0 / l.variance * (l.value.norm_sqr() * squared(l)).powi(2)).collect();
    let mut rises: Vec<f64> = stiff.iter().map(|l| (l.frequency_hz / STIFF_HZ).powi(2)).collect();
    let mut constant = vec![1.0; stiff.len()];
    let total: f64 = weights.iter().sum();
    let mean = shown.iter().zip(&weights).map(|(j, w)| j * w).sum::<f64>() / total;
    let known_u = rectangular_u(mean * MODES_RATIO.hypot(LATE_RATIO));
    shown.push(mean * (MODES_RATIO - LATE_RATIO));
    weights.push(known_u.powi(-2));
    rises.push(1.0);
    constant.push(0.0);
    let fit = LinearFit::new(&[constant, rises], &shown, Some(&weights)).map_err(|_| too_few())?;
    let value = fit.coefficients[0];
    // Of the lines alone, without the last observation.
    let square = fit.residuals.iter().zip(&weights).take(stiff.len()).map(|(r, w)| w * r * r).sum::<f64>();
    let share = (square / total).sqrt() / value.abs();
    let goodness = Goodness::of_lines(&stiff, fit.residual_variance, fit.dof).with_share(share);
    goodness.check()?;
    let scatter_u = goodness.widening() * fit.unscaled_covariance[(0, 0)].sqrt();
    let u = scatter_u.hypot(rectangular_u(VISCOUS_RATIO) * value);
    let estimate = Estimate { value, u, dof: fit.dof as f64, n: stiff.len() };
    let flags = goodness.flag().into_iter().collect();
    Ok(Measurement { flags, ..Measurement::new(ANGLE_NAMES[0], axis, Q::Inertia, Some(estimate), INERTIA) })
}
