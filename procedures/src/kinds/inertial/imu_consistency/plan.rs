//! The points: azimuth at each elevation, then elevation.

use super::keys::Keys;
use crate::axis::Axes;
use crate::case::{Case, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::optics::frames;
use crate::kinds::position::positioned::{gimbal_for, limits_of};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{ProfileLimits, Stimulus};

/// Label of the segment that is evaluated.
pub(super) const SPIN: &str = "spin";
const SETTLE: &str = "settle";
const SETTLE_S: f64 = 1.0;
/// The acceleration of a turn grows within this time: slow against the first modes of the structure.
const RISE_S: f64 = 0.2;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    limits_of(axis, axes)?;
    let [outer, inner] = gimbal_for("imu-consistency", axes)?.names();
    let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
    let mut cases: Vec<Case> = keys
        .elevations_rad
        .iter()
        .map(|&elevation| {
            let point = format!("azimuth, elevation={}", Q::Angle.format(elevation));
            let asked = Request { name: "elevation".to_owned(), value: elevation, kind: Q::Angle };
            let poses = [keys.span_rad[0], elevation];
            Case { requested: vec![asked], ..case(keys, axes, point, (outer, keys.span_rad), poses) }
        })
        .collect();
    if let Some(span) = keys.elevation_span_rad {
        let poses = [middle(keys.span_rad), span[0]];
        cases.push(case(keys, axes, "elevation".to_owned(), (inner, span), poses));
    }
    Ok(cases)
}

/// Strokes of an axis over a span, with azimuth and elevation at these poses before.
fn case(
    keys: &Keys,
    axes: &Axes,
    point: String,
    (axis, [from_rad, to_rad]): (&str, [f64; 2]),
    gimbal_rad: [f64; 2],
) -> Case {
    let most = axes.get(axis).map_or(f64::INFINITY, |limits| limits.max_acceleration_rad_per_s2);
    let acceleration_rad_per_s2 = keys.acceleration_rad_per_s2.min(most);
    let most = axes.get(axis).map_or(f64::INFINITY, |limits| limits.max_jerk_rad_per_s3);
    let limits = ProfileLimits {
        velocity_rad_per_s: keys.velocity_rad_per_s,
        acceleration_rad_per_s2,
        jerk_rad_per_s3: (acceleration_rad_per_s2 / RISE_S).min(most),
    };
    let stimulus = Stimulus::Reversals { from_rad, to_rad, limits, cycles: keys.cycles };
    let lasts_s = stimulus.duration_s(from_rad).unwrap_or(0.0);
    let spin =
        Segment { stimulus, then: Then::Stop, ..Segment::hold(SPIN, Mode::Position, 1.05 * lasts_s + 1.0) };
    Case {
        point,
        axis: axis.to_owned(),
        start_pose_rad: frames::poses(axes, gimbal_rad),
        segments: vec![Segment::hold(SETTLE, Mode::Position, SETTLE_S), spin],
        ..Case::default()
    }
}
