//! Map of the modes: frequency over elevation.

use super::Keys;
use super::expected::{Expected, Place};
use super::point::{PointModes, VisibleMode};
use crate::kinds::response::excited::ELEVATION;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;
use crate::trace::{Plot, Scale, Series, Style};

/// Expanded uncertainty in pictures: k = 2.
const COVERAGE: f64 = 2.0;
/// Nodes of an expected curve over the elevations measured.
const NODES: usize = 46;

/// A visible mode with the elevation at which it was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<'a> {
    pub(super) elevation_rad: f64,
    pub(super) mode: &'a VisibleMode,
}

/// All visible modes, in the order of the points.
pub(super) fn entries(points: &[PointResult]) -> Vec<Entry<'_>> {
    let found = points.iter().filter_map(|point| point.reduced.get::<PointModes>());
    let entries = found.flat_map(|found| {
        let elevation_rad = found.elevation_rad;
        found.visible.iter().map(move |mode| Entry { elevation_rad, mode })
    });
    entries.collect()
}

/// Frequencies found with error bars, over what was calculated or over their bands.
pub(super) fn plot(keys: &Keys, entries: &[Entry<'_>]) -> Option<Plot> {
    let degrees = |e: &Entry<'_>| e.elevation_rad.to_degrees();
    let low = entries.iter().map(degrees).fold(f64::INFINITY, f64::min).min(0.0);
    let high = entries.iter().map(degrees).fold(f64::NEG_INFINITY, f64::max).max(90.0);
    if entries.is_empty() {
        return None;
    }
    let x: Vec<f64> = (0..NODES).map(|k| low + (high - low) * k as f64 / (NODES - 1) as f64).collect();
    let mut series = Vec::new();
    for expected in &keys.expected {
        let ranges = x.iter().map(|deg| expected.range_hz(deg.to_radians()));
        let (middle, half): (Vec<f64>, Vec<f64>) =
            ranges.map(|[a, b]| (0.5 * (a + b), 0.5 * (b - a))).unzip();
        let series_of = |label: String, style| Series::new(label, style, x.clone(), middle.clone());
        series.push(match expected.place {
            Place::Curve(_) => series_of(format!("mode {} calculated", expected.mode), Style::Fit),
            Place::Band(_) => series_of(format!("mode {} expected", expected.mode), Style::Band).with_u(half),
        });
    }
    for mode in std::iter::once(None).chain(keys.expected.iter().map(|e| Some(e.mode))) {
        let own: Vec<&Entry<'_>> = entries.iter().filter(|e| e.mode.expected == mode).collect();
        if own.is_empty() {
            continue;
        }
        let (label, style) = match mode {
            None => ("not expected".to_owned(), Style::Excluded),
            Some(mode) => (format!("mode {mode}, U (k = 2)"), Style::Markers),
        };
        let at = own.iter().map(|e| degrees(e)).collect();
        let found = own.iter().map(|e| e.mode.frequency_hz).collect();
        let u = own.iter().map(|e| COVERAGE * e.mode.frequency_u_hz).collect();
        series.push(Series::new(label, style, at, found).with_u(u));
    }
    let elevation = Scale::linear("elevation", "deg");
    let hz = Scale::linear("frequency", "Hz");
    Some(Plot { series, ..Plot::new("mode-map", "Modes over elevation", elevation, hz) })
}

/// What each expected mode is judged by over elevation, with the limits of its requirement: departures from the
/// calculation, or frequencies where a band is expected.
pub(super) fn judged(keys: &Keys, points: &[PointResult]) -> Vec<Plot> {
    let departures = |expected: &Expected| {
        let measurand = expected.measurand();
        let kind = expected.kind();
        let mine = |p: &PointResult| {
            let m = p.measurements.iter().find(|m| m.measurand == measurand)?;
            let elevation_rad = m.conditions.iter().find(|c| c.name == ELEVATION)?.achieved?;
            let value = kind.to_display(m.value?);
            Some([Q::Angle.to_display(elevation_rad), value, COVERAGE * kind.to_display(m.u)])
        };
        let found: Vec<[f64; 3]> = points.iter().filter_map(mine).collect();
        let column = |c: usize| found.iter().map(|row| row[c]).collect::<Vec<f64>>();
        let y = match expected.place {
            Place::Curve(_) => Scale::linear("departure", kind.display_unit()),
            Place::Band(_) => Scale::linear("frequency", kind.display_unit()),
        };
        let series = Series::new("measured, U (k = 2)", Style::Markers, column(0), column(1));
        (!found.is_empty()).then(|| Plot {
            series: vec![series.with_u(column(2))],
            limits_of: Some(measurand.to_owned()),
            ..Plot::new(
                format!("{measurand}-over-elevation"),
                format!("Mode {}: {}", expected.mode, y.label),
                Scale::linear("elevation", Q::Angle.display_unit()),
                y,
            )
        })
    };
    keys.expected.iter().filter_map(departures).collect()
}
