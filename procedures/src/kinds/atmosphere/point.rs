//! One point: readings and mirror on an even grid, and their spectra.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use analysis::spectra::{CrossSpectra, SpectraError, WelchSettings};

use super::keys::Keys;
use super::plan::{BLOCK_S, CLOSED, LEAD_S, RECORD, SINE, SINE_BLOCKS, SINE_HZ};
use crate::case::Case;
use crate::kinds::frames::{
    Blocks, Course, FINE_TOPIC, Frames, MIRROR_AXES, MIRROR_TOPIC, moved_axis, sensed,
};
use crate::log::{SegmentSpan, Window};
use crate::measurement::PointResult;

/// Fewer frames than this say too little about the rest.
const LEAST_FRAMES_RATIO: f64 = 1.0 / 3.0;
/// More than this part of the time at the end of the stroke is no linear loop.
const MOST_SATURATED_RATIO: f64 = 0.01;
/// A reading that stands out of its scatter by less says nothing.
const LEAST_RATIO: f64 = 10.0;

/// Names of the numbers of a point: times, share of frames lost, frames per second, time from row to row of the mirror.
pub(super) const SPAN: &str = "span";
pub(super) const LOST: &str = "lost";
pub(super) const RATE: &str = "rate";
pub(super) const ROW: &str = "row";
/// Reading per angle of the mirror, and its relative standard uncertainty.
pub(super) const SIGHT: &str = "sight";
/// How much later than they were the exposures are stated, by the mirror's sine, and its standard uncertainty.
pub(super) const STAMP: &str = "stamp";
/// Spectra of the readings without the loop: frequency, density, degrees of freedom.
pub(super) const ERROR: &str = "error";
/// Spectra of the closed loop, one array a line, see [`super::spectra`].
pub(super) const LOOP: &str = "loop";
pub(super) const AVERAGES: &str = "averages";

/// Name of a number of an axis.
pub(super) fn of(axis: usize, what: &str) -> String {
    format!("{what} {}", MIRROR_AXES[axis])
}

type Numbers = BTreeMap<String, Vec<f64>>;

/// Reduces one point; measurements come from all.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    match reduce(keys, case, window) {
        Ok(numbers) => result.numbers = numbers,
        Err(reason) => result.inconclusive = Some(reason),
    }
    result
}

fn reduce(keys: &Keys, case: &Case, window: &Window) -> Result<Numbers, String> {
    let span = span(case, window, RECORD).ok_or("the record is not in the log")?;
    if case.point == CLOSED {
        (0..MIRROR_AXES.len()).try_for_each(|axis| saturation(window, axis, span))?;
    }
    let frames = Frames::read(window, FINE_TOPIC, span.start_s, span.end_s)?;
    frames.check_rate(keys.frame_rate_hz)?;
    let lost = frames.lost_ratio();
    if 1.0 - lost < LEAST_FRAMES_RATIO {
        return Err(format!("{:.0} % of the frames lost: too few are left", 100.0 * lost));
    }
    let mut numbers = BTreeMap::from([
        (SPAN.to_owned(), vec![span.start_s, span.end_s]),
        (LOST.to_owned(), vec![lost]),
        (RATE.to_owned(), vec![frames.rate_hz]),
        (ROW.to_owned(), vec![row_s(window, span)?]),
    ]);
    let settings = WelchSettings::new(frames.rate_hz, (keys.segment_s * frames.rate_hz).round() as usize);
    if case.point == CLOSED {
        let late = stated_late(case, window)?;
        numbers.insert(STAMP.to_owned(), vec![late.stated_late_s, late.stated_late_u_s]);
        for axis in 0..MIRROR_AXES.len() {
            let channels = channels(window, axis, &frames, late.stated_late_s)?;
            numbers.extend(of_loop(axis, &channels, &settings).map_err(|e| e.to_string())?);
        }
        return Ok(numbers);
    }
    if let Some(axis) = moved_axis(case) {
        let seen = mirror_sine(window, axis, &frames, span)?;
        numbers.insert(SIGHT.to_owned(), vec![seen.sight, seen.sight_u_ratio]);
        return Ok(numbers);
    }
    for axis in 0..MIRROR_AXES.len() {
        let spectra = of_error(axis, &even(&frames, &frames.error_rad[axis]), &settings);
        numbers.extend(spectra.map_err(|e| e.to_string())?);
    }
    Ok(numbers)
}

/// How late the exposures of the closed loop are stated: by the mirror's sine before it.
fn stated_late(case: &Case, window: &Window) -> Result<MirrorSine, String> {
    let span = span(case, window, SINE).ok_or("the mirror's sine is not in the log")?;
    let axis = moved_axis(case).ok_or("the closed loop has no sine of the mirror before it")?;
    mirror_sine(window, axis, &Frames::read(window, FINE_TOPIC, span.start_s, span.end_s)?, span)
}

fn span<'a>(case: &Case, window: &'a Window, label: &str) -> Option<&'a SegmentSpan> {
    let index = case.segments.iter().position(|s| s.label == label)?;
    window.segments.iter().find(|s| s.segment == index)
}

/// Mean time between two rows of the mirror.
fn row_s(window: &Window, span: &SegmentSpan) -> Result<f64, String> {
    let rows = angle(window, 0)?.between(span.start_s, span.end_s).time_s.len();
    if rows < 2 {
        return Err(format!("`{MIRROR_TOPIC}` has no rows"));
    }
    Ok((span.end_s - span.start_s) / rows as f64)
}

