//! Loops of velocity, track and current: open with their margins, closed with their peak.

use analysis::estimate::Estimate;
use analysis::frf::{Frf, Line};
use analysis::lag::{self, LagFit, Order, current_loop};
use analysis::margins::{self, Doubt, MarginError, Margins, Nearest, NoCrossing, Settings, margins};
use analysis::periodic::times_jw;
use analysis::uncertainty::{Component, combine};

use super::point::{self, Judged, Point};
use crate::kinds::response::excited::Channel;
use crate::measurement::{Bound, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{Reason, ResponseReason};

#[cfg(test)]
mod tests;

pub(super) const VELOCITY_NAMES: &[&str] = &[
    "velocity-bandwidth",
    "velocity-gain-margin",
    "velocity-phase-margin",
    "velocity-delay-margin",
    "velocity-modulus-margin",
    "velocity-disk-margin",
];
const VELOCITY_ESTIMATOR: &str = "velocity-margins/2";
/// PI controller and inertia.
const VELOCITY_INTEGRATORS: u32 = 1;

/// A loop whose margins are read.
pub(super) struct Loop {
    /// Measurands, in the order of [`NAMES`]: as many of them as are wanted.
    pub(super) names: &'static [&'static str],
    pub(super) title: &'static str,
    /// Poles of the open loop at 0.
    pub(super) integrators_count: u32,
    pub(super) estimator: &'static str,
}

pub(super) fn evaluate_velocity(point: &Point<'_>, result: &mut PointResult) {
    let velocity_loop = Loop {
        names: VELOCITY_NAMES,
        title: "Open velocity loop",
        integrators_count: VELOCITY_INTEGRATORS,
        estimator: VELOCITY_ESTIMATOR,
    };
    evaluate_loop(&velocity_loop, point, point.response(Channel::Error, Channel::Rate), result);
}

fn evaluate_loop(of: &Loop, point: &Point<'_>, judged: Result<Judged, Reason>, result: &mut PointResult) {
    let judged = match judged {
        Ok(judged) => judged,
        Err(reason) => return none(of, point, &reason, result),
    };
    let id = format!("loop-{}", point.slug());
    let title = format!("{}, {}", of.title, point.case.point);
    result.plots.extend(point::bode(&id, &title, "1", &judged));
    if let Some(corner_hz) = judged.presliding_below_hz {
        return none(of, point, &point::presliding(&point.measured, corner_hz).into(), result);
    }
    let settings = Settings { integrators_count: of.integrators_count, ..Settings::default() };
    match margins(&judged.lines, &settings) {
        Ok(found) => {
            let title = format!("Nyquist, {}", point.case.point);
            result.plots.push(point::nyquist(&format!("nyquist-{}", point.slug()), &title, &judged, &found));
            all(of, point, &judged, &found, result);
        }
        Err(error) => none(of, point, &error.into(), result),
    }
}

fn none(of: &Loop, point: &Point<'_>, reason: &Reason, result: &mut PointResult) {
    let kinds = [Q::Frequency, Q::Decibel, Q::Angle, Q::Time, Q::Ratio, Q::Ratio];
    for (name, kind) in of.names.iter().zip(kinds) {
        let measurement = Measurement::inconclusive(name, &point.case.axis, kind, of.estimator, reason);
        result.measurements.push(point.measurement(measurement));
    }
}

/// A number of a loop: its kind, where it was read (`None` where all lines have a part in it), and itself.
type Found = (Q, Option<f64>, Result<Estimate, NoCrossing>);

