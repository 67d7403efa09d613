//! Torque to rate: what the controller has to do with, and how linear it is.

use analysis::estimate::Estimate;
use analysis::frf::Line;
use analysis::periodic::Distortion;

use super::pictures;
use super::point::Point;
use crate::kinds::response::excited::{Channel, GAINS};
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const NAMES: &[&str] = &["distortion", "direct-departure"];
const ESTIMATOR: &str = "robust-frf/1";

/// Gives back the lines that count, where points differ in the gains of the loop around the plant.
pub(super) fn evaluate(point: &Point<'_>, result: &mut PointResult) -> Vec<Line> {
    let axis = &point.case.axis;
    let lines = match point.response(Channel::Torque, Channel::Rate) {
        Ok(judged) => {
            let title = format!("Torque to rate, {}", point.case.point);
            result.plots.extend(pictures::bode(
                &format!("plant-{}", point.slug()),
                &title,
                "rad/s/(N*m)",
                &judged,
            ));
            result.excluded.extend(judged.excluded);
            judged.lines
        }
        Err(reason) => {
            for name in NAMES {
                let none = Measurement::inconclusive(name, axis, Q::Ratio, ESTIMATOR, reason.as_str());
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
        let reason = "no lines that two realisations with other phases share: ask for four or more, with random phases";
        return Measurement::inconclusive(NAMES[0], axis, Q::Ratio, ESTIMATOR, reason);
    };
    let distorted = lines.iter().filter(|l| l.is_distorted()).count();
    // Quartiles of the lines as the scatter of their median: 1.253·σ/√n, σ = (q3 − q1)/1.349.
    let quartiles = ratios[3 * ratios.len() / 4] - ratios[ratios.len() / 4];
    let u = 1.253 * quartiles / 1.349 / (ratios.len() as f64).sqrt();
    let estimate = Estimate { value: median, u, dof: (ratios.len() - 1) as f64, n: ratios.len() };
    let mut flags = vec![format!("{distorted} of {} lines distorted at 1 % of false alarms", ratios.len())];
    flags.extend(point.measured.left_out().map(left_out));
    Measurement { flags, ..Measurement::new(NAMES[0], axis, Q::Ratio, Some(estimate), ESTIMATOR) }
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
        return Measurement::inconclusive(NAMES[1], axis, Q::Ratio, ESTIMATOR, "no line to compare");
    };
    let estimate = Estimate { value: worst.departure, u: worst.u, dof: f64::INFINITY, n: lines };
    let warning = "a direct estimate in a closed loop is biased: the numbers here are joint input-output";
    let biased = worst.departure > 2.0 * worst.u;
    let mut flags = vec![format!("at {:.2} Hz", worst.frequency_hz)];
    flags.extend(biased.then(|| warning.to_owned()));
    Measurement { flags, ..Measurement::new(NAMES[1], axis, Q::Ratio, Some(estimate), ESTIMATOR) }
}
