//! Torque to the angle of the shaft.

use analysis::estimate::Estimate;
use analysis::frf::Line;

use super::honest::{self, Judged};
use super::pictures;
use super::point::Point;
use crate::kinds::response::excited::Channel;
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const NAMES: &[&str] = &["apparent-inertia"];

const INERTIA: &str = "apparent-inertia/1";
/// Up to here the structure follows (first mode of the shaft at 17 Hz: (5/17)², 9 %, of its own participation).
const STIFF_HZ: f64 = 5.0;
/// What the way out and back, 3.5 ms at the most, takes off: 1 − cos ωτ is up to 0.6 % at 5 Hz, half of it on average.
const LATE_RATIO: f64 = 3e-3;

/// Torque to angle, and the inertia that it shows.
pub(super) fn evaluate(point: &Point<'_>, result: &mut PointResult) {
    let measurement = match read(point, Channel::Torque, ("Torque to angle", "rad/(N*m)"), result) {
        Ok(judged) => inertia(&point.case.axis, &judged.lines),
        Err(reason) => Err(reason),
    };
    let none = |reason| Measurement::inconclusive(NAMES[0], &point.case.axis, Q::Inertia, INERTIA, reason);
    result.measurements.push(point.measurement(measurement.unwrap_or_else(none)));
}

/// Lines of a response to the encoder's angle that slide, with their picture.
fn read(
    point: &Point<'_>,
    from: Channel,
    (title, unit): (&str, &str),
    result: &mut PointResult,
) -> Result<Judged, String> {
    let judged = point.response(from, Channel::Angle)?;
    let id = format!("{}-{}", title.to_lowercase().replace(' ', "-"), point.slug());
    result.plots.extend(pictures::bode(&id, &format!("{title}, {}", point.case.point), unit, &judged));
    result.excluded.extend(judged.excluded.iter().cloned());
    match judged.presliding_below_hz {
        Some(corner_hz) => Err(honest::presliding(&point.measured, corner_hz)),
        None => Ok(judged),
    }
}

/// −Re(1/G)/ω²: friction turns by 90 degrees and does not come in. Weighted by what each line scatters.
fn inertia(axis: &str, lines: &[Line]) -> Result<Measurement, String> {
    let stiff = lines.iter().filter(|l| l.frequency_hz <= STIFF_HZ && l.variance > 0.0);
    let each: Vec<[f64; 2]> = stiff
        .map(|l| {
            let squared = (std::f64::consts::TAU * l.frequency_hz).powi(2);
            let u = (0.5 * l.variance).sqrt() / l.value.norm_sqr() / squared;
            [-l.value.inv().re / squared, 1.0 / (u * u)]
        })
        .collect();
    if each.len() < 3 {
        return Err(format!("{} lines up to {STIFF_HZ} Hz count, 3 are needed", each.len()));
    }
    let weight: f64 = each.iter().map(|[_, w]| w).sum();
    let value = each.iter().map(|[j, w]| j * w).sum::<f64>() / weight;
    // Lines that scatter more than they should widen it (Birge).
    let scatter = each.iter().map(|[j, w]| w * (j - value).powi(2)).sum::<f64>() / (each.len() - 1) as f64;
    let u = (scatter.max(1.0) / weight + (LATE_RATIO * value).powi(2)).sqrt();
    let estimate = Estimate { value, u, dof: (each.len() - 1) as f64, n: each.len() };
    Ok(Measurement::new(NAMES[0], axis, Q::Inertia, Some(estimate), INERTIA))
}
