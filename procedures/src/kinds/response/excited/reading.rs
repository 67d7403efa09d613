//! From the window of a point to its amplitudes, with the elevation at which they were taken.

use super::{Course, ELEVATION, Excited, LEVEL, Measured, Record, measure};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::position::positioned::Elevation;
use crate::log::Window;
use crate::measurement::{Condition, Evidence};
use crate::quantity::QuantityKind as Q;

/// A point whose elevation is off by more than this, beyond its strokes, says nothing of the one that was asked for.
const ELSEWHERE_RAD: f64 = 1.0 * std::f64::consts::PI / 180.0;

/// What a record of a point holds before any response is computed of it.
#[derive(Clone, Debug)]
pub(in crate::kinds) struct Reading {
    pub(in crate::kinds) measured: Measured,
    /// Mean over time; `None` where the log does not say.
    pub(in crate::kinds) elevation_rad: Option<f64>,
    pub(in crate::kinds) evidence: Vec<Evidence>,
}

/// Reads a point.
pub(in crate::kinds) fn read(
    keys: &Excited,
    case: &Case,
    window: &Window,
    axes: &Axes,
) -> Result<Reading, String> {
    let axis = case.axis.as_str();
    let limits = axes.limits(axis)?;
    let record = Record::new(axis, window, axes)?;
    let elevation = Elevation::of(axis, axes);
    // Middle of the strokes that were planned.
    let middle_rad = match elevation.is_own() {
        true => case.requested(ELEVATION).unwrap_or(0.0),
        false => keys.background.middle_rad,
    };
    let level_v = case.requested(LEVEL).ok_or("the plan of the point has no level")?;
    let course = Course::new(keys, limits, middle_rad, level_v).map_err(|d| d.message)?;
    let measured = measure(keys, case, window, &record, &course, limits)?;
    let elevation_rad = match elevation {
        Elevation::Own(_) => Some(measured.angle_rad[2]),
        Elevation::Carried(held) => {
            window.rows(&format!("/{}", held.name)).and_then(|rows| rows.column("position_rad")).map(mean)
        }
        Elevation::Nobody => None,
    };
    let asked = case.requested(ELEVATION);
    let reached = elevation_rad;
    if let Some((asked, reached)) = asked.zip(reached)
        && (reached - asked).abs() > keys.background.half_width_rad + ELSEWHERE_RAD
    {
        let [asked, reached] = [asked, reached].map(|angle| Q::Angle.format(angle));
        return Err(format!("taken at an elevation of {reached}, asked for {asked}"));
    }
    Ok(Reading { measured, elevation_rad, evidence: record.evidence() })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The conditions that were asked for, with what was reached of them.
pub(in crate::kinds) fn conditions(
    case: &Case,
    elevation_rad: Option<f64>,
    measured: Option<&Measured>,
) -> Vec<Condition> {
    Condition::reached(case, |request| match request.name.as_str() {
        ELEVATION => elevation_rad,
        LEVEL => measured.map(|measured| request.value * measured.reached_ratio),
        // The bench sets them.
        _ => Some(request.value),
    })
}
