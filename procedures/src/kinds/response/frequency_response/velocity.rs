//! The open velocity loop and its margins.

use analysis::estimate::Estimate;
use analysis::margins::{Doubt, MarginError, Margins, Nearest, NoCrossing, Settings, margins};

use super::honest::{self, Judged};
use super::pictures;
use super::point::Point;
use crate::kinds::response::excited::Channel;
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const NAMES: &[&str] = &[
    "velocity-bandwidth",
    "velocity-gain-margin",
    "velocity-phase-margin",
    "velocity-delay-margin",
    "velocity-modulus-margin",
    "velocity-disk-margin",
];
const ESTIMATOR: &str = "velocity-margins/1";
/// PI controller and inertia.
const INTEGRATORS: u32 = 1;

/// A loop whose margins are read.
pub(super) struct Loop {
    /// Measurands, in the order of [`NAMES`]: as many of them as are wanted.
    pub(super) names: &'static [&'static str],
    pub(super) title: &'static str,
    /// Poles of the open loop at 0.
    pub(super) integrators_count: u32,
    pub(super) estimator: &'static str,
}

pub(super) fn evaluate(point: &Point<'_>, result: &mut PointResult) {
    let velocity_loop = Loop {
        names: NAMES,
        title: "Open velocity loop",
        integrators_count: INTEGRATORS,
        estimator: ESTIMATOR,
    };
    evaluate_loop(&velocity_loop, point, point.response(Channel::Error, Channel::Rate), result);
}

pub(super) fn evaluate_loop(
    of: &Loop,
    point: &Point<'_>,
    judged: Result<Judged, String>,
    result: &mut PointResult,
) {
    let judged = match judged {
        Ok(judged) => judged,
        Err(reason) => return none(of, point, &reason, result),
    };
    let id = format!("loop-{}", point.slug());
    let title = format!("{}, {}", of.title, point.case.point);
    result.plots.extend(pictures::bode(&id, &title, "1", &judged));
    if let Some(corner_hz) = judged.presliding_below_hz {
        return none(of, point, &honest::presliding(&point.measured, corner_hz), result);
    }
    let settings = Settings { integrators_count: of.integrators_count, ..Settings::default() };
    match margins(&judged.lines, &settings) {
        Ok(found) => {
            let title = format!("Nyquist, {}", point.case.point);
            result.plots.push(pictures::nyquist(
                &format!("nyquist-{}", point.slug()),
                &title,
                &judged,
                &found,
            ));
            all(of, point, (&judged, &found), result);
        }
        Err(error) => none(of, point, &error.to_string(), result),
    }
}

fn none(of: &Loop, point: &Point<'_>, reason: &str, result: &mut PointResult) {
    let kinds = [Q::Frequency, Q::Decibel, Q::Angle, Q::Time, Q::Ratio, Q::Ratio];
    for (name, kind) in of.names.iter().zip(kinds) {
        let measurement = Measurement::inconclusive(name, &point.case.axis, kind, of.estimator, reason);
        result.measurements.push(point.measurement(measurement));
    }
}

/// A number of a loop: its kind, where it was read (`None` where all lines have a part in it), and itself.
type Found = (Q, Option<f64>, Result<Estimate, NoCrossing>);

fn all(of: &Loop, point: &Point<'_>, (judged, found): (&Judged, &Margins), result: &mut PointResult) {
    for (k, (name, (kind, at_hz, value))) in of.names.iter().zip(numbers(judged, found)).enumerate() {
        let axis = &point.case.axis;
        let mut measurement = match value {
            Ok(estimate) => Measurement::new(name, axis, kind, Some(estimate), of.estimator),
            Err(none) => at_most(judged, k).map_or_else(
                || {
                    let reason = MarginError::from(none).to_string();
                    Measurement::inconclusive(name, axis, kind, of.estimator, reason)
                },
                |(estimate, flag)| Measurement {
                    flags: vec![flag],
                    ..Measurement::new(name, axis, kind, Some(estimate), of.estimator)
                },
            ),
        };
        measurement.excluded = judged.excluded.clone();
        let (touching, others) = doubts(judged, found, (k == 0, at_hz));
        measurement.flags.extend(others);
        if let Some(reason) = touching.first().filter(|_| measurement.value.is_some()) {
            measurement.inconclusive = Some(reason.clone());
        }
        measurement.flags.extend(touching);
        result.measurements.push(point.measurement(measurement));
    }
}

