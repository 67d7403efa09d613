//! Stops as the bench writes them down.

use super::keys::Way;
use super::*;
use crate::case::Then;
use crate::log::{StopManner, StopRecord};
use crate::procedure::sample::sample_axes;

const DEG: f64 = std::f64::consts::PI / 180.0;

fn keys() -> Keys {
    Keys {
        ways: vec![Way::QuickStop, Way::SoftLimit, Way::TorqueOff],
        speed_rad_per_s: 60.0 * DEG,
        torque_off_rad_per_s: 15.0 * DEG,
        span_rad: [-60.0 * DEG, 60.0 * DEG],
        fence_rad: [-40.0 * DEG, 40.0 * DEG],
    }
}

fn cases() -> Vec<Case> {
    keys().plan("az", &sample_axes()).expect("a plan")
}

fn record(manner: StopManner) -> StopRecord {
    StopRecord {
        point: 0,
        axis: "az".to_owned(),
        manner,
        from_rad: 0.1,
        from_rad_per_s: 60.0 * DEG,
        computed_angle_rad: 20.0 * DEG,
        computed_s: (manner != StopManner::TorqueOff).then_some(2.0),
        reached_angle_rad: 18.0 * DEG,
        took_s: 1.5,
        to_rad: 0.4,
        room_rad: 2.0,
        standstill: true,
    }
}

fn window(stops: Vec<StopRecord>) -> Window {
    Window { stops, ..Window::completed(Vec::new(), Vec::new()) }
}

fn analysed(case: &Case, stops: Vec<StopRecord>) -> PointResult {
    keys().analyse(case, &window(stops), &sample_axes())
}

#[test]
fn each_manner_has_a_point_in_each_direction_that_begins_behind_its_limit() {
    let all = cases();
    let names: Vec<&str> = all.iter().map(|c| c.point.as_str()).collect();
    assert_eq!(names.len(), 6, "{names:?}");
    assert_eq!([all[0].segments[0].then, all[4].segments[0].then], [Then::QuickStop, Then::TorqueOff]);
    let fence = all[3].fence.as_ref().expect("a soft limit of its own");
    assert_eq!(all[3].point, "soft-limit, velocity=-60 deg/s");
    assert!((fence.bench_rad["az"][0] + 40.0 * DEG).abs() < 1e-12 && all[3].start_pose_rad["az"] > 1.0);
    assert!((all[5].requested("velocity").expect("a rate") + 15.0 * DEG).abs() < 1e-12);
}

#[test]
fn a_stop_is_held_against_what_was_computed() {
    let case = cases().remove(0);
    let found = analysed(&case, vec![record(StopManner::QuickStop)]);
    let value = |name: &str| found.measurements.iter().find(|m| m.measurand == name).and_then(|m| m.value);
    assert!((value(ANGLE_RATIO).expect("a ratio") - 0.9).abs() < 1e-12);
    assert!((value(TIME_RATIO).expect("a ratio") - 0.75).abs() < 1e-12);
    assert!(found.measurements.iter().all(|m| m.flags.is_empty()));
    let far = StopRecord { reached_angle_rad: 21.0 * DEG, ..record(StopManner::QuickStop) };
    let found = analysed(&case, vec![far]);
    assert!(found.measurements.iter().all(|m| m.flags == ["MORE THAN COMPUTED"]), "{found:?}");
}

#[test]
fn a_stop_begins_at_a_tick_and_the_uncertainty_of_its_angle_says_so() {
    let case = cases().remove(0);
    let slow = StopRecord { from_rad_per_s: 0.0, ..record(StopManner::QuickStop) };
    let mut axes = sample_axes();
    axes.get_mut("az").expect("an axis").loop_rate_hz = 4000.0;
    let [slow, fast] =
        [slow, record(StopManner::QuickStop)].map(|stop| keys().analyse(&case, &window(vec![stop]), &axes));
    let u = |found: &PointResult, name: &str| {
        found.measurements.iter().find(|m| m.measurand == name).expect("measured").u
    };
    let limits = axes.all()[0].limits.clone();
    let turned_rad = 60.0 * DEG / limits.loop_rate_hz / 12.0_f64.sqrt();
    assert!((u(&slow, ANGLE) - limits.encoder_quantum_rad).abs() < 1e-15);
    assert!((u(&fast, ANGLE) - turned_rad.hypot(limits.encoder_quantum_rad)).abs() < 1e-12);
    assert!((u(&fast, ROOM) - u(&fast, ANGLE)).abs() < 1e-15);
    assert!((u(&fast, TIME) - 1.0 / limits.loop_rate_hz).abs() < 1e-15);
}

#[test]
fn without_torque_the_time_stands_alone() {
    let case = cases().remove(4);
    let found = analysed(&case, vec![record(StopManner::TorqueOff)]);
    let measured = |name: &str| found.measurements.iter().find(|m| m.measurand == name).expect("named");
    assert_eq!(measured(TIME).value, Some(1.5));
    assert!(measured(TIME_RATIO).inconclusive.as_deref().is_some_and(|r| r.contains("no time is computed")));
}

#[test]
fn another_manner_no_stop_no_standstill_and_no_numbers_are_inconclusive() {
    let case = cases().remove(0);
    for (stops, reason) in [
        (vec![record(StopManner::TorqueOff)], "was stopped without torque"),
        (vec![], "no stop of axis `az`"),
        (vec![StopRecord { standstill: false, ..record(StopManner::QuickStop) }], "not end at standstill"),
        (vec![StopRecord { took_s: f64::NAN, ..record(StopManner::QuickStop) }], "not a number"),
    ] {
        let found = analysed(&case, stops);
        assert!(found.inconclusive.as_ref().is_some_and(|r| r.to_string().contains(reason)), "{found:?}");
        assert!(found.measurements.iter().all(|m| m.value.is_none()));
    }
}

#[test]
fn the_pictures_hold_each_stop_against_what_was_computed() {
    let cases = cases();
    let ways = [StopManner::QuickStop, StopManner::Controlled, StopManner::TorqueOff];
    let points: Vec<PointResult> =
        cases.iter().enumerate().map(|(i, case)| analysed(case, vec![record(ways[i / 2])])).collect();
    let plots = keys().conclude(&cases, &points, &sample_axes()).plots;
    assert_eq!(plots[0].rows.len(), 6);
    assert_eq!(plots[0].rows[3], "soft-limit, −60\u{a0}°/s");
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} of {expected}");
    close(plots[0].series[0].x[3], 18.0);
    close(plots[0].series[1].x[3], 20.0);
    assert_eq!(plots[1].series[1].y, [1.0, 2.0, 3.0, 4.0], "no time is computed for stops without torque");
    let unread = analysed(&cases[0], vec![]);
    assert!(keys().conclude(&cases[..1], &[unread], &sample_axes()).plots.is_empty());
}
