//! Points: one a reference.

use super::keys::Keys;
use crate::axis::Axes;
use crate::case::{Case, Mode, Request, Segment};
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned::{self, Elevation};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{ProfileLimits, Stimulus};

/// Label of segments that are evaluated.
pub(super) const FOLLOWED: &str = "followed";
/// Condition of the ramp.
pub(super) const VELOCITY: &str = "velocity";
/// Rest before and after each reference.
const REST_S: f64 = 1.0;
/// Slow references need no more jerk: it is reached within this time.
const JERK_S: f64 = 0.2;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let limits = positioned::limits_of(axis, axes)?;
    let mut mistakes = Vec::new();
    let elevation = Elevation::of(axis, axes);
    mistakes.extend(elevation.held_outside(keys.elevation_rad));
    let mut cases = Vec::new();
    for (name, velocity, start_rad, segments) in references(keys) {
        let planned = Case {
            axis: axis.to_owned(),
            start_pose_rad: positioned::start_pose(axes, axis, start_rad, keys.elevation_rad),
            segments: positioned::ended(segments),
            ..Case::default()
        };
        for end_rad in planned.envelope().position_rad {
            mistakes.extend(positioned::outside(&format!("the {name} reaches"), end_rad, axis, limits));
        }
        let requested = requests(elevation, keys, velocity);
        let point = format!("{name} {}", positioned::point_name(&requested));
        cases.push(Case { point: point.trim_end().to_owned(), requested, ..planned });
    }
    if mistakes.is_empty() { Ok(cases) } else { Err(mistakes) }
}

fn requests(elevation: Elevation<'_>, keys: &Keys, velocity: Option<f64>) -> Vec<Request> {
    let velocity = velocity.map(|v| positioned::request(VELOCITY, v, Q::AngularVelocity));
    velocity.into_iter().chain(elevation.held_request(keys.elevation_rad)).collect()
}

/// Whether a point follows the ramp: only the ramp has a velocity of its own.
pub(super) fn is_ramp(case: &Case) -> bool {
    case.requested(VELOCITY).is_some()
}

type Reference = (&'static str, Option<f64>, f64, Vec<Segment>);

fn references(keys: &Keys) -> Vec<Reference> {
    let mut all = Vec::new();
    if let Some(ramp) = &keys.ramp {
        let [from_rad, to_rad] = ramp.span_rad;
        let limits = ProfileLimits {
            velocity_rad_per_s: ramp.velocity_rad_per_s,
            acceleration_rad_per_s2: ramp.acceleration_rad_per_s2,
            jerk_rad_per_s3: ramp.acceleration_rad_per_s2 / JERK_S,
        };
        let mut segments = positioned::take_place(from_rad, REST_S).to_vec();
        segments.extend([
            positioned::move_to(FOLLOWED, from_rad, to_rad, limits),
            positioned::stay("between", REST_S),
            positioned::move_to(FOLLOWED, to_rad, from_rad, limits),
        ]);
        all.push(("ramp", Some(ramp.velocity_rad_per_s), from_rad, segments));
    }
    if let Some(sine) = &keys.sine {
        let stimulus = Stimulus::Sine {
            amplitude_rad: sine.amplitude_rad,
            frequency_hz: sine.frequency_hz,
            cycles: sine.cycles,
            fade_s: sine.fade_s,
        };
        let middle_rad = sine.middle_rad;
        all.push(("sine", None, middle_rad, followed(stimulus, middle_rad)));
    }
    if let Some(knots) = &keys.path {
        let start_rad = knots.first().map_or(0.0, |knot| knot.position_rad);
        let stimulus = Stimulus::Trajectory { knots: knots.clone() };
        all.push(("path", None, start_rad, followed(stimulus, start_rad)));
    }
    all
}

fn followed(stimulus: Stimulus, start_rad: f64) -> Vec<Segment> {
    let at_most_s = stimulus.duration_s(start_rad).unwrap_or(0.0) + 1e-3;
    let followed = Segment { stimulus, ..Segment::hold(FOLLOWED, Mode::Position, at_most_s) };
    positioned::take_place(start_rad, REST_S).into_iter().chain([followed]).collect()
}
