//! Pictures: readings over commands, and the departures of all points.

use super::DEPARTURE;
use super::keys::Keys;
use super::point::Sensed;
use crate::case::Case;
use crate::kinds::optics::frames::{MIRROR_AXES, moved_axis};
use crate::measurement::PointResult;
use crate::trace::{Plot, Scale, Series, Style};

const MICRO: f64 = 1e6;

/// One picture of the sight for each axis of the mirror, one of the departures.
pub(super) fn pictures(keys: &Keys, cases: &[Case], points: &[PointResult]) -> Vec<Plot> {
    let all: Vec<(&Case, &PointResult)> = cases.iter().zip(points).collect();
    let mut plots: Vec<Plot> = (0..MIRROR_AXES.len()).filter_map(|axis| sight(keys, axis, &all)).collect();
    plots.extend(departures(&all));
    plots
}

fn sight(keys: &Keys, axis: usize, all: &[(&Case, &PointResult)]) -> Option<Plot> {
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
