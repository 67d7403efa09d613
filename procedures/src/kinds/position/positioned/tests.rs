//! Windows for kinds that move an axis, made of a formula.

use super::*;
use crate::log::{Channel, EndedBy, PointStatus, Rows, SegmentSpan, Topic, Width, Window};
use crate::procedure::sample::sample_axes;

/// The sample rig with an elevation axis.
pub(in crate::kinds) fn with_elevation() -> Axes {
    let az = AxisLimits { loop_rate_hz: 4000.0, ..sample_axes().all()[0].limits.clone() };
    let el = AxisLimits {
        travel_rad: [-10_f64.to_radians(), 90_f64.to_radians()],
        soft_limits_rad: [-9.5_f64.to_radians(), 89.5_f64.to_radians()],
        ..az.clone()
    };
    Axes::stacked([("az".to_owned(), az), ("el".to_owned(), el)])
}

/// Adds an elevation axis that is held at a place.
pub(in crate::kinds) fn hold_elevation(window: &mut Window, at_rad: f64) {
    let time_s = window.topics[0].time_s.clone();
    // It comes from elsewhere before the point begins.
    let start_s = window.segments[0].start_s;
    let time_s: Vec<f64> = [start_s - 2.0, start_s - 1.0].into_iter().chain(time_s).collect();
    let place = |t: &f64| if *t < start_s { at_rad - 1.0 } else { at_rad };
    let columns = vec![("position_rad", time_s.iter().map(place).collect())];
    window.topics.push(crate::synthetic::rows("/el", &time_s, columns));
}

/// What a point reached of a condition.
pub(in crate::kinds) fn reached(result: &PointResult, name: &str) -> Option<f64> {
    result.measurements[0].conditions.iter().find(|c| c.name == name)?.achieved
}

/// A window in which the axis is where `place` says: by segment, time since its start, and where it was before. Noise of
/// this standard deviation is a sum of sines that share no period.
pub(in crate::kinds) fn window_of(
    case: &Case,
    rate_hz: f64,
    noise_rad: f64,
    place: &mut dyn FnMut(&Segment, f64, f64) -> f64,
) -> Window {
    const NAMES: [&str; 5] = [
        "position_rad",
        "position_setpoint_rad",
        "velocity_feedback_rad_per_s",
        "torque_command_nm",
        "torque_nm",
    ];
    let mut time_s = Vec::new();
    let mut columns = vec![Vec::new(); NAMES.len()];
    let mut segments = Vec::new();
    let mut start_s = 1.0;
    let mut before = case.start_pose_rad[&case.axis];
    let mut commanded = before;
    for (index, segment) in case.segments.iter().enumerate() {
        let lasts_s = segment.stimulus.duration_s(commanded).unwrap_or(segment.at_most_s);
        let prepared = segment.stimulus.prepare(commanded);
        let mut here = before;
        for k in 0..(lasts_s * rate_hz).round() as u32 {
            let t = f64::from(k) / rate_hz;
            let at = start_s + t;
            here = place(segment, t, before);
            let rate = (place(segment, t + 1e-5, before) - here) / 1e-5;
            let wave = (71.0 * at).sin() + (113.3 * at + 1.0).sin() + (197.7 * at + 2.0).sin();
            time_s.push(at);
            let row =
                [here + noise_rad * wave / 1.5_f64.sqrt(), prepared.at(t).position_rad, rate, 100.0, 100.0];
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
        let ended_by = EndedBy::Completed;
        let end_s = start_s + lasts_s;
        segments.push(SegmentSpan { segment: index, start_s, end_s, start_position_rad: before, ended_by });
        (before, commanded, start_s) = (here, prepared.at(lasts_s).position_rad, end_s);
    }
    let channel = |name: &&str| Channel { name: (*name).to_owned(), unit: String::new(), width: Width::F64 };
    let topic = Topic {
        name: format!("/{}", case.axis),
        message: "bench_msgs/msg/Axis".to_owned(),
        channels: NAMES.iter().map(channel).collect(),
    };
    let status = PointStatus::Completed;
    let (trips, stops, left) = Default::default();
    let topics = vec![Rows { topic, time_s, columns }];
    Window { status, trips, stops, left, ..Window::completed(topics, segments) }
}
