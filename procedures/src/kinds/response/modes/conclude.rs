//! Over all points: the map, and what was found but not expected, expected but not found.

use super::map::{self, Entry};
use super::point::VisibleMode;
use super::{Keys, pictures};
use crate::axis::Axes;
use crate::case::Case;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::trace::Plot;

pub(super) fn conclude(keys: &Keys, _cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
    let entries = map::entries(points);
    let mut plots: Vec<Plot> =
        map::plot(keys, &entries).into_iter().chain(map::judged(keys, points)).collect();
    // One diagram shows how the modes were told from noise; the others are alike.
    let mut diagrams = 0;
    for plot in points.iter().flat_map(|p| &p.plots) {
        let is_diagram = plot.id.starts_with(pictures::DIAGRAM);
        diagrams += usize::from(is_diagram);
        if !is_diagram || diagrams == 1 {
            plots.push(plot.clone());
        }
    }
    let remarks = [missed(keys, points), unexpected(&entries), changed(keys, &entries)];
    Conclusion { plots, remarks: remarks.concat(), ..Conclusion::collected(points) }
}

fn listed(items: &[String]) -> String {
    items.join(", ")
}

fn degrees(rad: f64) -> String {
    Q::Angle.format(rad)
}

/// Expected, not found.
fn missed(keys: &Keys, points: &[PointResult]) -> Vec<String> {
    let mut all = Vec::new();
    for expected in &keys.expected {
        let of_mode = |p: &&PointResult| {
            p.inconclusive.is_none()
                && p.measurements.iter().any(|m| m.measurand == expected.measurand() && m.value.is_none())
        };
        let names: Vec<String> = points.iter().filter(of_mode).map(|p| p.point.clone()).collect();
        if !names.is_empty() {
            all.push(format!(
                "Mode {} was expected and is not visible at {}.",
                expected.mode,
                names.join("; ")
            ));
        }
    }
    all
}

/// Found, not expected.
fn unexpected(entries: &[Entry<'_>]) -> Vec<String> {
    let strange: Vec<String> = entries
        .iter()
        .filter(|e| e.mode.expected.is_none())
        .map(|e| {
            let VisibleMode { frequency_hz, gyro, encoder, .. } = e.mode;
            let at = degrees(e.elevation_rad);
            format!("{frequency_hz:.2} Hz at {at} (participation gyro {gyro:.3}, encoder {encoder:.3})")
        })
        .collect();
    if strange.is_empty() {
        Vec::new()
    } else {
        vec![format!("Found and not expected: {}.", listed(&strange))]
    }
}

/// Modes whose shape turns over from one elevation to the next: what carries one number may be two modes.
fn changed(keys: &Keys, entries: &[Entry<'_>]) -> Vec<String> {
    let mut all = Vec::new();
    for expected in keys.expected.iter().filter(|e| !e.gyro_only) {
        let is_own = |e: &&Entry<'_>| e.mode.expected == Some(expected.mode);
        let own: Vec<&Entry<'_>> = entries.iter().filter(is_own).collect();
        let turns = own.windows(2).filter(|pair| {
            let side = |e: &Entry<'_>| (e.mode.gyro * e.mode.encoder).signum();
            side(pair[0]) * side(pair[1]) < 0.0
        });
        all.extend(turns.map(|pair| {
            let [from, to] = [pair[0], pair[1]].map(|e| degrees(e.elevation_rad));
            format!(
                "Mode {} turns gyro against encoder between {from} and {to}: modes may have crossed there.",
                expected.mode
            )
        }));
    }
    all
}
