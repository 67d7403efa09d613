//! One point: the sine in commands and readings; all points: what they prove for procedures that close the fine loop.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use analysis::estimate::Estimate;
use analysis::frf::Line;
use analysis::uncertainty::{Component, combine};

use super::keys::{BLOCK_PERIODS, Keys, LEAD_S, SINE};
use super::{COUPLING, DEPARTURE, GAIN};
use crate::case::Case;
use crate::device::MIRROR_AXES;
use crate::kinds::optics::frames::{
    Blocks, Course, FINE_TOPIC, Frames, MIRROR_TOPIC, READINGS, SIGHT_GATE, moved_axis, sensed,
};
use crate::log::Window;
use crate::measurement::{Condition, Evidence, Measurement, PointResult, Proof, Reduced};
use crate::quantity::QuantityKind as Q;
use crate::reason::{OpticsReason, Reason};
use crate::trace::{Plot, Scale, Series, Style};

const ESTIMATOR: &str = "optical-gain/1";
/// A reading that stands out of its scatter by less says nothing.
const LEAST_RATIO: f64 = 10.0;
/// A command that is smaller than this part of what was asked for was cut off.
const CUT_OFF_RATIO: f64 = 0.98;
/// Readings over commands for the picture: at most so many.
const SHOWN: usize = 400;
/// How far the line of sight turns per tilt of the mirror, signed.
pub(super) struct Sensed {
    /// In the axis in which the mirror is tilted.
    pub(super) own: f64,
    /// In the other axis.
    pub(super) other: f64,
    /// Some commands of the mirror with the readings of the same times.
    pub(super) sight: Vec<Sight>,
}

/// A command of the mirror and the reading of the fine tracker at the same time.
pub(super) struct Sight {
    pub(super) command_rad: f64,
    pub(super) reading_rad: f64,
}

/// What a point says.
struct Found {
    /// Reading over command in the mirror's own axis and in the other one.
    own: Line,
    other: Line,
    blocks: usize,
    rate_hz: f64,
    amplitude_rad: f64,
    lost_ratio: f64,
    span_s: [f64; 2],
    sight: Vec<Sight>,
}

/// Reduces and measures one point.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window) -> PointResult {
    let mut result = PointResult::of(case);
    let found = found(keys, case, window);
    match found.as_ref().map_err(Clone::clone).and_then(|found| measured(keys, case, found)) {
        Ok(all) => result.measurements = all,
        Err(reason) => {
            result.measurements = [GAIN, DEPARTURE, COUPLING]
                .map(|name| none(name, case, found.as_ref().ok(), &reason))
                .to_vec();
            result.inconclusive = Some(reason);
        }
    }
    if let Ok(found) = found {
        let signed = |line: Line| -line.value.norm().copysign(line.value.re);
        result.reduced =
            Reduced::to(Sensed { own: signed(found.own), other: signed(found.other), sight: found.sight });
    }
    result
}

fn found(keys: &Keys, case: &Case, window: &Window) -> Result<Found, Reason> {
    let axis = moved_axis(case).ok_or(OpticsReason::NoMirrorAxis)?;
    let span = window.segment(case, SINE)?;
    let start_s = span.start_s + LEAD_S;
    let frames = Frames::read(window, FINE_TOPIC, span.start_s, span.end_s)?;
    frames.check_rate(case.requested("frame-rate").unwrap_or(frames.rate_hz))?;
    let name = format!("command_{}_rad", MIRROR_AXES[axis]);
    let command = Course::of(window, MIRROR_TOPIC, &name)?;
    let block_s = BLOCK_PERIODS / keys.frequency_hz;
    let count = (keys.duration_s / block_s + 1e-9).floor() as usize;
    let blocks = Blocks { start_s, block_s, count, frequency_hz: keys.frequency_hz };
    let found = sensed(command, &frames, &blocks)?;
    let amplitude_rad = found.amplitude;
    let asked_rad = case.requested("amplitude").unwrap_or(0.0);
    if amplitude_rad < CUT_OFF_RATIO * asked_rad {
        return Err(
            OpticsReason::CutOff { found_urad: 1e6 * amplitude_rad, asked_urad: 1e6 * asked_rad }.into()
        );
    }
    Ok(Found {
        own: found.readings[axis],
        other: found.readings[1 - axis],
        blocks: count,
        rate_hz: frames.rate_hz,
        amplitude_rad,
        lost_ratio: frames.lost_ratio(),
        span_s: [start_s, span.end_s],
        sight: sight(command, &frames, axis, start_s),
    })
}

/// Commands with the readings of the same times.
fn sight(command: Course<'_>, frames: &Frames, axis: usize, from_s: f64) -> Vec<Sight> {
    let all = frames.exposure_s.iter().zip(&frames.error_rad[axis]).filter(|(t, _)| **t >= from_s);
    let step = (frames.exposure_s.len() / SHOWN).max(1);
    let seen = |(&time_s, &reading_rad)| Some(Sight { command_rad: command.at(time_s)?, reading_rad });
    all.step_by(step).filter_map(seen).collect()
}

