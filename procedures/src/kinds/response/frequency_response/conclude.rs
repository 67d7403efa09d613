//! Over all points: measurements as they are, pictures over elevation, remarks.

use super::{Keys, Response, coupling, gains, pictures};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::response::excited::notes;
use crate::measurement::{Conclusion, Measurement, PointResult};
use crate::trace::Plot;

pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let mut measurements: Vec<Measurement> = points.iter().flat_map(|p| p.measurements.clone()).collect();
    let mut plots: Vec<Plot> = points.iter().flat_map(|p| p.plots.clone()).collect();
    let loops = [
        (Response::VelocityLoop, "velocity-bandwidth", "Bandwidth of the velocity loop over elevation"),
        (Response::VelocityLoop, "velocity-gain-margin", "Gain margin of the velocity loop over elevation"),
        (Response::VelocityLoop, "velocity-phase-margin", "Phase margin of the velocity loop over elevation"),
        (Response::TrackLoop, "track-bandwidth", "Bandwidth of the coarse track loop over elevation"),
        (Response::TrackLoop, "track-gain-margin", "Gain margin of the coarse track loop over elevation"),
        (Response::TrackLoop, "track-phase-margin", "Phase margin of the coarse track loop over elevation"),
    ];
    let asked = loops.into_iter().filter(|(response, ..)| keys.asks_for(*response));
    plots
        .extend(asked.filter_map(|(_, measurand, title)| pictures::over_elevation(measurand, title, points)));
    if keys.asks_for(Response::CrossAxis) {
        plots.extend(pictures::coupling(points));
        measurements.extend(coupling::conclude(cases, points));
    }
    if keys.asks_for(Response::Plant) && keys.excited.gain_ratios.len() > 1 {
        measurements.extend(gains::departures(cases, points));
        plots.extend(gains::pictures(cases, points));
    }
    let remarks = cases.first().map(|case| notes(&keys.excited, &case.axis, axes)).unwrap_or_default();
    Conclusion { measurements, plots, remarks, ..Conclusion::default() }
}
