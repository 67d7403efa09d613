//! Over all points: differences of the channels, stroke, gauge against autocollimator, harmonics, remarks, pictures.

use analysis::frf::{Line, unwrapped_rad};
use analysis::least_squares::LinearFit;
use analysis::uncertainty::{Component, combine};

use super::channels;
use super::keys::Keys;
use super::point::{MirrorPoint, Position, Tilt};
use super::response::{
    BANDWIDTH, DISTORTION, HALF_POWER_DB, RESONANCE, Reading, complete, decibel, loop_plots, measurement,
    sine,
};
use super::spectra::MirrorLine;
use super::{MEASURE, POSITION, TONE, has_segment, mirror_axis};
use crate::case::Case;
use crate::device::MIRROR_AXES;
use crate::measurement::{Bound, Conclusion, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{MirrorReason, Reason};
use crate::trace::{LimitLine, Mark, Plot, Scale, Series, Style};

pub(super) const STROKE: &str = "mirror-stroke";
/// Share of the farthest command up to which positions tell the scale of the others.
const INNER_SHARE: f64 = 2.0 / 3.0;
/// Share of its command, by that scale, that a mirror inside of its stroke reaches at least.
const FOLLOWED_SHARE: f64 = 0.98;
/// Why a stroke that ends where the commands do is a bound.
const AT_LEAST: &str = "the mirror followed its largest command, so the end of its stroke was not reached";
pub(super) const GAUGE_SCALE: &str = "gauge-scale-departure";

/// A point with its plan.
#[derive(Clone, Copy)]
pub(super) struct Planned<'a> {
    pub(super) case: &'a Case,
    pub(super) result: &'a PointResult,
}

impl<'a> Planned<'a> {
    /// What the point was reduced to; `None` where nothing came of it.
    pub(super) fn point(&self) -> Option<&'a MirrorPoint> {
        self.result.reduced.get()
    }
}

/// Measurements, pictures and remarks.
pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult]) -> Conclusion {
    let all: Vec<Planned<'_>> =
        cases.iter().zip(points).map(|(case, result)| Planned { case, result }).collect();
    let mut conclusion = Conclusion::default();
    for &axis in &keys.mirror_axes {
        let having = |label: &'static str| {
            all.iter()
                .copied()
                .filter(move |p| mirror_axis(p.case) == Some(axis) && has_segment(p.case, label))
        };
        let responses: Vec<Planned<'_>> = having(MEASURE).collect();
        conclusion.measurements.extend(responses.iter().flat_map(|p| p.result.measurements.clone()));
        if keys.channels.len() > 1 {
            for &level_v in &keys.levels_v {
                conclusion.measurements.extend(channels::differences(keys, &responses, level_v));
            }
        }
        for planned in having(POSITION) {
            conclusion.measurements.extend(stroke_measurements(keys, planned));
            conclusion.plots.extend(stroke_plot(axis, planned));
        }
        for planned in having(TONE) {
            add_harmonics(keys, planned, &mut conclusion);
        }
        conclusion.plots.extend(response_plots(keys, axis, &responses));
        conclusion.plots.extend(open_loops(keys, &responses));
        conclusion.remarks.extend(remark_on_resonance(axis, &conclusion.measurements));
    }
    conclusion
}

/// A resonance of the support must be noticed.
fn remark_on_resonance(axis: usize, measurements: &[Measurement]) -> Option<String> {
    let name = MIRROR_AXES[axis];
    let of_axis = measurements.iter().filter(|m| m.measurand == RESONANCE && m.axis == name);
    let found_hz: Vec<f64> = of_axis.filter_map(|m| m.value).collect();
    let low_hz = found_hz.iter().copied().reduce(f64::min)?;
    let high_hz = found_hz.iter().copied().reduce(f64::max)?;
    Some(format!(
        "{name}: a resonance of the mirror's support at {low_hz:.1} … {high_hz:.1} Hz in {} responses; its \
         lines are left out",
        found_hz.len()
    ))
}

