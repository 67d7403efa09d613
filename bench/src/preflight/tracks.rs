//! Segments in which an axis follows a target: nobody plans where that goes, the bounds of the point hold the axis.

use procedures::case::{Case, Segment};

use super::course::{Instant, Stretch};
use crate::model::axis::RigAxis;

/// The ends of what the point's bounds allow, at the speed that they allow, both outwards; and where a stop from there may
/// end. Without bounds it is all of the travel at the rig's own limits, from where no stop fits.
pub(super) fn followed<'a>(case: &Case, segment: &Segment, axis: &RigAxis) -> (Stretch<'a>, [f64; 2]) {
    let model = &axis.guard.stop;
    let start_rad = case.start_pose_rad.get(&axis.name).copied().unwrap_or(0.0);
    let (ends_rad, speed) = match case.bounds {
        Some(b) => ([start_rad - b.displacement_rad, start_rad + b.displacement_rad], b.speed_rad_per_s),
        None => (model.soft_limits_rad, axis.guard.max_velocity_rad_per_s),
    };
    let acceleration = case.target.map_or(0.0, |t| {
        let accelerations = t.course.accelerations_rad_per_s2();
        accelerations[usize::from(axis.carried_by.is_some())]
    });
    let instants = [(ends_rad[0], -1.0), (ends_rad[1], 1.0)].map(|(position_rad, outwards)| Instant {
        for_s: 0.5 * segment.at_most_s,
        position_rad,
        rate_rad_per_s: outwards * speed,
        acceleration_rad_per_s2: outwards * acceleration,
        ..Instant::default()
    });
    let stop_rad = model.controlled_from(speed, acceleration, model.deceleration_rad_per_s2).angle_rad;
    let after_rad = [ends_rad[0] - stop_rad, ends_rad[1] + stop_rad];
    (Stretch::Stroke { instants: instants.to_vec(), repeats: 1 }, after_rad)
}
