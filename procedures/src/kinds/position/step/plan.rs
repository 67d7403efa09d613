//! Points: one an elevation and height.

use super::keys::Keys;
use crate::axis::{Axes, Axis};
use crate::case::{Case, Mode, Request, Segment};
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned::{self, ELEVATION, Elevation};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{STEP_OVERSHOOT_RATIO, Stimulus};

/// Label of steps away from the start.
pub(super) const THERE: &str = "there";
/// Label of steps back.
pub(super) const BACK: &str = "back";
/// Condition of a point: height of its steps.
pub(super) const STEP: &str = "step";
/// Rest before the first step.
const REST_S: f64 = 2.0;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let limits = positioned::limits_of(axis, axes)?;
    let [low, high] = limits.soft_limits_rad;
    let elevation = Elevation::of(axis, axes);
    // Without an elevation there is one point for each height.
    let elevations = if elevation.axis().is_some() { keys.elevations_rad.as_slice() } else { &[0.0] };
    let mut cases = Vec::new();
    let mut mistakes = Vec::new();
    for &elevation_rad in elevations {
        let outside = |at: &Axis| positioned::outside(ELEVATION, elevation_rad, &at.name, &at.limits);
        mistakes.extend(elevation.axis().and_then(outside));
        for &height_rad in &keys.heights_rad {
            let start_rad = if elevation.is_own() { elevation_rad } else { positioned::rest_rad(limits) };
            let upwards = start_rad <= 0.5 * (low + high);
            let target_rad = start_rad + if upwards { height_rad } else { -height_rad };
            let farthest_rad = target_rad + STEP_OVERSHOOT_RATIO * (target_rad - start_rad);
            mistakes.extend(positioned::outside("a step to", farthest_rad, axis, limits));
            let asked = elevation.axis().map(|_| positioned::request(ELEVATION, elevation_rad, Q::Angle));
            let step = positioned::request(STEP, height_rad, Q::Angle);
            let requested: Vec<Request> = asked.into_iter().chain([step]).collect();
            cases.push(Case {
                point: positioned::point_name(&requested),
                axis: axis.to_owned(),
                requested,
                start_pose_rad: positioned::start_pose(axes, axis, start_rad, elevation_rad),
                segments: segments(keys, start_rad, target_rad),
                ..Case::default()
            });
        }
    }
    if mistakes.is_empty() { Ok(cases) } else { Err(mistakes) }
}

fn segments(keys: &Keys, start_rad: f64, target_rad: f64) -> Vec<Segment> {
    let step = |label: &str, target_rad: f64| Segment {
        stimulus: Stimulus::Step { target_rad },
        ..Segment::hold(label, Mode::Position, keys.hold_s)
    };
    let mut all = positioned::take_place(start_rad, REST_S).to_vec();
    for _ in 0..keys.repeats {
        all.extend([step(THERE, target_rad), step(BACK, start_rad)]);
    }
    positioned::ended(all)
}