/// One-sided stroke and departure of the gauge's scale.
fn stroke_measurements(keys: &Keys, planned: Planned<'_>) -> [Measurement; 2] {
    let Planned { case, result } = planned;
    let point = planned.point();
    let positions = point.map_or(&[][..], |point| &point.positions);
    let failed = || result.inconclusive.clone().unwrap_or_else(|| MirrorReason::NoPositions.into());
    let seen = positions.iter().all(|p| p.reference.is_some()) && !positions.is_empty();
    let stroke = if positions.is_empty() { Err(failed()) } else { stroke(keys, positions, seen) };
    let scale = if positions.is_empty() {
        Err(failed())
    } else if seen {
        gauge_scale(keys, positions)
    } else {
        Err(MirrorReason::NoAutocollimator.into())
    };
    let mut stroke = measurement(STROKE, Q::Angle, case, stroke);
    let mut scale = measurement(GAUGE_SCALE, Q::Ratio, case, scale);
    for m in [&mut stroke, &mut scale] {
        complete(m, keys, case, point);
        if seen {
            let channel = format!("/fsm reference_{}_rad", m.axis);
            m.evidence.iter_mut().for_each(|e| e.channels.push(channel.clone()));
        }
    }
    stroke.flags.push(if seen { "by the autocollimator" } else { "gauge only" }.to_owned());
    if stroke.value.is_some() && !stops_short(positions, seen) {
        stroke.set_bound(Bound::AtLeast(AT_LEAST.to_owned()));
    }
    [stroke, scale]
}

/// The smaller one of both sides: the farthest position that was reached there.
fn stroke(keys: &Keys, positions: &[Position], seen: bool) -> Result<Reading, Reason> {
    let scale_u_ratio = match keys.gauge_u_ratio {
        _ if seen => keys.reference_u_ratio,
        Some(u_ratio) => u_ratio,
        None => {
            return Err(MirrorReason::GaugeOnly.into());
        }
    };
    let (Some(up), Some(down)) =
        (Reached::farthest(positions, 1.0, seen), Reached::farthest(positions, -1.0, seen))
    else {
        return Err(MirrorReason::OneSided.into());
    };
    let least = if up.tilt_rad < down.tilt_rad { up } else { down };
    let spread = combine(&[
        Component { u: least.u_rad, dof: (least.rows_count as f64 - 1.0).max(1.0) },
        Component::known(scale_u_ratio * least.tilt_rad.abs()),
    ]);
    Ok(Reading { value: least.tilt_rad, u: spread.u, dof: spread.dof, n: positions.len() })
}

/// Whether the mirror stayed behind its farthest command on the shorter side, so that what it reached is the end of its
/// stroke. The scale is that of the positions up to two thirds of that command.
fn stops_short(positions: &[Position], seen: bool) -> bool {
    let is_short = |sign: f64| {
        let side = || positions.iter().filter(move |p| sign * p.command_rad > 0.0);
        let farthest_rad = side().map(|p| sign * p.command_rad).fold(0.0, f64::max);
        let inner = || side().filter(|p| sign * p.command_rad <= INNER_SHARE * farthest_rad);
        let commanded_rad: f64 = inner().map(|p| sign * p.command_rad).sum();
        let tilted_rad: f64 = inner().map(|p| Reached::at(p, sign, seen).tilt_rad).sum();
        let reached_rad = Reached::farthest(positions, sign, seen).map_or(0.0, |r| r.tilt_rad);
        reached_rad < FOLLOWED_SHARE * farthest_rad * tilted_rad / commanded_rad
    };
    is_short(1.0) || is_short(-1.0)
}

/// A position as it was reached, towards its own side.
struct Reached {
    tilt_rad: f64,
    u_rad: f64,
    rows_count: usize,
}