/// Frequency, value and standard uncertainty of what [`NAMES`] says, in its order.
pub(in crate::kinds) fn readings(found: &Margins) -> [(Q, Result<[f64; 3], NoCrossing>); 6] {
    let nearest = |n: &Nearest| Ok([n.frequency_hz, n.value, n.u]);
    [
        (Q::Frequency, found.bandwidth().map(|c| [c.frequency_hz, c.frequency_hz, c.frequency_u_hz])),
        (Q::Decibel, found.gain_margin().map(|c| [c.frequency_hz, c.gain_margin_db, c.gain_margin_u_db])),
        (Q::Angle, found.phase_margin().map(|c| [c.frequency_hz, c.phase_margin_rad, c.phase_margin_u_rad])),
        (Q::Time, found.delay_margin().map(|c| [c.frequency_hz, c.delay_margin_s, c.delay_margin_u_s])),
        (Q::Ratio, nearest(&found.modulus)),
        (Q::Ratio, nearest(&found.disk.alpha)),
    ]
}

/// Numbers of a measurement, in the order of [`NAMES`].
fn numbers(judged: &Judged, found: &Margins) -> [Found; 6] {
    let n = judged.lines.len();
    let dof = honest::freedom(&judged.lines);
    readings(found).map(|(kind, reading)| {
        let at_hz = reading.as_ref().ok().map(|[hz, ..]| *hz);
        (kind, at_hz, reading.map(|[_, value, u]| Estimate { value, u, dof, n }))
    })
}

/// A loop that is below 0 dB from its lowest line on crosses below that line: an upper bound of its bandwidth.
fn at_most(judged: &Judged, number: usize) -> Option<(Estimate, String)> {
    let first = judged.lines.first().filter(|_| number == 0)?;
    let below = judged.lines.iter().all(|l| l.value.norm() * (1.0 + 2.0 * l.relative_sd()) < 1.0);
    let estimate = Estimate { value: first.frequency_hz, u: 0.0, dof: f64::INFINITY, n: judged.lines.len() };
    below.then(|| (estimate, "at most: the loop is below 0 dB at its lowest line".to_owned()))
}

/// Doubts that touch the number that was read at a frequency, and all others.
fn doubts(
    judged: &Judged,
    found: &Margins,
    (is_bandwidth, at_hz): (bool, Option<f64>),
) -> (Vec<String>, Vec<String>) {
    let beside = |from_hz: f64, to_hz: f64| at_hz.is_some_and(|hz| (from_hz..=to_hz).contains(&hz));
    let touches = |doubt: &Doubt| match *doubt {
        Doubt::CircleReachesCritical { .. } => !is_bandwidth,
        Doubt::Coherence { frequency_hz, .. } => {
            let k = judged.lines.partition_point(|l| l.frequency_hz < frequency_hz);
            let hz = |k: usize| judged.lines[k.min(judged.lines.len() - 1)].frequency_hz;
            beside(hz(k.saturating_sub(1)), hz(k + 1))
        }
        Doubt::Coarse { from_hz, to_hz, .. } => beside(from_hz, to_hz),
    };
    let told = |doubt: &Doubt| format!("not certified: {doubt}");
    let (mine, others): (Vec<Doubt>, Vec<Doubt>) = found.doubts.iter().partition(|doubt| touches(doubt));
    let across = at_hz.and_then(|hz| bridged(judged, hz));
    (mine.iter().map(told).chain(across).collect(), others.iter().map(told).collect())
}

/// A number that was read across a line that does not count.
fn bridged(judged: &Judged, hz: f64) -> Option<String> {
    let above = judged.lines.partition_point(|l| l.frequency_hz < hz);
    let low = judged.lines.get(above.checked_sub(1)?)?;
    let high = judged.lines.get(above)?;
    let gap = low.frequency_hz..high.frequency_hz;
    let hollow = judged.hollow.iter().find(|l| gap.contains(&l.frequency_hz))?;
    Some(format!(
        "not certified: read at {hz:.2} Hz across the line at {:.2} Hz, which does not count",
        hollow.frequency_hz
    ))
}

#[cfg(test)]
mod tests;