fn measured(keys: &Keys, case: &Case, found: &Found) -> Result<Vec<Measurement>, Reason> {
    let axis = moved_axis(case).unwrap_or(0);
    let sight_per_mirror = -found.own.value;
    let size = sight_per_mirror.norm();
    // Scatter of the mean along and across it: half of the variance each.
    let u_ratio = (0.5 * found.own.variance).sqrt() / size;
    if size <= 0.0 || u_ratio * LEAST_RATIO > 1.0 {
        return Err(OpticsReason::NotSeenInAxis {
            size,
            scatter: (0.5 * found.own.variance).sqrt(),
            other: found.other.value.norm(),
            expected: 1.0 / keys.gains_ratio[axis].abs(),
        }
        .into());
    }
    let phase = sight_per_mirror.arg();
    let sign = if phase.abs() < FRAC_PI_4 {
        1.0
    } else if phase.abs() > PI - FRAC_PI_4 {
        -1.0
    } else {
        return Err(OpticsReason::SignUncertain { degrees: phase.to_degrees() }.into());
    };
    let scatter = Component { u: u_ratio, dof: 2.0 * (found.blocks as f64 - 1.0) };
    let total = combine(&[scatter, Component::known(keys.scale_u_ratio)]);
    let gain = sign / size;
    let expected = keys.gains_ratio[axis];
    let u = gain.abs() * total.u;
    let estimate = |value, u| Estimate { value, u, dof: total.dof, n: found.blocks };
    let lag = if sign > 0.0 { -phase } else { PI - phase.abs() };
    let lag_ms = 1e3 * lag / (TAU * keys.frequency_hz);
    let mut all = vec![
        (GAIN, estimate(gain, u)),
        (DEPARTURE, estimate(gain / expected - 1.0, u / expected.abs())),
        (COUPLING, coupling(found)),
    ]
    .into_iter()
    .map(|(name, estimate)| {
        let axis = MIRROR_AXES[axis];
        complete(Measurement::new(name, axis, Q::Ratio, Some(estimate), ESTIMATOR), case, Some(found))
    })
    .collect::<Vec<_>>();
    all[0].flags.push(format!("reading {lag_ms:.2} ms behind the command"));
    Ok(all)
}

/// Reading in the other axis over that in the own one; its scatter makes it larger than it is, not smaller.
fn coupling(found: &Found) -> Estimate {
    let value = found.other.value.norm() / found.own.value.norm();
    let u = (0.5 * found.other.variance).sqrt() / found.own.value.norm();
    Estimate { value, u, dof: 2.0 * (found.blocks as f64 - 1.0), n: found.blocks }
}

fn none(name: &str, case: &Case, found: Option<&Found>, reason: &Reason) -> Measurement {
    let axis = moved_axis(case).map_or("", |axis| MIRROR_AXES[axis]);
    complete(Measurement::inconclusive(name, axis, Q::Ratio, ESTIMATOR, reason), case, found)
}

fn complete(mut m: Measurement, case: &Case, found: Option<&Found>) -> Measurement {
    m.point = Some(case.point.clone());
    m.conditions = Condition::reached(case, |asked| {
        found.map(|f| if asked.name == "amplitude" { f.amplitude_rad } else { f.rate_hz })
    });
    let Some(found) = found else { return m };
    if found.lost_ratio > 0.005 {
        m.flags.push(format!("{:.0} % of the frames lost", 100.0 * found.lost_ratio));
    }
    let command = format!("{MIRROR_TOPIC} command_{}_rad", m.axis);
    let readings = READINGS.map(|name| format!("{FINE_TOPIC} {name}"));
    let channels = [command].into_iter().chain(readings).collect();
    m.evidence.push(Evidence::new(channels, found.span_s));
    m
}

/// Gains within a factor of two leave a fine loop stable; how near they must be is for a requirement to say.
const SIZE: [f64; 2] = [0.5, 2.0];
/// More of the motion than this in the other axis of the camera is a camera that is turned.
const TURNED: f64 = 0.5;

/// One sentence for each fault of each axis; no fault proves it. Where an axis was not seen at all there is no proof, and a
/// remark says why.
pub(super) fn proof(keys: &Keys, cases: &[Case], points: &[PointResult]) -> (Option<Proof>, Vec<String>) {
    let all: Vec<(&Case, &PointResult)> = cases.iter().zip(points).collect();
    let mut faults = Vec::new();
    let mut unproven = Vec::new();
    for (axis, name) in MIRROR_AXES.iter().enumerate() {
        let mine: Vec<&PointResult> =
            all.iter().filter(|(case, _)| moved_axis(case) == Some(axis)).map(|(_, point)| *point).collect();
        faults.extend(mine.iter().find_map(|point| fault(keys, axis, point)));
        let unsure =
            |point: &PointResult| point.inconclusive.is_some() || point.reduced.get::<Sensed>().is_none();
        let missing = mine.iter().find(|point| unsure(point));
        let why = missing.map(|point| {
            point.inconclusive.as_ref().map_or_else(|| "it was not measured".to_owned(), Reason::to_string)
        });
        let why = if mine.is_empty() { Some("no point moved the mirror".to_owned()) } else { why };
        unproven.extend(why.map(|why| format!("sign of mirror {name} is not proven: {why}")));
    }
    let is_known = !faults.is_empty() || unproven.is_empty();
    (is_known.then(|| Proof { gate: SIGHT_GATE.to_owned(), faults }), unproven)
}

