//! Responses to the angle of the shaft: torque to angle, and commanded rate to angle by the encoder and by the gyro.

use super::honest::{self, Judged};
use super::pictures;
use super::point::Point;
use crate::analysis::frf::Line;
use crate::analysis::periodic::times_jw;
use crate::kinds::excited::Channel;
use crate::measurement::{Estimate, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const OF_TORQUE: &[&str] = &["apparent-inertia"];
pub(super) const OF_RATE: &[&str] = &["closed-velocity-bandwidth", "closed-velocity-peak"];

const INERTIA: &str = "apparent-inertia/1";
const CLOSED: &str = "closed-velocity-loop/1";
/// Up to here the structure follows (first mode of the shaft at 17 Hz: (5/17)², 9 %, of its own participation).
const STIFF_HZ: f64 = 5.0;
/// What the way out and back, 3.5 ms at the most, takes off: 1 − cos ωτ is up to 0.6 % at 5 Hz, half of it on average.
const LATE_RATIO: f64 = 3e-3;
const DB_PER_NEPER: f64 = 8.685_889_638;
/// Bandwidth is read where the gain has fallen by this.
const FALLEN_DB: f64 = -3.0;

/// Torque to angle, and the inertia that it shows.
pub(super) fn of_torque(point: &Point<'_>, result: &mut PointResult) {
    let measurement = match read(point, Channel::Torque, ("Torque to angle", "rad/(N*m)"), result) {
        Ok(judged) => inertia(&point.case.axis, &judged.lines),
        Err(reason) => Err(reason),
    };
    let none =
        |reason| Measurement::inconclusive(OF_TORQUE[0], &point.case.axis, Q::Inertia, INERTIA, reason);
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
    Ok(Measurement::new(OF_TORQUE[0], axis, Q::Inertia, Some(estimate), INERTIA))
}

/// Commanded rate to angle: how far the closed velocity loop follows, and how much it overdoes.
pub(super) fn of_rate(point: &Point<'_>, result: &mut PointResult) {
    let axis = &point.case.axis;
    let lines = read(point, Channel::Commanded, ("Velocity command to angle", "s"), result)
        .and_then(|judged| times_jw(&judged.lines, 1).map_err(|e| e.to_string()));
    by_gyro(point, result);
    let (bandwidth, peak) = match &lines {
        Ok(lines) => (bandwidth(lines), peak(lines)),
        Err(reason) => (Err(reason.clone()), Err(reason.clone())),
    };
    for ((name, kind), found) in OF_RATE.iter().zip([Q::Frequency, Q::Decibel]).zip([bandwidth, peak]) {
        let measurement = match found {
            Ok((estimate, flag)) => Measurement {
                flags: vec![flag],
                ..Measurement::new(name, axis, kind, Some(estimate), CLOSED)
            },
            Err(reason) => Measurement::inconclusive(name, axis, kind, CLOSED, reason),
        };
        result.measurements.push(point.measurement(measurement));
    }
}

/// The same angle by the gyro, integrated: what differs between the pictures lies between the sensors.
fn by_gyro(point: &Point<'_>, result: &mut PointResult) {
    let Ok(judged) = point.response(Channel::Commanded, Channel::Rate) else { return };
    let (Ok(lines), Ok(hollow)) = (times_jw(&judged.lines, -1), times_jw(&judged.hollow, -1)) else { return };
    let title = format!("Velocity command to angle by the gyro, {}", point.case.point);
    let id = format!("velocity-command-to-gyro-angle-{}", point.slug());
    result.plots.extend(pictures::bode(&id, &title, "s", &Judged { lines, hollow, ..judged }));
}

/// First fall below −3 dB. Between the two lines around it gain over the logarithm of frequency is a cubic through four
/// lines; half of what that differs from a straight line counts as uncertainty.
fn bandwidth(lines: &[Line]) -> Result<(Estimate, String), String> {
    let above = |l: &Line| l.gain_db() >= FALLEN_DB;
    let Some(at) = lines.windows(2).position(|pair| above(&pair[0]) && !above(&pair[1])) else {
        return Err("the gain of the closed loop does not fall below -3 dB in the band".to_owned());
    };
    let (before, after) = (&lines[at], &lines[at + 1]);
    let [low, high] = [before, after].map(|l| l.frequency_hz.ln());
    let per_db = (high - low) / (after.gain_db() - before.gain_db());
    let straight = (low + per_db * (FALLEN_DB - before.gain_db())).exp();
    let near = &lines[at.saturating_sub(1)..(at + 3).min(lines.len())];
    let value = fall(near, [low, high]).exp();
    let u_db = DB_PER_NEPER * before.relative_sd().max(after.relative_sd());
    let u = (value * per_db.abs() * u_db).hypot(0.5 * (value - straight));
    let estimate = Estimate { value, u, dof: 2.0 * before.dof.min(after.dof), n: lines.len() };
    Ok((estimate, format!("between {:.2} and {:.2} Hz", before.frequency_hz, after.frequency_hz)))
}

/// Logarithm of the frequency at which the polynomial through some lines is at −3 dB, between two of them.
fn fall(near: &[Line], [mut low, mut high]: [f64; 2]) -> f64 {
    let at = |x: f64| -> f64 {
        let term = |k: usize| {
            let others = near.iter().enumerate().filter(|(j, _)| *j != k);
            let own = near[k].frequency_hz.ln();
            let share = others.map(|(_, l)| (x - l.frequency_hz.ln()) / (own - l.frequency_hz.ln()));
            near[k].gain_db() * share.product::<f64>()
        };
        (0..near.len()).map(term).sum()
    };
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if at(middle) >= FALLEN_DB { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Largest gain of all lines.
fn peak(lines: &[Line]) -> Result<(Estimate, String), String> {
    let top = lines.iter().max_by(|a, b| a.gain_db().total_cmp(&b.gain_db())).ok_or("no line counts")?;
    let u = DB_PER_NEPER * top.relative_sd();
    let estimate = Estimate { value: top.gain_db(), u, dof: 2.0 * top.dof, n: lines.len() };
    Ok((estimate, format!("at {:.2} Hz", top.frequency_hz)))
}
