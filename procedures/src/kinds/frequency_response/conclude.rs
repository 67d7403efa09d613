//! Over all points: measurements as they are, pictures over elevation, remarks.

use super::{Keys, Response, pictures};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::excited::{Course, LEVEL};
use crate::measurement::{Conclusion, PointResult};
use crate::trace::Plot;

pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let measurements = points.iter().flat_map(|p| p.measurements.clone()).collect();
    let mut plots: Vec<Plot> = points.iter().flat_map(|p| p.plots.clone()).collect();
    if keys.asks_for(Response::VelocityLoop) {
        plots.extend(
            [
                ("velocity-bandwidth", "Bandwidth of the velocity loop over elevation"),
                ("velocity-gain-margin", "Gain margin of the velocity loop over elevation"),
                ("velocity-phase-margin", "Phase margin of the velocity loop over elevation"),
            ]
            .into_iter()
            .filter_map(|(measurand, title)| pictures::over_elevation(measurand, title, points)),
        );
    }
    if keys.asks_for(Response::CrossAxis) {
        plots.extend(pictures::coupling(points));
    }
    let remarks = cases.first().map(|case| motion(keys, case, axes)).unwrap_or_default();
    Conclusion { measurements, plots, remarks, ..Conclusion::default() }
}

/// How the axis moved, and where cogging lay.
fn motion(keys: &Keys, case: &Case, axes: &Axes) -> Vec<String> {
    let Some(limits) = axes.get(&case.axis) else { return Vec::new() };
    let level_v = case.requested(LEVEL).unwrap_or_default();
    let middle = keys.excited.background.middle_rad;
    let Ok(course) = Course::new(&keys.excited, limits, middle, level_v) else { return Vec::new() };
    if course.velocity_rad_per_s == 0.0 {
        return vec!["The axis was excited from rest.".to_owned()];
    }
    let cogging: Vec<String> = course.cogging_hz(limits).iter().map(|hz| format!("{hz:.2}")).collect();
    vec![format!(
        "The axis slid at {:.3} rad/s under windows of {} s; cogging at {} Hz, no lines within 0.3 Hz of it.",
        course.velocity_rad_per_s,
        course.window_s,
        cogging.join(", ")
    )]
}
