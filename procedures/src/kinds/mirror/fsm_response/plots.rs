//! Pictures of the responses and the stroke of one axis of the mirror.

use analysis::frf::{Line, unwrapped_rad};

use super::conclude::Planned;
use super::keys::Keys;
use super::point::Position;
use super::response::{BANDWIDTH, HALF_POWER_DB, RESONANCE, decibel, loop_plots};
use super::spectra::MirrorLine;
use crate::kinds::optics::frames::MIRROR_AXES;
use crate::trace::{LimitLine, Mark, Plot, Scale, Series, Style};

/// Gain and phase over frequency, all responses of one axis.
pub(super) fn responses(axis: usize, points: &[Planned<'_>]) -> Vec<Plot> {
    let name = MIRROR_AXES[axis];
    let mut gain = Vec::new();
    let mut phase = Vec::new();
    let mut marks = Vec::new();
    for planned in points {
        let point = &planned.case.point;
        let response = planned.point().and_then(|point| point.response.as_ref());
        let gauge = response.map(|response| ("strain gauge", &response.gauge));
        let reference = response.and_then(|response| response.reference.as_ref());
        for (sensor, lines) in gauge.into_iter().chain(reference.map(|lines| ("autocollimator", lines))) {
            let plain: Vec<Line> = lines.iter().map(|l| l.line).collect();
            let label = format!("{point}, {sensor}");
            let decibels: Vec<f64> = plain.iter().map(Line::gain_db).collect();
            let degrees: Vec<f64> = unwrapped_rad(&plain).iter().map(|p| p.to_degrees()).collect();
            gain.extend(series(&label, lines, &decibels, &|l| 2.0 * decibel(l.relative_sd())));
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
pub(super) fn open_loops(keys: &Keys, points: &[Planned<'_>]) -> Vec<Plot> {
    let first = keys.channels.first().copied();
    let mut plots = Vec::new();
    for planned in points.iter().filter(|p| p.case.mirror_channel == first) {
        let response = planned.point().and_then(|point| point.response.as_ref());
        plots.extend(response.into_iter().flat_map(|response| loop_plots(planned.case, &response.gauge)));
    }
    plots
}

/// Departure of what was reached from the command, over the command.
pub(super) fn stroke(axis: usize, planned: Planned<'_>) -> Option<Plot> {
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