fn fault(keys: &Keys, axis: usize, point: &PointResult) -> Option<String> {
    let name = MIRROR_AXES[axis];
    let expected = 1.0 / keys.gains_ratio[axis];
    let &Sensed { own, other, .. } = point.reduced.get()?;
    if own.abs() < TURNED * expected.abs() && other.abs() > TURNED * expected.abs() {
        return Some(format!(
            "camera axes: tilt of the mirror in {name} moves the image by {other:+.3} in the other axis \
             and by {own:+.3} in its own, expected 0 and {expected:+.3}; the camera is turned, or its axes \
             are exchanged in the rig file"
        ));
    }
    let ratio = own / expected;
    // The sign of what hardly moves is that of its noise.
    if !(SIZE[0]..=SIZE[1]).contains(&ratio.abs()) {
        return Some(format!(
            "optical gain of {name}: the line of sight moves by {own:+.3} per tilt of the mirror, expected \
             {expected:+.3}; mirror not driven, optics of another magnification, or a wrong scale of \
             mirror or camera"
        ));
    }
    (ratio < 0.0).then(|| {
        format!(
            "optical sign of {name}: the line of sight moves the wrong way, {own:+.3} per tilt of the \
             mirror, expected {expected:+.3}; a fold in the optics, or a wrong sign of mirror or camera"
        )
    })
}

const MICRO: f64 = 1e6;

/// One picture of the sight for each axis of the mirror, one of the departures.
pub(super) fn pictures(keys: &Keys, cases: &[Case], points: &[PointResult]) -> Vec<Plot> {
    let all: Vec<(&Case, &PointResult)> = cases.iter().zip(points).collect();
    let mut plots: Vec<Plot> =
        (0..MIRROR_AXES.len()).filter_map(|axis| sight_plot(keys, axis, &all)).collect();
    plots.extend(departures(&all));
    plots
}

fn sight_plot(keys: &Keys, axis: usize, all: &[(&Case, &PointResult)]) -> Option<Plot> {
    let name = MIRROR_AXES[axis];
    let mut series: Vec<Series> = Vec::new();
    let mut most: f64 = 0.0;
    for (case, point) in all.iter().filter(|(case, _)| moved_axis(case) == Some(axis)) {
        let Some(sensed) = point.reduced.get::<Sensed>() else { continue };
        let x: Vec<f64> = sensed.sight.iter().map(|seen| MICRO * seen.command_rad).collect();
        let y = sensed.sight.iter().map(|seen| MICRO * seen.reading_rad).collect();
        most = x.iter().fold(most, |most, x| most.max(x.abs()));
        series.push(Series::new(case.point.clone(), Style::Markers, x, y));
    }
    if series.is_empty() {
        return None;
    }
    let expected = most / keys.gains_ratio[axis];
    let line = Series::new("expected gain", Style::Fit, vec![-most, most], vec![expected, -expected]);
    series.push(line);
    let x = Scale::linear("command of the mirror", "urad");
    let y = Scale::linear("reading", "urad");
    Some(Plot {
        series,
        ..Plot::new(format!("sight-{name}"), format!("Reading of the fine tracker, mirror {name}"), x, y)
    })
}

/// Departure over amplitude, with its expanded uncertainty.
fn departures(all: &[(&Case, &PointResult)]) -> Option<Plot> {
    let mut series: Vec<Series> = Vec::new();
    for (case, point) in all {
        let found = point.measurements.iter().find(|m| m.measurand == DEPARTURE);
        let (Some(m), Some(amplitude_rad)) = (found, case.requested("amplitude")) else { continue };
        let Some(value) = m.value else { continue };
        let rate_hz = case.requested("frame-rate").unwrap_or(0.0);
        let label = format!("{} at {rate_hz:.0} Hz", m.axis);
        if series.last().is_none_or(|last| last.label != label) {
            series.push(Series::new(label, Style::Markers, Vec::new(), Vec::new()));
        }
        if let Some(last) = series.last_mut() {
            last.x.push(MICRO * amplitude_rad);
            last.y.push(100.0 * value);
            last.u.push(200.0 * m.u);
        }
    }
    let x = Scale::linear("amplitude", "urad");
    let y = Scale::linear("departure", "%");
    (!series.is_empty()).then(|| Plot {
        series,
        limits_of: Some(DEPARTURE.to_owned()),
        ..Plot::new("departure", "Optical gain against the fine loop's", x, y)
    })
}
