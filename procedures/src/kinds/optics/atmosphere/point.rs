//! One point: readings and mirror on an even grid, their spectra, and the responses of the closed loop.

use std::f64::consts::{PI, TAU};

use analysis::frf::{C64, Frf, Line};
use analysis::spectra::{CrossSpectra, SpectraError, WelchSettings};

use super::keys::{BLOCK_S, CLOSED, Keys, LEAD_S, RECORD, SINE, SINE_BLOCKS, SINE_HZ};
use crate::case::Case;
use crate::device::MIRROR_AXES;
use crate::kinds::optics::frames::{Blocks, Course, FINE_TOPIC, Frames, MIRROR_TOPIC, moved_axis, sensed};
use crate::log::{SegmentSpan, Window};
use crate::measurement::{PointResult, Reduced};
use crate::reason::{OpticsReason, Reason};

/// Fewer frames than this say too little about the rest.
const LEAST_FRAMES_RATIO: f64 = 1.0 / 3.0;
/// More than this part of the time at the end of the stroke is no linear loop.
const MOST_SATURATED_RATIO: f64 = 0.01;
/// A reading that stands out of its scatter by less says nothing.
const LEAST_RATIO: f64 = 10.0;

/// What a point says.
pub(super) struct Record {
    /// Time of the record, on the log's axis.
    pub(super) span_s: [f64; 2],
    /// Share of the frames that were lost.
    pub(super) lost_ratio: f64,
    /// Frames per second.
    pub(super) rate_hz: f64,
    /// Mean time between two rows of the mirror.
    pub(super) row_s: f64,
    pub(super) found: Found,
}

/// What the record of a point was made for.
pub(super) enum Found {
    /// The fine loop was closed.
    Closed {
        /// Standard uncertainty of how late the exposures are stated.
        stamp_u_s: f64,
        /// Spectra of each axis, in the order of [`MIRROR_AXES`].
        axes: Vec<Vec<Spectra>>,
        /// Averages that each spectrum is the mean of.
        averages: f64,
    },
    /// A sine moved the mirror in one axis.
    Mirror(MirrorSine),
    /// The fine loop was open: density of the readings of each axis, in the order of [`MIRROR_AXES`].
    Open(Vec<Vec<Density>>),
}

/// Spectra of a line: S_ij is the mean of conj(X_i)·X_j of the readings e, of the mirror m at the exposures, and of b, the
/// mean of m over a frame.
pub(super) struct Spectra {
    pub(super) frequency_hz: f64,
    pub(super) ee: f64,
    pub(super) mm: f64,
    pub(super) bb: f64,
    pub(super) em: C64,
    pub(super) eb: C64,
    pub(super) mb: C64,
}

/// A line of a power spectral density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Density {
    pub(super) frequency_hz: f64,
    /// Square of the signal's unit per Hz.
    pub(super) value: f64,
    pub(super) dof: f64,
}

/// Reduces one point; measurements come from all.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window) -> PointResult {
    match reduce(keys, case, window) {
        Ok(record) => PointResult { reduced: Reduced::to(record), ..PointResult::of(case) },
        Err(reason) => PointResult { inconclusive: Some(reason), ..PointResult::of(case) },
    }
}

fn reduce(keys: &Keys, case: &Case, window: &Window) -> Result<Record, Reason> {
    let span = window.segment(case, RECORD)?;
    if case.point == CLOSED {
        (0..MIRROR_AXES.len()).try_for_each(|axis| saturation(window, axis, span))?;
    }
    let frames = Frames::read(window, FINE_TOPIC, span.start_s, span.end_s)?;
    frames.check_rate(keys.frame_rate_hz)?;
    let lost_ratio = frames.lost_ratio();
    if 1.0 - lost_ratio < LEAST_FRAMES_RATIO {
        return Err(OpticsReason::FramesLost { percent: 100.0 * lost_ratio }.into());
    }
    let row_s = row_s(window, span)?;
    let settings = WelchSettings::new(frames.rate_hz, (keys.segment_s * frames.rate_hz).round() as usize);
    let found = if case.point == CLOSED {
        closed(case, window, &frames, &settings)?
    } else if let Some(axis) = moved_axis(case) {
        Found::Mirror(mirror_sine(window, axis, &frames, span)?)
    } else {
        let density = |readings: &Vec<f64>| density(&even(&frames, readings), &settings);
        let axes: Result<_, SpectraError> = frames.error_rad.iter().map(density).collect();
        Found::Open(axes?)
    };
    Ok(Record { span_s: [span.start_s, span.end_s], lost_ratio, rate_hz: frames.rate_hz, row_s, found })
}