impl Reached {
    /// The farthest position that was reached on the side of this sign.
    fn farthest(positions: &[Position], sign: f64, seen: bool) -> Option<Self> {
        let side = positions.iter().filter(|p| sign * p.command_rad > 0.0);
        side.map(|p| Self::at(p, sign, seen)).max_by(|a, b| a.tilt_rad.total_cmp(&b.tilt_rad))
    }

    /// A position on the side of this sign.
    fn at(position: &Position, sign: f64, seen: bool) -> Self {
        let Tilt { tilt_rad, u_rad } = position.reference.filter(|_| seen).unwrap_or(position.gauge);
        Self { tilt_rad: sign * tilt_rad, u_rad, rows_count: position.rows_count }
    }
}

/// Slope of gauge over autocollimator, less 1.
fn gauge_scale(keys: &Keys, positions: &[Position]) -> Result<Reading, Reason> {
    let x: Vec<f64> = positions.iter().filter_map(|p| p.reference).map(|r| r.tilt_rad).collect();
    let y: Vec<f64> = positions.iter().map(|p| p.gauge.tilt_rad).collect();
    let fit = LinearFit::new(&[vec![1.0; x.len()], x], &y, None)?;
    let own = Component { u: fit.u(1), dof: fit.dof as f64 };
    let spread = combine(&[own, Component::known(keys.reference_u_ratio)]);
    Ok(Reading { value: fit.coefficients[1] - 1.0, u: spread.u, dof: spread.dof, n: y.len() })
}

/// Adds what a point of single sines measured, and a remark where the criterion is not met.
fn add_harmonics(keys: &Keys, planned: Planned<'_>, conclusion: &mut Conclusion) {
    let Planned { case, result } = planned;
    if result.measurements.is_empty()
        && let Some(reason) = &result.inconclusive
    {
        conclusion.measurements.push(measurement(DISTORTION, Q::Ratio, case, Err(reason.clone())));
        return;
    }
    conclusion.measurements.extend(result.measurements.iter().cloned());
    let Some(criterion) = keys.harmonics.as_ref().map(|h| &h.criterion) else { return };
    let tones = planned.point().map_or(&[][..], |point| &point.tones);
    for tone in tones.iter().filter(|tone| !criterion.holds(tone.distortion_ratio)) {
        conclusion.remarks.push(format!(
            "{}: harmonics 2 to 5 sum up to {} ({}, criterion {} not met)",
            case.point,
            Q::Ratio.format(tone.distortion_ratio),
            sine(tone),
            criterion.text
        ));
    }
}