fn angle<'a>(window: &'a Window, axis: usize) -> Result<Course<'a>, String> {
    Course::of(window, MIRROR_TOPIC, &format!("angle_{}_rad", MIRROR_AXES[axis]))
}

/// What the mirror's sine shows of the tracker.
struct MirrorSine {
    /// Reading per angle of the mirror, signed, and its relative standard uncertainty.
    sight: f64,
    sight_u_ratio: f64,
    /// How much later than they were the exposures are stated: the reading at a stated time shows an earlier angle.
    stated_late_s: f64,
    stated_late_u_s: f64,
}

fn mirror_sine(
    window: &Window,
    axis: usize,
    frames: &Frames,
    span: &SegmentSpan,
) -> Result<MirrorSine, String> {
    let (start_s, count) = (span.start_s + LEAD_S, SINE_BLOCKS);
    let blocks = Blocks { start_s, block_s: BLOCK_S, count, frequency_hz: SINE_HZ };
    let line = sensed(angle(window, axis)?, frames, &blocks)?.readings[axis];
    let (size, u) = (line.value.norm(), (0.5 * line.variance).sqrt());
    if size <= 0.0 || u * LEAST_RATIO > size {
        return Err(format!(
            "the tracker does not see the mirror move: {size:.4} rad per rad, scatter {u:.4}"
        ));
    }
    let sight = size.copysign(line.value.re);
    Ok(MirrorSine {
        sight,
        sight_u_ratio: u / size,
        stated_late_s: -(line.value / sight).arg() / (TAU * SINE_HZ),
        stated_late_u_s: u / size / (TAU * SINE_HZ),
    })
}

/// A loop whose command rests at the stroke is not the one that is asked about.
fn saturation(window: &Window, axis: usize, span: &SegmentSpan) -> Result<(), String> {
    let name = format!("{}_saturated", MIRROR_AXES[axis]);
    let saturated = Course::of(window, "/track", &name)?;
    let rows = saturated.between(span.start_s, span.end_s).values;
    let share = rows.iter().filter(|v| **v > 0.5).count() as f64 / rows.len().max(1) as f64;
    if share <= MOST_SATURATED_RATIO {
        return Ok(());
    }
    let (name, percent) = (MIRROR_AXES[axis], 100.0 * share);
    Err(format!(
        "the mirror rests at its stroke on {name} in {percent:.0} % of the time: do the optical gains have the right sign?"
    ))
}

/// Readings, angles of the mirror in the middle of each exposure, which is earlier than stated by this, and their means over
/// the frame around it.
fn channels(
    window: &Window,
    axis: usize,
    frames: &Frames,
    stated_late_s: f64,
) -> Result<[Vec<f64>; 3], String> {
    let angle = angle(window, axis)?;
    let half_s = 0.5 / frames.rate_hz;
    let collect = |value: &dyn Fn(f64) -> Option<f64>| -> Result<Vec<f64>, String> {
        let all: Option<Vec<f64>> = frames.exposure_s.iter().map(|&t| value(t - stated_late_s)).collect();
        all.map(|values| even(frames, &values)).ok_or_else(|| format!("`{MIRROR_TOPIC}` has no rows"))
    };
    let there = collect(&|t| angle.at(t))?;
    let around = collect(&|t| angle.mean(t - half_s, t + half_s))?;
    Ok([even(frames, &frames.error_rad[axis]), there, around])
}

/// Values at even steps from the first to the last exposure, straight lines over what is missing.
fn even(frames: &Frames, values: &[f64]) -> Vec<f64> {
    let time_s = &frames.exposure_s;
    let (Some(first), Some(last)) = (time_s.first(), time_s.last()) else { return Vec::new() };
    let course = Course { time_s, values };
    let steps = ((last - first) * frames.rate_hz + 1e-6).floor() as u32;
    (0..=steps).filter_map(|k| course.at(first + f64::from(k) / frames.rate_hz)).collect()
}

fn of_error(axis: usize, error: &[f64], settings: &WelchSettings) -> Result<Numbers, SpectraError> {
    let psd = CrossSpectra::welch(&[error], settings)?.psd(0)?;
    let lines = psd.frequency_hz.iter().zip(&psd.density).zip(&psd.dof);
    let values = lines.flat_map(|((f, density), dof)| [*f, *density, *dof]).collect();
    Ok(BTreeMap::from([(of(axis, ERROR), values)]))
}

fn of_loop(
    axis: usize,
    [error, there, around]: &[Vec<f64>; 3],
    settings: &WelchSettings,
) -> Result<Numbers, SpectraError> {
    let all = CrossSpectra::welch(&[error, there, around], settings)?;
    let (e, m, b) = (all.psd(0)?, all.psd(1)?, all.psd(2)?);
    let (em, eb, mb) = (all.csd(0, 1)?, all.csd(0, 2)?, all.csd(1, 2)?);
    let line = |k: usize| {
        let cross = [em[k].re, em[k].im, eb[k].re, eb[k].im, mb[k].re, mb[k].im];
        [e.frequency_hz[k], e.density[k], m.density[k], b.density[k]].into_iter().chain(cross)
    };
    let values = (0..e.density.len()).flat_map(line).collect();
    Ok(BTreeMap::from([(of(axis, LOOP), values), (of(axis, AVERAGES), vec![all.averages()])]))
}