fn closed(case: &Case, window: &Window, frames: &Frames, settings: &WelchSettings) -> Result<Found, Reason> {
    let late = stated_late(case, window)?;
    let mut axes = Vec::new();
    let mut averages = 0.0;
    for axis in 0..MIRROR_AXES.len() {
        let [error, there, around] = channels(window, axis, frames, late.stated_late_s)?;
        let welch = CrossSpectra::welch(&[&error, &there, &around], settings)?;
        averages = welch.averages();
        axes.push(spectra(&welch)?);
    }
    Ok(Found::Closed { stamp_u_s: late.stated_late_u_s, axes, averages })
}

/// How late the exposures of the closed loop are stated: by the mirror's sine before it.
fn stated_late(case: &Case, window: &Window) -> Result<MirrorSine, Reason> {
    let span = window.segment(case, SINE)?;
    let axis = moved_axis(case).ok_or(OpticsReason::NoSineBefore)?;
    mirror_sine(window, axis, &Frames::read(window, FINE_TOPIC, span.start_s, span.end_s)?, span)
}

/// Mean time between two rows of the mirror.
fn row_s(window: &Window, span: &SegmentSpan) -> Result<f64, Reason> {
    let rows = angle(window, 0)?.between(span.start_s, span.end_s).time_s.len();
    if rows < 2 {
        return Err(OpticsReason::NoMirrorRows { topic: MIRROR_TOPIC }.into());
    }
    Ok((span.end_s - span.start_s) / rows as f64)
}

fn angle<'a>(window: &'a Window, axis: usize) -> Result<Course<'a>, Reason> {
    Course::of(window, MIRROR_TOPIC, &format!("angle_{}_rad", MIRROR_AXES[axis]))
}

/// What the mirror's sine shows of the tracker.
pub(super) struct MirrorSine {
    /// Reading per angle of the mirror, signed.
    pub(super) sight: f64,
    /// Relative standard uncertainty of `sight`.
    pub(super) sight_u_ratio: f64,
    /// How much later than they were the exposures are stated: the reading at a stated time shows an earlier angle.
    stated_late_s: f64,
    stated_late_u_s: f64,
}

