//! Axes that follow a target, from the frame of the camera to the torque.

use procedures::case::{Bounds, Tracks};
use procedures::target::{Target, TargetCourse};

use super::*;

/// Both axes, or azimuth alone, after a target that begins to move 2 s after the start.
fn track(course: TargetCourse, azimuth_rad: f64, tracks: Tracks) -> (Case, UnitSettings) {
    let acquire = Segment {
        until: Some(Condition::Locked { for_s: 0.3 }),
        tracks: Some(tracks),
        ..Segment::hold("acquire", Mode::Track, 2.0)
    };
    let follow = Segment { tracks: Some(tracks), ..Segment::hold("follow", Mode::Track, 4.0) };
    let segments = vec![acquire, follow, segment(Mode::Position, slow_move(0.0), 3.0, Then::Hold)];
    let bounds = Some(Bounds { displacement_rad: 0.5, speed_rad_per_s: 0.4 });
    let target = Some(Target { course, azimuth_rad, elevation_rad: 0.0, stands_s: 2.0 });
    let wanted = Case { bounds, target, ..case(segments) };
    let unit = crate::site::sim_unit_for_case(&UnitSettings::default(), &wanted, &sim()).into_owned();
    (wanted, unit)
}

fn sweep(rate: f64) -> TargetCourse {
    TargetCourse::Sweep { azimuth_rad_per_s: rate, elevation_rad_per_s: rate, leg_s: 20.0, turn_s: 2.0 }
}

#[test]
fn both_axes_follow_a_target_and_go_on_to_a_move_afterwards() {
    let tracks = Tracks { others: true, ..Tracks::default() };
    let (wanted, unit) = track(sweep(0.02), 1e-3, tracks);
    let (outcome, window) = run_case(&wanted, &unit, &[], 0);
    assert_eq!(outcome.status, PointStatus::Completed, "{outcome:?}");
    assert_eq!(window.segments.len(), 3);
    assert_eq!(window.segments[0].ended_by, EndedBy::Condition);
    let follow = &window.segments[1];
    for topic in ["/az", "/el"] {
        let rows = window.rows(topic).expect("a topic of the rig");
        let end = rows.range(follow.end_s - 0.1, follow.end_s);
        let rate =
            column(&window, topic, "velocity_rad_per_s")[end.clone()].iter().sum::<f64>() / end.len() as f64;
        assert!((rate - 0.02).abs() < 2e-3, "{topic}: {rate} rad/s");
    }
    let coarse = window.rows("/coarse").expect("a topic of the rig");
    let last = coarse.range(follow.start_s, follow.end_s).end - 1;
    let error = column(&window, "/coarse", "elevation_rad")[last];
    assert!(error.abs() < 1e-3, "{error} rad");
    assert_eq!(column(&window, "/track", "coarse_state")[last], 2.0);
    let moved = *column(&window, "/az", "position_rad").last().expect("rows");
    assert!(moved.abs() < 2e-3 && outcome.safe.standstill, "back at {moved} rad");
}

#[test]
fn an_axis_that_is_not_to_track_holds_its_pose() {
    let (wanted, unit) = track(sweep(0.02), 0.0, Tracks::default());
    let (outcome, window) = run_case(&wanted, &unit, &[], 0);
    // The target rises by 40 mrad; elevation gives way by 0.4 mrad when it takes up its load.
    assert!(outcome.safe.standstill);
    let farthest = column(&window, "/el", "position_rad").iter().fold(0.0_f64, |m, p| m.max(p.abs()));
    assert!(farthest < 1e-3, "{farthest} rad");
}

#[test]
fn a_target_that_is_not_there_ends_the_point_before_anything_moves() {
    let (wanted, unit) = track(TargetCourse::Star, 0.3, Tracks::default());
    let (outcome, window) = run_case(&wanted, &unit, &[], 0);
    assert_eq!((outcome.status, outcome.trip), (PointStatus::Completed, None));
    assert_eq!(window.segments.len(), 1, "nothing follows it");
    assert_eq!(window.segments[0].ended_by, EndedBy::Timeout);
    let farthest = column(&window, "/az", "position_rad").iter().fold(0.0_f64, |m, p| m.max(p.abs()));
    assert!(farthest < 1e-4, "{farthest} rad");
}

/// 0.3 rad/s within 0.2 s is far more than the loop can follow: the target leaves the field.
#[test]
fn a_target_that_is_lost_trips_and_the_axes_stop_under_control() {
    let course =
        TargetCourse::Sweep { azimuth_rad_per_s: 0.3, elevation_rad_per_s: 0.0, leg_s: 20.0, turn_s: 0.4 };
    let (wanted, unit) = track(course, 0.0, Tracks::default());
    let (outcome, window) = run_case(&wanted, &unit, &[], 0);
    let trip = outcome.trip.expect("the target leaves the field");
    assert_eq!(trip.interlock, "tracker lost");
    assert!(outcome.safe.standstill, "{:?}", outcome.safe);
    assert_eq!(window.trips.len(), 1, "{:?}", window.trips);
    let last = *column(&window, "/track", "coarse_state").last().expect("rows");
    assert_eq!(last, -1.0, "a stop leaves the track loop");
    assert!(window.stops.iter().any(|stop| stop.manner == StopManner::Controlled), "{:?}", window.stops);
}

#[test]
fn a_signal_ends_tracking() {
    let (wanted, unit) = track(sweep(0.02), 0.0, Tracks { others: true, fine: true, off_load: true });
    let (outcome, window) = run_case(&wanted, &unit, &[], 130);
    assert_eq!((outcome.status, outcome.signal), (PointStatus::Aborted, Some(130)));
    assert!(outcome.safe.standstill);
    let state = *column(&window, "/track", "fine_state").last().expect("rows");
    assert_eq!(state, -1.0);
}

#[test]
fn coarse_and_fine_loop_together_leave_some_microradians() {
    let tracks = Tracks { others: true, fine: true, off_load: true };
    let (mut wanted, unit) = track(TargetCourse::Star, 0.2e-3, tracks);
    wanted.segments[0].at_most_s = 6.0;
    let (outcome, window) = run_case(&wanted, &unit, &[], 0);
    assert_eq!(outcome.status, PointStatus::Completed, "{outcome:?}");
    assert_eq!(window.segments[0].ended_by, EndedBy::Condition);
    let follow = &window.segments[1];
    let fine = window.rows("/fine").expect("a topic of the rig").range(follow.end_s - 2.0, follow.end_s);
    let errors = &column(&window, "/fine", "elevation_rad")[fine];
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    assert!(rms < 5e-6, "{rms} rad");
}