fn all(of: &Loop, point: &Point<'_>, judged: &Judged, found: &Margins, result: &mut PointResult) {
    for (k, (name, (kind, at_hz, value))) in of.names.iter().zip(numbers(judged, found)).enumerate() {
        let axis = &point.case.axis;
        let value = value.map(|estimate| match (kind, point.varies) {
            (Q::Decibel, true) => with_variation(estimate),
            _ => estimate,
        });
        let mut measurement = match value {
            Ok(estimate) => Measurement::new(name, axis, kind, Some(estimate), of.estimator),
            Err(none) => at_most(judged, k).map_or_else(
                || {
                    let reason = MarginError::from(none).to_string();
                    Measurement::inconclusive(name, axis, kind, of.estimator, reason)
                },
                |(estimate, bound)| {
                    let mut bounded = Measurement::new(name, axis, kind, Some(estimate), of.estimator);
                    bounded.set_bound(bound);
                    bounded
                },
            ),
        };
        measurement.excluded = judged.excluded.clone();
        let (touching, others) = doubts(judged, found, k == 0, at_hz);
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
    let dof = point::freedom(&judged.lines);
    readings(found).map(|(kind, reading)| {
        let at_hz = reading.as_ref().ok().map(|[hz, ..]| *hz);
        (kind, at_hz, reading.map(|[_, value, u]| Estimate { value, u, dof, n }))
    })
}

/// Half-width of what a response that was measured over strokes may differ from the mean over the plants along them, as a ratio of its
/// gain. The strokes of elevation pass 4 deg, over which its modes move. Beside the linear model of drawn units gain margins read 0.07 dB
/// too large on the mean, at the most 0.17 dB (2 %), where their lines alone say 0.02 dB.
const VARIATION_RATIO: f64 = 0.02;

/// A gain margin whose plant differs along the strokes.
fn with_variation(margin_db: Estimate) -> Estimate {
    let half_width_db = 20.0 * (1.0 + VARIATION_RATIO).log10();
    let own = Component { u: margin_db.u, dof: margin_db.dof };
    let combined = combine(&[own, Component::rectangular(half_width_db)]);
    Estimate { u: combined.u, dof: combined.dof, ..margin_db }
}

/// A loop that is below 0 dB from its lowest line on crosses below that line: an upper bound of its bandwidth.
fn at_most(judged: &Judged, number: usize) -> Option<(Estimate, Bound)> {
    let first = judged.lines.first().filter(|_| number == 0)?;
    let below = judged.lines.iter().all(|l| l.value.norm() * (1.0 + 2.0 * l.relative_sd()) < 1.0);
    let estimate = Estimate { value: first.frequency_hz, u: 0.0, dof: f64::INFINITY, n: judged.lines.len() };
    below.then(|| (estimate, Bound::AtMost("the loop is below 0 dB at its lowest line".to_owned())))
}

/// Doubts that touch the number that was read at a frequency, and all others.
fn doubts(
    judged: &Judged,
    found: &Margins,
    is_bandwidth: bool,
    at_hz: Option<f64>,
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

pub(super) const TRACK_NAMES: &[&str] = &["track-bandwidth", "track-gain-margin", "track-phase-margin"];
/// PI controller, and the angle that the rate becomes.
const TRACK_INTEGRATORS: u32 = 2;

/// The open coarse track loop: what the tracker asks for over the command with the excitation, turned round (modes.md, 6:
/// injection at the velocity command).
pub(super) fn evaluate_track(point: &Point<'_>, result: &mut PointResult) {
    let turned = |lines: Vec<Line>| lines.into_iter().map(|l| Line { value: -l.value, ..l }).collect();
    let judged = point.response(Channel::Commanded, Channel::Asked);
    let judged = judged.map(|j| Judged { lines: turned(j.lines), hollow: turned(j.hollow), ..j });
    let track_loop = Loop {
        names: TRACK_NAMES,
        title: "Open coarse track loop",
        integrators_count: TRACK_INTEGRATORS,
        estimator: "track-margins/1",
    };
    evaluate_loop(&track_loop, point, judged, result);
}

pub(super) const CLOSED_NAMES: &[&str] = &[
    "closed-velocity-bandwidth",
    "closed-velocity-peak",
    "closed-velocity-bandwidth-gyro",
    "closed-velocity-peak-gyro",
];
const CLOSED_ESTIMATOR: &str = "closed-velocity-loop/3";
/// The controller integrates: at the lowest frequencies the rate is the commanded one.
const STATIC_GAIN: f64 = 1.0;

/// The peak is read from lines up to here, below the first mode of the frame (10 Hz) and of the shaft (17 Hz).
const STIFF_HZ: f64 = 8.0;

/// A sensor that shows the angle: name, channel, how often that is to be integrated, and its measurands.
const SENSORS: [(&str, Channel, i32, [&str; 2]); 2] = [
    ("encoder", Channel::Angle, 0, [CLOSED_NAMES[0], CLOSED_NAMES[1]]),
    ("gyro", Channel::Rate, 1, [CLOSED_NAMES[2], CLOSED_NAMES[3]]),
];

pub(super) fn evaluate_closed(point: &Point<'_>, result: &mut PointResult) {
    for (sensor, channel, integrals, names) in SENSORS {
        let closed = closed_lines(point, sensor, channel, integrals, result);
        let kinds = [Q::Frequency, Q::Decibel];
        for (k, (name, kind)) in names.into_iter().zip(kinds).enumerate() {
            let found = closed.as_deref().map_err(Clone::clone).and_then(|lines| {
                let found = if k == 0 { closed_bandwidth(lines) } else { closed_peak(lines) };
                found.map_err(Reason::from)
            });
            let axis = &point.case.axis;
            let measurement = match found {
                Ok((estimate, flags)) => Measurement {
                    flags,
                    ..Measurement::new(name, axis, kind, Some(estimate), CLOSED_ESTIMATOR)
                },
                Err(reason) => Measurement::inconclusive(name, axis, kind, CLOSED_ESTIMATOR, reason),
            };
            result.measurements.push(point.measurement(measurement));
        }
    }
}

/// Lines of the closed loop that count; pictures show the response to the angle itself.
fn closed_lines(
    point: &Point<'_>,
    sensor: &str,
    channel: Channel,
    integrals: i32,
    result: &mut PointResult,
) -> Result<Frf, Reason> {
    let judged = point.response(Channel::Commanded, channel)?;
    let times = |lines: &Frf, n| times_jw(lines, n).map_err(Reason::from);
    let angle = Judged {
        lines: times(&judged.lines, -integrals)?,
        hollow: times(&judged.hollow, -integrals)?,
        ..judged.clone()
    };
    let id = format!("velocity-command-to-angle-{sensor}-{}", point.slug());
    let title = format!("Velocity command to angle by the {sensor}, {}", point.case.point);
    result.plots.extend(point::bode(&id, &title, "s", &angle));
    result.excluded.extend(judged.excluded);
    match judged.presliding_below_hz {
        Some(corner_hz) => Err(point::presliding(&point.measured, corner_hz).into()),
        None => times(&angle.lines, 1),
    }
}

fn closed_bandwidth(lines: &[Line]) -> Result<(Estimate, Vec<String>), MarginError> {
    let found = margins::bandwidth(lines, Some(STATIC_GAIN))?;
    let value = found.frequency_hz;
    let u = found.u_hz;
    Ok((Estimate { value, u, dof: point::freedom(lines), n: lines.len() }, Vec::new()))
}

fn closed_peak(lines: &[Line]) -> Result<(Estimate, Vec<String>), MarginError> {
    let found = margins::peak(lines, STIFF_HZ)?;
    let value = found.gain_db;
    let u = found.gain_u_db;
    let estimate = Estimate { value, u, dof: point::freedom(lines), n: lines.len() };
    let at = format!("at {:.2} Hz", found.frequency_hz);
    let flags = std::iter::once(at).chain(found.goodness.flag()).collect();
    Ok((estimate, flags))
}

pub(super) const CURRENT_NAME: &str = "current-bandwidth";
const CURRENT_ESTIMATOR: &str = "current-loop-lag/1";
/// Below this loop rate a bandwidth around 1 kHz lies beyond what the samples can show (director.md, CUR-BW).
const LEAST_LOOP_RATE_HZ: f64 = 4000.0;
/// No current loop answers later than this.
const MOST_DELAY_S: f64 = 0.02;

pub(super) fn evaluate_current(point: &Point<'_>, result: &mut PointResult) {
    let axis = &point.case.axis;
    let measurement = match fit_current(point, result) {
        Ok((fit, lines)) => current_measurement(axis, &fit, lines),
        Err(reason) => Measurement::inconclusive(CURRENT_NAME, axis, Q::Frequency, CURRENT_ESTIMATOR, reason),
    };
    result.measurements.push(point.measurement(measurement));
}

/// The fitted loop, and how many lines it rests on. Friction has no part in it, so presliding does not matter.
fn fit_current(point: &Point<'_>, result: &mut PointResult) -> Result<(LagFit, usize), Reason> {
    let rate_hz = point.limits.loop_rate_hz;
    if rate_hz < LEAST_LOOP_RATE_HZ {
        return Err(ResponseReason::SlowLoop { rate_hz, least_hz: LEAST_LOOP_RATE_HZ }.into());
    }
    let judged = point.response_while_holding(Channel::Torque, Channel::Shown)?;
    let title = format!("Current loop with hold and transport, {}", point.case.point);
    result.plots.extend(point::bode(&format!("current-{}", point.slug()), &title, "1", &judged));
    let with = |order| {
        let settings = lag::Settings { period_s: 1.0 / rate_hz, order, most_delay_s: MOST_DELAY_S };
        current_loop(&judged.lines, &settings).map_err(Reason::from)
    };
    let first = with(Order::First)?;
    let fit = if first.misfit { with(Order::Second)? } else { first };
    if fit.misfit {
        let [first, second] = [first, fit].map(|fit| fit.goodness.ratio().unwrap_or(f64::INFINITY));
        return Err(ResponseReason::NoLag { first, second }.into());
    }
    Ok((fit, judged.lines.len()))
}

fn current_measurement(axis: &str, fit: &LagFit, n: usize) -> Measurement {
    let estimate = Estimate { value: fit.corner_hz, u: fit.corner_u_hz, dof: f64::INFINITY, n };
    let us = |s: f64| 1e6 * s;
    Measurement {
        flags: vec![
            format!("hold {:.0} us and transport {:.1} us removed", us(fit.hold_s), us(fit.transport_s)),
            format!("gain {:.4}", fit.gain),
            match fit.damping {
                Some([zeta, _]) => format!("second order, damping ratio {zeta:.3}"),
                None => "first order".to_owned(),
            },
        ],
        ..Measurement::new(CURRENT_NAME, axis, Q::Frequency, Some(estimate), CURRENT_ESTIMATOR)
    }
}
