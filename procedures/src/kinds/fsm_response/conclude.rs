//! Over all points: channels against each other, stroke, gauge against autocollimator, harmonics, remarks.

use super::keys::Keys;
use super::measure;
use super::plan::{MEASURE, POSITION, TONE, mirror_axis};
use crate::case::Case;
use crate::kinds::frames::MIRROR_AXES;
use crate::measurement::{Conclusion, Measurement, PointResult};

pub(super) mod channels;
pub(super) mod harmonics;
mod plots;
pub(super) mod stroke;

/// A point with its plan.
type Point<'a> = (&'a Case, &'a PointResult);

/// The points of one axis of the mirror that hold a segment of this label.
fn of_axis<'a>(all: &[Point<'a>], axis: usize, label: &'static str) -> impl Iterator<Item = Point<'a>> {
    let mine = move |(case, _): &Point<'a>| {
        mirror_axis(case) == Some(axis) && case.segments.iter().any(|s| s.label == label)
    };
    all.iter().copied().filter(mine)
}

/// Measurements, pictures and remarks.
pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult]) -> Conclusion {
    let all: Vec<Point<'_>> = cases.iter().zip(points).collect();
    let mut conclusion = Conclusion::default();
    for &axis in &keys.mirror_axes {
        let responses: Vec<Point<'_>> = of_axis(&all, axis, MEASURE).collect();
        conclusion.measurements.extend(responses.iter().flat_map(|(_, result)| result.measurements.clone()));
        if keys.channels.len() > 1 {
            for &level_v in &keys.levels_v {
                conclusion.measurements.extend(channels::difference(keys, &responses, level_v));
            }
        }
        for point in of_axis(&all, axis, POSITION) {
            conclusion.measurements.extend(stroke::measurements(keys, point));
            conclusion.plots.extend(stroke::plot(axis, point));
        }
        for point in of_axis(&all, axis, TONE) {
            let (measurements, remarks) = harmonics::told(point);
            conclusion.measurements.extend(measurements);
            conclusion.remarks.extend(remarks);
        }
        conclusion.plots.extend(plots::responses(axis, &responses));
        conclusion.plots.extend(plots::open_loops(keys, &responses));
        conclusion.remarks.extend(remark(axis, &conclusion.measurements));
    }
    conclusion
}

/// A resonance of the support must be noticed.
fn remark(axis: usize, measurements: &[Measurement]) -> Option<String> {
    let name = MIRROR_AXES[axis];
    let mine = |m: &&Measurement| m.measurand == measure::RESONANCE && m.axis == name && m.value.is_some();
    let found: Vec<f64> = measurements.iter().filter(mine).filter_map(|m| m.value).collect();
    let first = found.first()?;
    let (low, high) = found.iter().fold((*first, *first), |(l, h), v| (l.min(*v), h.max(*v)));
    Some(format!(
        "{name}: a resonance of what the mirror stands on at {low:.1} … {high:.1} Hz in {} responses; its lines are left out",
        found.len()
    ))
}
