//! Whether gyro and encoder see the same motion: between sensors 1300 mm apart lies structure.

use analysis::estimate::Estimate;
use analysis::frf::Line;
use analysis::periodic::times_jw;

use super::point::Point;
use crate::kinds::response::excited::Channel;
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const NAME: &str = "sensor-coaxiality";
const ESTIMATOR: &str = "sensor-coaxiality/1";
/// Up to here the structure is stiff enough to be looked through (first mode at 10 Hz, ζ 0.1).
const STIFF_HZ: f64 = 5.0;

/// Lines that scatter more than this would only show their noise.
const SHARP: f64 = 0.005;

pub(super) fn evaluate(point: &Point<'_>, result: &mut PointResult) {
    let axis = &point.case.axis;
    let measurement = match lines(point) {
        Ok(lines) => worst(axis, &lines),
        Err(reason) => Measurement::inconclusive(NAME, axis, Q::Ratio, ESTIMATOR, reason),
    };
    result.measurements.push(point.measurement(measurement));
}

/// Gyro over jω times encoder, both as old as each other: what is common to their delays has gone.
fn lines(point: &Point<'_>) -> Result<Vec<Line>, String> {
    let judged = point.response(Channel::Angle, Channel::Rate)?;
    let lines = times_jw(&judged.lines, -1).map_err(|e| e.to_string())?;
    let sharp = |l: &Line| l.frequency_hz <= STIFF_HZ && l.relative_sd() < SHARP;
    Ok(lines.into_iter().filter(sharp).collect())
}

fn worst(axis: &str, lines: &[Line]) -> Measurement {
    let departure = |l: &Line| (l.value.norm() - 1.0).abs();
    let Some(line) = lines.iter().max_by(|a, b| departure(a).total_cmp(&departure(b))) else {
        let reason = format!("no line below {STIFF_HZ} Hz counts");
        return Measurement::inconclusive(NAME, axis, Q::Ratio, ESTIMATOR, reason);
    };
    let u = (0.5 * line.variance).sqrt();
    let estimate = Estimate { value: departure(line), u, dof: 2.0 * line.dof, n: lines.len() };
    let late_s = -line.value.arg() / (std::f64::consts::TAU * line.frequency_hz);
    Measurement {
        flags: vec![
            format!("at {:.2} Hz", line.frequency_hz),
            format!("gyro {:+.2} ms after the encoder", 1e3 * late_s),
        ],
        ..Measurement::new(NAME, axis, Q::Ratio, Some(estimate), ESTIMATOR)
    }
}
