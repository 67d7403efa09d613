//! Pictures of the responses of one axis.

use analysis::frf::{Line, unwrapped_rad};

use super::Point;
use crate::kinds::frames::MIRROR_AXES;
use crate::kinds::fsm_response::keys::Keys;
use crate::kinds::fsm_response::level::{HALF_POWER_DB, decibel};
use crate::kinds::fsm_response::lines::{Judged, from_numbers};
use crate::kinds::fsm_response::measure::{BANDWIDTH, RESONANCE};
use crate::kinds::fsm_response::open_loop;
use crate::kinds::fsm_response::record::{GAUGE, REFERENCE};
use crate::trace::{LimitLine, Mark, Plot, Scale, Series, Style};

/// Gain and phase over frequency, all responses of one axis.
pub(super) fn responses(axis: usize, points: &[Point<'_>]) -> Vec<Plot> {
    let name = MIRROR_AXES[axis];
    let (mut gain, mut phase, mut marks) = (Vec::new(), Vec::new(), Vec::new());
    for (case, result) in points {
        for (sensor, key) in [("strain gauge", GAUGE), ("autocollimator", REFERENCE)] {
            let Some(numbers) = result.numbers.get(key) else { continue };
            let lines = from_numbers(numbers);
            let plain: Vec<Line> = lines.iter().map(|l| l.line).collect();
            let unwrapped = unwrapped_rad(&plain);
            let label = format!("{}, {sensor}", case.point);
            let decibels: Vec<f64> = plain.iter().map(Line::gain_db).collect();
            let degrees: Vec<f64> = unwrapped.iter().map(|p| p.to_degrees()).collect();
            gain.extend(series(&label, &lines, &decibels, &|l| 2.0 * decibel(l.relative_sd())));
            phase.extend(series(&label, &lines, &degrees, &|l| 2.0 * l.relative_sd().to_degrees()));
        }
        for (measurand, label) in [(BANDWIDTH, "-3 dB"), (RESONANCE, "support")] {
            let value = result.measurements.iter().find(|m| m.measurand == measurand).and_then(|m| m.value);
            marks.extend(value.map(|x| Mark { label: format!("{label}, {}", case.point), x }));
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
pub(super) fn open_loops(keys: &Keys, points: &[Point<'_>]) -> Vec<Plot> {
    let first = points.iter().filter(|(case, _)| case.mirror_channel == keys.channels.first().copied());
    let of = |(case, result): &Point<'_>| {
        result.numbers.get(GAUGE).map(|numbers| open_loop::plots(case, &from_numbers(numbers)))
    };
    first.filter_map(of).flatten().collect()
}

/// What counts, and hollow what does not.
fn series(label: &str, lines: &[Judged], y: &[f64], u: &dyn Fn(&Line) -> f64) -> Vec<Series> {
    let of = |counts: bool| {
        let mine: Vec<usize> = (0..lines.len()).filter(|&k| lines[k].counts() == counts).collect();
        let left_out = if counts { "" } else { ", left out" };
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let style = if counts { Style::Markers } else { Style::Excluded };
        let x = mine.iter().map(|&k| lines[k].line.frequency_hz).collect();
        let y = mine.iter().map(|&k| finite(y[k])).collect();
        let u = mine.iter().map(|&k| finite(u(&lines[k].line))).collect();
        (!mine.is_empty()).then(|| Series::new(format!("{label}{left_out}"), style, x, y).with_u(u))
    };
    [of(true), of(false)].into_iter().flatten().collect()
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
