//! The point: sines in the angle that moved and in the tracker's readings.

use std::f64::consts::TAU;

use analysis::delay::{PhaseSlope, phase_slope};
use analysis::estimate::Estimate;
use analysis::frf::{C64, Frf, Line, unwrapped_rad};
use analysis::goodness::Goodness;
use analysis::least_squares::LinearFit;
use analysis::periodic::errors_in_variables;
use analysis::tones::{Samples, tones};
use analysis::uncertainty::{Component, combine};

use super::keys::{Keys, LEAST_LINES};
use super::plan::SINES;
use super::{JITTER, LATENCY, SCALE, STAMP};
use crate::axis::Axes;
use crate::case::Case;
use crate::device::MIRROR_AXES;
use crate::kinds::optics::frames::{Course, FINE_TOPIC, Frames, MIRROR_TOPIC, READINGS, SIGHT_GATE};
use crate::log::Window;
use crate::measurement::{Condition, Evidence, Measurement, PointResult, Proof, Reduced};
use crate::quantity::QuantityKind as Q;
use crate::reason::{OpticsReason, Reason};
use crate::trace::{Plot, Scale, Series, Style};

const ESTIMATOR: &str = "tracker-latency/1";
const SCALE_ESTIMATOR: &str = "tracker-scale/2";
const COARSE_TOPIC: &str = "/coarse";
/// A declared delay that is off by more standard uncertainties than this is not the one that is there.
const MOST_OFF: f64 = 3.0;
/// A sine that stands out of its scatter by less is left out.
const LEAST_SNR: f64 = 5.0;

/// What the point says.
struct Found {
    by_receipt: (Frf, PhaseSlope),
    by_exposure: (Frf, PhaseSlope),
    jitter_s: f64,
    age_s: f64,
    frames: usize,
    row_s: f64,
    rate_hz: f64,
    /// Why the coarse camera is not the one that was asked for. The bench cannot set its rate, and the sign of what it shows stands.
    other_rate: Option<Reason>,
    /// Standard uncertainty of stated exposures by the arrivals, and by the delay that is declared.
    placed_u_s: f64,
    declared_u_s: f64,
    clock_drift_ratio: f64,
    /// Angle shown over angle moved, less 1; `None` for the fine tracker.
    scale: Option<(Estimate, Option<String>)>,
    span_s: [f64; 2],
    channels: [String; 2],
}

/// Reduces and measures the point.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    match found(keys, case, window, axes) {
        Ok(found) => PointResult {
            measurements: measured(keys, case, &found),
            plots: vec![picture(keys, &found)],
            reduced: Reduced::to(Offset { rad: found.by_exposure.1.offset_rad }),
            ..PointResult::of(case)
        },
        Err(reason) => {
            let mut all = [LATENCY, STAMP, JITTER].map(|name| (name, Q::Time)).to_vec();
            if !keys.is_fine {
                all.push((SCALE, Q::Ratio));
            }
            PointResult::without(case, &all, ESTIMATOR, reason).under(&Condition::reached(case, |_| None))
        }
    }
}

