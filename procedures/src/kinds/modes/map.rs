//! Map of the modes: frequency over elevation.

use super::Keys;
use super::expected::Place;
use crate::measurement::PointResult;
use crate::trace::{Plot, Scale, Series, Style};

/// Departure from the calculation that the requirements allow (ours).
const ALLOWED: f64 = 0.08;
/// Expanded uncertainty in pictures: k = 2.
const COVERAGE: f64 = 2.0;
/// Nodes of an expected curve over the elevations measured.
const NODES: usize = 46;

/// A visible mode of a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Number of the expected mode, 0 if none.
    pub(super) mode: usize,
    pub(super) elevation_rad: f64,
    pub(super) hz: f64,
    pub(super) hz_u: f64,
    pub(super) gyro: f64,
    pub(super) encoder: f64,
}

/// All visible modes, in the order of the points.
pub(super) fn entries(points: &[PointResult]) -> Vec<Entry> {
    let of = |p: &PointResult| -> Vec<Entry> {
        let column = |name: &str| p.numbers.get(name).map(Vec::as_slice).unwrap_or_default();
        let Some(&elevation_rad) = column("elevation").first() else { return Vec::new() };
        let columns = ["mode", "hz", "hz-u", "gyro", "encoder"].map(column);
        let rows = columns.iter().map(|c| c.len()).min().unwrap_or(0);
        let entry = |k: usize| Entry {
            mode: columns[0][k] as usize,
            elevation_rad,
            hz: columns[1][k],
            hz_u: columns[2][k],
            gyro: columns[3][k],
            encoder: columns[4][k],
        };
        (0..rows).map(entry).collect()
    };
    points.iter().flat_map(of).collect()
}

/// Frequencies found with error bars over what was calculated, ± 8 %, or over their bands.
pub(super) fn plot(keys: &Keys, entries: &[Entry]) -> Option<Plot> {
    let degrees = |e: &Entry| e.elevation_rad.to_degrees();
    let low = entries.iter().map(degrees).fold(f64::INFINITY, f64::min).min(0.0);
    let high = entries.iter().map(degrees).fold(f64::NEG_INFINITY, f64::max).max(90.0);
    if entries.is_empty() {
        return None;
    }
    let x: Vec<f64> = (0..NODES).map(|k| low + (high - low) * k as f64 / (NODES - 1) as f64).collect();
    let mut series = Vec::new();
    for expected in &keys.expected {
        let ranges = x.iter().map(|deg| expected.range_hz(deg.to_radians()));
        let (middle, half): (Vec<f64>, Vec<f64>) = match expected.place {
            Place::Curve(_) => ranges.map(|[f, _]| (f, ALLOWED * f)).unzip(),
            Place::Band(_) => ranges.map(|[a, b]| (0.5 * (a + b), 0.5 * (b - a))).unzip(),
        };
        let label = match expected.place {
            Place::Curve(_) => format!("mode {} calculated, 8 %", expected.mode),
            Place::Band(_) => format!("mode {} expected", expected.mode),
        };
        series.push(Series::new(label, Style::Band, x.clone(), middle).with_u(half));
    }
    for mode in std::iter::once(0).chain(keys.expected.iter().map(|e| e.mode)) {
        let own: Vec<&Entry> = entries.iter().filter(|e| e.mode == mode).collect();
        if own.is_empty() {
            continue;
        }
        let (label, style) = match mode {
            0 => ("not expected".to_owned(), Style::Excluded),
            _ => (format!("mode {mode}, U (k = 2)"), Style::Markers),
        };
        let at = own.iter().map(|e| degrees(e)).collect();
        let found = own.iter().map(|e| e.hz).collect();
        let u = own.iter().map(|e| COVERAGE * e.hz_u).collect();
        series.push(Series::new(label, style, at, found).with_u(u));
    }
    let (elevation, hz) = (Scale::linear("elevation", "deg"), Scale::linear("frequency", "Hz"));
    Some(Plot { series, ..Plot::new("mode-map", "Modes over elevation", elevation, hz) })
}