fn mirror_sine(
    window: &Window,
    axis: usize,
    frames: &Frames,
    span: &SegmentSpan,
) -> Result<MirrorSine, Reason> {
    let start_s = span.start_s + LEAD_S;
    let count = SINE_BLOCKS;
    let blocks = Blocks { start_s, block_s: BLOCK_S, count, frequency_hz: SINE_HZ };
    let line = sensed(angle(window, axis)?, frames, &blocks)?.readings[axis];
    let size = line.value.norm();
    let u = (0.5 * line.variance).sqrt();
    if size <= 0.0 || u * LEAST_RATIO > size {
        return Err(OpticsReason::NotSeen { size, u }.into());
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
fn saturation(window: &Window, axis: usize, span: &SegmentSpan) -> Result<(), Reason> {
    let name = format!("{}_saturated", MIRROR_AXES[axis]);
    let saturated = Course::of(window, "/track", &name)?;
    let rows = saturated.between(span.start_s, span.end_s).values;
    let share = rows.iter().filter(|v| **v > 0.5).count() as f64 / rows.len().max(1) as f64;
    if share <= MOST_SATURATED_RATIO {
        return Ok(());
    }
    Err(OpticsReason::AtStroke { axis: MIRROR_AXES[axis], percent: 100.0 * share }.into())
}

/// Readings, angles of the mirror in the middle of each exposure, which is earlier than stated by this, and their means over
/// the frame around it.
fn channels(
    window: &Window,
    axis: usize,
    frames: &Frames,
    stated_late_s: f64,
) -> Result<[Vec<f64>; 3], Reason> {
    let angle = angle(window, axis)?;
    let half_s = 0.5 / frames.rate_hz;
    let collect = |value: &dyn Fn(f64) -> Option<f64>| -> Result<Vec<f64>, Reason> {
        let all: Option<Vec<f64>> = frames.exposure_s.iter().map(|&t| value(t - stated_late_s)).collect();
        all.map(|values| even(frames, &values))
            .ok_or_else(|| OpticsReason::NoMirrorRows { topic: MIRROR_TOPIC }.into())
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

fn density(readings: &[f64], settings: &WelchSettings) -> Result<Vec<Density>, SpectraError> {
    let psd = CrossSpectra::welch(&[readings], settings)?.psd(0)?;
    let lines = psd.frequency_hz.iter().zip(&psd.density).zip(&psd.dof);
    Ok(lines.map(|((&frequency_hz, &value), &dof)| Density { frequency_hz, value, dof }).collect())
}

/// Lines of the readings, of the mirror at the exposures and of its mean over a frame.
fn spectra(welch: &CrossSpectra) -> Result<Vec<Spectra>, SpectraError> {
    let [e, m, b] = [welch.psd(0)?, welch.psd(1)?, welch.psd(2)?];
    let [em, eb, mb] = [welch.csd(0, 1)?, welch.csd(0, 2)?, welch.csd(1, 2)?];
    let line = |k: usize| Spectra {
        frequency_hz: e.frequency_hz[k],
        ee: e.density[k],
        mm: m.density[k],
        bb: b.density[k],
        em: em[k],
        eb: eb[k],
        mb: mb[k],
    };
    Ok((0..e.density.len()).map(line).collect())
}

/// What the closed loop says of an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Responses {
    /// Left of the line of sight at any time: 1 − g·M/D.
    pub(super) left: Frf,
    /// Left in the readings, which see the mirror at their exposures only: E/D.
    pub(super) read: Frf,
    /// Density of d, what moves the image.
    pub(super) input: Vec<Density>,
    /// Density of the readings.
    pub(super) error: Vec<Density>,
}

/// Responses of an axis: `sight` is the reading per angle of the mirror, so that d = e − sight·m.
pub(super) fn responses(lines: &[Spectra], averages: f64, sight: f64, rate_hz: f64) -> Responses {
    let mut all = Responses { left: Vec::new(), read: Vec::new(), input: Vec::new(), error: Vec::new() };
    let half_hz = 0.5 * rate_hz;
    for s in lines.iter().filter(|l| l.frequency_hz > 0.0 && l.frequency_hz < half_hz * (1.0 - 1e-9)) {
        let g = -sight;
        let dd = s.ee + 2.0 * g * s.em.re + g * g * s.mm;
        if dd <= 0.0 {
            continue;
        }
        let de = C64::new(s.ee, 0.0) + s.em.conj() * g;
        // The mean over a frame is smaller by sin x/x.
        let turn = PI * s.frequency_hz / rate_hz;
        let db = (s.eb + s.mb * g) / (turn.sin() / turn);
        let bb = s.bb / (turn.sin() / turn).powi(2);
        let taken = db * (g / dd);
        let line = |value: C64, cross: C64, out: f64, size: f64| {
            let coherence = if out > 0.0 { (cross.norm_sqr() / (dd * out)).min(1.0) } else { 0.0 };
            let variance = size * (1.0 - coherence) / coherence.max(1e-12) / (averages - 1.0).max(1.0);
            let dof = (averages - 1.0).max(1.0);
            Line { frequency_hz: s.frequency_hz, value, variance, dof, coherence: Some(coherence) }
        };
        all.left.push(line(C64::new(1.0, 0.0) - taken, db, bb, taken.norm_sqr()));
        all.read.push(line(de / dd, de, s.ee, (de / dd).norm_sqr()));
        let dof = 2.0 * averages;
        all.input.push(Density { frequency_hz: s.frequency_hz, value: dd, dof });
        all.error.push(Density { frequency_hz: s.frequency_hz, value: s.ee, dof });
    }
    all
}