fn found(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> Result<Found, Reason> {
    let axis = axes.gimbal_index(&case.axis).ok_or(OpticsReason::NoTrackerAxis)?;
    let span = window.segment(case, SINES)?;
    let topic = if keys.is_fine { FINE_TOPIC } else { COARSE_TOPIC };
    let frames = Frames::read(window, topic, span.start_s, span.end_s)?;
    let other_rate = case.requested("frame-rate").and_then(|asked_hz| frames.check_rate(asked_hz).err());
    if let (true, Some(reason)) = (keys.is_fine, &other_rate) {
        return Err(reason.clone());
    }
    let (moved_topic, moved_name) = if keys.is_fine {
        (MIRROR_TOPIC.to_owned(), format!("angle_{}_rad", MIRROR_AXES[axis]))
    } else {
        (format!("/{}", case.axis), "position_rad".to_owned())
    };
    let moved = Course::of(window, &moved_topic, &moved_name)?;
    let start_s = span.start_s + keys.period_s;
    let all = |course: Course<'_>| periods(keys, course, start_s);
    let angles = all(moved)?;
    let errors = &frames.error_rad[axis];
    let slope = |times: &[f64]| -> Result<(Frf, PhaseSlope), Reason> {
        let readings = all(Course { time_s: times, values: errors })?;
        let lines = errors_in_variables(&keys.frequencies_hz, &angles, &readings)
            .map_err(|_| OpticsReason::NothingMovedAtAll)?;
        let stands_out = |l: &Line| l.value.norm_sqr() > LEAST_SNR * LEAST_SNR * l.variance;
        let turned = lines.into_iter().filter(stands_out).map(|l| Line { value: -l.value, ..l });
        let lines: Frf = turned.collect();
        if lines.len() < LEAST_LINES {
            return Err(OpticsReason::TooFewSines { sines: lines.len() }.into());
        }
        let slope = phase_slope(&lines)?;
        Ok((lines, slope))
    };
    let by_exposure = slope(&frames.exposure_s)?;
    let scale = match keys.is_fine {
        true => None,
        false => Some(scale(&by_exposure.0, across(window, axis, axes, span.start_s)?)?),
    };
    let ages: Vec<f64> = frames.received_s.iter().zip(&frames.exposure_s).map(|(r, e)| r - e).collect();
    let age_s = ages.iter().sum::<f64>() / ages.len() as f64;
    let square = ages.iter().map(|a| (a - age_s).powi(2)).sum::<f64>();
    Ok(Found {
        by_receipt: slope(&frames.received_s)?,
        by_exposure,
        scale,
        jitter_s: (square / (ages.len() - 1) as f64).sqrt(),
        age_s,
        frames: ages.len(),
        row_s: row_s(window, topic)?,
        rate_hz: frames.rate_hz,
        other_rate,
        placed_u_s: frames.placed_u_s,
        declared_u_s: frames.declared_u_s,
        clock_drift_ratio: frames.clock_drift_ratio,
        span_s: [start_s, span.end_s],
        channels: [format!("{moved_topic} {moved_name}"), format!("{topic} {}", READINGS[axis])],
    })
}

/// How far the line of sight moves for an angle of the axis: azimuth moves it by the cosine of the elevation.
fn across(window: &Window, axis: usize, axes: &Axes, at_s: f64) -> Result<f64, Reason> {
    if axis != 0 {
        return Ok(1.0);
    }
    let elevation = Course::of(window, &format!("/{}", axes.gimbal()?.inner.name), "position_rad")?;
    let here = elevation.time_s.partition_point(|t| *t <= at_s).saturating_sub(1);
    Ok(elevation.values.get(here).map_or(1.0, |rad| rad.cos()))
}

/// Size of the response at 0 Hz over the motion of the line of sight, less 1: what structure between encoder and camera adds
/// grows with the square of the frequency. Beside it, what is to be said where the lines scatter more than their noise.
fn scale(lines: &Frf, moved: f64) -> Result<(Estimate, Option<String>), Reason> {
    let squares = lines.iter().map(|l| l.frequency_hz * l.frequency_hz).collect();
    let sizes: Vec<f64> = lines.iter().map(|l| l.value.norm() / moved).collect();
    // Half of the variance of a line is along it.
    let weights: Vec<f64> = lines.iter().map(|l| 2.0 * moved * moved / l.variance).collect();
    let fit = LinearFit::new(&[vec![1.0; lines.len()], squares], &sizes, Some(&weights))
        .map_err(OpticsReason::Scale)?;
    let goodness = Goodness::of_lines(lines, fit.residual_variance, fit.dof);
    goodness.check()?;
    let u = (fit.unscaled_covariance[(0, 0)] * goodness.variance_factor()).sqrt();
    let estimate = Estimate { value: fit.coefficients[0] - 1.0, u, dof: fit.dof as f64, n: lines.len() };
    Ok((estimate, goodness.flag()))
}

/// Phases at 0 Hz that lie nearer to a quarter of a turn than this say nothing of a sign: cos 45°.
const LEAST_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Phase at 0 Hz of the tracker's readings against the motion, for the sign of tracker and axis.
struct Offset {
    rad: f64,
}

/// Whether the tracker sees the motion the right way round: what closes a track loop later relies on it. `None` where it
/// was not seen at all.
pub(super) fn proof(keys: &Keys, points: &[PointResult]) -> Option<Proof> {
    let offset_rad = points.iter().find_map(|point| point.reduced.get::<Offset>())?.rad;
    // Half a turn is the other sign; a quarter is none.
    if offset_rad.cos().abs() < LEAST_COSINE {
        return None;
    }
    let is_turned = offset_rad.cos() < 0.0;
    let fault = format!(
        "sign of the {} tracker: its readings have the same sign as the motion, expected the opposite \
         (target minus line of sight); the sign of camera or axis is inverted",
        keys.tracker()
    );
    Some(Proof { gate: SIGHT_GATE.to_owned(), faults: is_turned.then_some(fault).into_iter().collect() })
}

/// Time between two rows of a topic.
fn row_s(window: &Window, topic: &str) -> Result<f64, Reason> {
    let rows = window.topic(topic)?;
    let [first, .., last] = rows.time_s.as_slice() else {
        return Err(OpticsReason::TooFewTrackerRows { topic: topic.to_owned() }.into());
    };
    Ok((last - first) / (rows.time_s.len() - 1) as f64)
}

/// The sines in each period.
fn periods(keys: &Keys, course: Course<'_>, start_s: f64) -> Result<Vec<Vec<C64>>, Reason> {
    let period = |k: u32| {
        let from_s = start_s + f64::from(k) * keys.period_s;
        let Course { time_s, values } = course.between(from_s, from_s + keys.period_s);
        let found = tones(Samples { time_s, values }, &keys.frequencies_hz, start_s);
        found.map(|tones| tones.amplitudes).map_err(|e| Reason::from(OpticsReason::PeriodOfSines(e)))
    };
    (0..keys.periods).map(period).collect()
}

fn measured(keys: &Keys, case: &Case, found: &Found) -> Vec<Measurement> {
    let dof = |lines: &Frf| (lines.len() - 2) as f64;
    let known = Component::known(keys.moved_delay_u_s);
    let quantised = Component::known(found.row_s / 12.0_f64.sqrt());
    let placed = Component::known(found.placed_u_s);
    let estimate = |(lines, slope): &(Frf, PhaseSlope), off_s: f64, others: &[Component]| {
        let own = Component { u: slope.u_s, dof: dof(lines) };
        let total = combine(&[&[own], others].concat());
        let value = slope.delay_s + keys.moved_delay_s - off_s;
        Estimate { value, u: total.u, dof: total.dof, n: lines.len() }
    };
    let n = found.frames;
    let jitter_u = (found.jitter_s / (2.0 * (n as f64 - 1.0)).sqrt()).hypot(quantised.u);
    let jitter = Estimate { value: found.jitter_s, u: jitter_u, dof: n as f64 - 1.0, n };
    let mut all: Vec<Measurement> = [
        (LATENCY, estimate(&found.by_receipt, 0.5 * found.row_s, &[known, quantised])),
        (STAMP, estimate(&found.by_exposure, 0.0, &[known, placed])),
        (JITTER, jitter),
    ]
    .into_iter()
    .map(|(name, estimate)| {
        complete(Measurement::new(name, &case.axis, Q::Time, Some(estimate), ESTIMATOR), case, found)
    })
    .collect();
    if let Some((scale, flag)) = &found.scale {
        let scale = Measurement {
            flags: flag.iter().cloned().collect(),
            ..Measurement::new(SCALE, &case.axis, Q::Ratio, Some(*scale), SCALE_ESTIMATOR)
        };
        all.push(complete(scale, case, found));
    }
    let degrees = found.by_receipt.1.offset_rad.to_degrees();
    all[0].flags.push(format!("phase at 0 Hz {degrees:.1} deg"));
    all[0]
        .flags
        .push(format!("age by the stated exposures {:.2} ms", 1e3 * (found.age_s - 0.5 * found.row_s)));
    all[0].flags.push("arrival by the clock of the loop".to_owned());
    let told = stamp_flags(&all[1], found);
    all[1].flags.extend(told);
    all.iter_mut().for_each(|m| m.flags.push(format!("{} tracker", keys.tracker())));
    all
}

/// Whose clock the exposures are of, and whether the declared delay is the one that is there.
fn stamp_flags(stamp: &Measurement, found: &Found) -> Vec<String> {
    let mut flags = vec![format!(
        "exposures by the tracker's own clock ({:+.1} ppm), mapped onto that of the loop by the arrivals \
         and the declared delay",
        1e6 * found.clock_drift_ratio
    )];
    let off_s = stamp.value.unwrap_or(0.0);
    if off_s.abs() > MOST_OFF * stamp.u.hypot(found.declared_u_s) {
        flags.push(format!(
            "the declared delay of messages is off by {:+.2} ms, declared to {:.2} ms (k = 1): correct `message-delay` in \
             the rig file",
            1e3 * off_s,
            1e3 * found.declared_u_s
        ));
    }
    flags
}

fn complete(mut m: Measurement, case: &Case, found: &Found) -> Measurement {
    m.point = Some(case.point.clone());
    m.inconclusive = found.other_rate.as_ref().map(Reason::to_string);
    if let Some(requested) = case.requested("frame-rate") {
        let name = "frame-rate".to_owned();
        let achieved = Some(found.rate_hz);
        m.conditions.push(Condition { name, requested, achieved, kind: Q::Frequency });
    }
    m.evidence.push(Evidence::new(found.channels.to_vec(), found.span_s));
    m
}

/// Phases with the straight lines through them.
fn picture(keys: &Keys, found: &Found) -> Plot {
    let mut series = Vec::new();
    for (label, (lines, slope)) in
        [("by receipt", &found.by_receipt), ("by stated exposure", &found.by_exposure)]
    {
        let x: Vec<f64> = lines.iter().map(|l| l.frequency_hz).collect();
        let y = unwrapped_rad(lines).iter().map(|p| p.to_degrees()).collect();
        let u = lines.iter().map(|l| 2.0 * l.relative_sd().to_degrees()).collect();
        series.push(Series::new(label, Style::Markers, x.clone(), y).with_u(u));
        let fitted = x.iter().map(|f| (slope.offset_rad - TAU * f * slope.delay_s).to_degrees()).collect();
        let text = format!("{label}: {:.2} ms", 1e3 * slope.delay_s);
        series.push(Series::new(text, Style::Fit, x, fitted));
    }
    let x = Scale::linear("frequency", "Hz");
    let y = Scale::linear("phase", "deg");
    let title = format!("Phase of the {} tracker behind the motion", keys.tracker());
    Plot { series, ..Plot::new("phase", title, x, y) }
}