/// Gain and phase over frequency, all responses of one axis.
fn response_plots(keys: &Keys, axis: usize, points: &[Planned<'_>]) -> Vec<Plot> {
    let name = MIRROR_AXES[axis];
    let mut gain = Vec::new();
    let mut phase = Vec::new();
    let mut marks = Vec::new();
    for planned in points {
        let point = &planned.case.point;
        let response = planned.point().and_then(|point| point.response.as_ref());
        let gauge = response.map(|response| ("strain gauge", &response.gauge, 0.0));
        let reference = response.and_then(|response| response.reference.as_ref());
        // Its scale is no better than its certificate; the gauge is the servo's own measure.
        let reference = reference.map(|lines| ("autocollimator", lines, keys.reference_u_ratio));
        for (sensor, lines, scale_u_ratio) in gauge.into_iter().chain(reference) {
            let plain: Vec<Line> = lines.iter().map(|l| l.line).collect();
            let label = format!("{point}, {sensor}");
            let decibels: Vec<f64> = plain.iter().map(Line::gain_db).collect();
            let degrees: Vec<f64> = unwrapped_rad(&plain).iter().map(|p| p.to_degrees()).collect();
            gain.extend(series(&label, lines, &decibels, &|l| {
                2.0 * decibel(l.relative_sd().hypot(scale_u_ratio))
            }));
            phase.extend(series(&label, lines, &degrees, &|l| 2.0 * l.relative_sd().to_degrees()));
        }
        for (measurand, label) in [(BANDWIDTH, "-3 dB"), (RESONANCE, "support")] {
            let value = planned.result.measurements.iter().find(|m| m.measurand == measurand);
            let value = value.and_then(|m| m.value);
            marks.extend(value.map(|x| Mark { label: format!("{label}, {point}"), x }));
        }
    }
    if gain.is_empty() {
        return Vec::new();
    }
    let half_power = LimitLine { label: "-3 dB".to_owned(), y: HALF_POWER_DB, x: None };
    vec![
        plot(
            format!("gain-{name}"),
            format!("Gain, mirror {name}"),
            "gain",
            "dB",
            gain,
            vec![half_power],
            marks,
        ),
        plot(format!("phase-{name}"), format!("Phase, mirror {name}"), "phase", "deg", phase, vec![], vec![]),
    ]
}

/// Open loops by the first channel: a channel is not in the loop.
fn open_loops(keys: &Keys, points: &[Planned<'_>]) -> Vec<Plot> {
    let first = keys.channels.first().copied();
    let mut plots = Vec::new();
    for planned in points.iter().filter(|p| p.case.mirror_channel == first) {
        let response = planned.point().and_then(|point| point.response.as_ref());
        plots.extend(response.into_iter().flat_map(|response| loop_plots(planned.case, &response.gauge)));
    }
    plots
}

/// Departure of what was reached from the command, over the command.
fn stroke_plot(axis: usize, planned: Planned<'_>) -> Option<Plot> {
    let positions = &planned.point()?.positions;
    if positions.is_empty() {
        return None;
    }
    let scale =
        |label: &str, unit: &str| Scale { label: label.to_owned(), unit: unit.to_owned(), log: false };
    let departures = |label: &str, reached_rad: &dyn Fn(&Position) -> Option<f64>| {
        let mut x = Vec::new();
        let mut y = Vec::new();
        for position in positions {
            if let Some(reached_rad) = reached_rad(position) {
                x.push(1e3 * position.command_rad);
                y.push(1e6 * (reached_rad - position.command_rad));
            }
        }
        (!x.is_empty()).then(|| Series::new(label, Style::Markers, x, y))
    };
    let gauge = departures("strain gauge", &|p| Some(p.gauge.tilt_rad));
    let reference = departures("autocollimator", &|p| p.reference.map(|r| r.tilt_rad));
    let name = MIRROR_AXES[axis];
    Some(Plot {
        series: gauge.into_iter().chain(reference).collect(),
        ..Plot::new(
            format!("stroke-{name}"),
            format!("Positions up to the end of the stroke, {name}"),
            scale("command", "mrad"),
            scale("reached less command", "urad"),
        )
    })
}

/// What counts, and hollow what does not.
fn series(label: &str, lines: &[MirrorLine], y: &[f64], u: &dyn Fn(&Line) -> f64) -> Vec<Series> {
    let part = |counts: bool| {
        let mine: Vec<usize> = (0..lines.len()).filter(|&k| lines[k].counts() == counts).collect();
        let left_out = if counts { "" } else { ", left out" };
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let style = if counts { Style::Markers } else { Style::Excluded };
        let x = mine.iter().map(|&k| lines[k].line.frequency_hz).collect();
        let y = mine.iter().map(|&k| finite(y[k])).collect();
        let u = mine.iter().map(|&k| finite(u(&lines[k].line))).collect();
        (!mine.is_empty()).then(|| Series::new(format!("{label}{left_out}"), style, x, y).with_u(u))
    };
    [part(true), part(false)].into_iter().flatten().collect()
}

fn plot(
    id: String,
    title: String,
    label: &str,
    unit: &str,
    series: Vec<Series>,
    limits: Vec<LimitLine>,
    marks: Vec<Mark>,
) -> Plot {
    let x = Scale { label: "frequency".to_owned(), unit: "Hz".to_owned(), log: true };
    let y = Scale { label: label.to_owned(), unit: unit.to_owned(), log: false };
    Plot { series, limits, marks, ..Plot::new(id, title, x, y) }
}
