use drivers::cia402::Actuals;

use super::*;

fn guard() -> AxisGuard {
    AxisGuard {
        stop: StopModel {
            travel_rad: [-1.0, 1.0],
            soft_limits_rad: [-0.95, 0.95],
            inertia_kg_m2: 1000.0,
            deceleration_rad_per_s2: 1.5,
            jerk_rad_per_s3: 150.0,
            reaction_s: 0.002,
            ..StopModel::default()
        },
        max_acceleration_rad_per_s2: 10.0,
        continuous_torque_nm: 500.0,
        thermal_time_s: 10.0,
        max_following_error_rad: 0.02,
        max_rate_disagreement_rad_per_s: 0.04,
        max_velocity_rad_per_s: 1.1,
        max_torque_nm: 1000.0,
        max_heat_sink_degc: 80.0,
        bus_voltage_v: [480.0, 620.0],
        stale_after_s: 0.005,
    }
}

fn healthy() -> Actuals {
    Actuals { bus_v: 560.0, heat_sink_degc: 45.0, statusword: 0x1637, ..Actuals::default() }
}

fn trip(change: impl FnOnce(&mut Actuals)) -> Option<&'static str> {
    let mut actuals = healthy();
    change(&mut actuals);
    tripped(&actuals, |_| {})
}

fn tripped(actuals: &Actuals, change: impl FnOnce(&mut View<'_>)) -> Option<&'static str> {
    let guard = guard();
    let mut view = View {
        guard: &guard,
        actuals,
        expects_operation: true,
        age_s: 0.0,
        bad_exchanges_in_row: 0,
        bad_exchanges_in_100: 0,
        feedback_age_s: 0.0,
        feedback_disagreement_rad_per_s: 0.0,
        missed_periods: 0,
        max_missed_periods: 4,
    };
    change(&mut view);
    first_out(0, &view, None).map(|t| t.interlock)
}

#[test]
fn a_healthy_axis_at_rest_does_not_trip() {
    assert_eq!(trip(|_| {}), None);
}

#[test]
fn each_interlock_trips_on_its_own_fault() {
    assert_eq!(trip(|a| (a.position_rad, a.velocity_rad_per_s) = (0.96, 0.01)), Some("position"));
    assert_eq!(trip(|a| a.velocity_rad_per_s = 1.2), Some("velocity"));
    assert_eq!(trip(|a| a.torque_nm = -1100.0), Some("torque"));
    assert_eq!(trip(|a| a.heat_sink_degc = 81.0), Some("temperature"));
    assert_eq!(trip(|a| a.bus_v = 470.0), Some("bus voltage"));
    assert_eq!(trip(|a| a.bus_v = 621.0), Some("bus voltage"));
    assert_eq!(trip(|a| a.statusword = 0x0008), Some("drive state"));
    assert_eq!(tripped(&healthy(), |v| v.age_s = 0.006), Some("stale data"));
    assert_eq!(tripped(&healthy(), |v| v.missed_periods = 5), Some("missed cycles"));
    assert_eq!(tripped(&healthy(), |v| v.bad_exchanges_in_row = 3), Some("bus"));
    assert_eq!(tripped(&healthy(), |v| v.bad_exchanges_in_100 = 5), Some("bus"));
}

#[test]
fn two_bad_exchanges_in_a_row_are_held_not_tripped() {
    assert_eq!(tripped(&healthy(), |v| v.bad_exchanges_in_row = 2), None);
}

#[test]
fn the_braking_curve_trips_before_a_stop_inside_the_soft_limit_is_out_of_reach() {
    // 1²/3 + 1.5/300 + 0.002 = 0.340 rad, with the allowance for settling 0.348: from 1 rad/s the last place is 0.602.
    assert_eq!(trip(|a| (a.position_rad, a.velocity_rad_per_s) = (0.60, 1.0)), None);
    assert_eq!(trip(|a| (a.position_rad, a.velocity_rad_per_s) = (0.61, 1.0)), Some("braking curve"));
    assert_eq!(trip(|a| (a.position_rad, a.velocity_rad_per_s) = (0.61, -1.0)), None);
}

#[test]
fn an_axis_that_returns_from_beyond_a_soft_limit_is_left_alone() {
    assert_eq!(trip(|a| (a.position_rad, a.velocity_rad_per_s) = (0.97, -0.01)), None);
}

#[test]
fn numbers_that_are_not_numbers_trip() {
    assert!(trip(|a| a.position_rad = f64::NAN).is_some());
    assert!(trip(|a| a.velocity_rad_per_s = f64::NAN).is_some());
    assert!(trip(|a| a.torque_nm = f64::NAN).is_some());
    assert!(trip(|a| a.heat_sink_degc = f64::NAN).is_some());
    assert!(trip(|a| a.bus_v = f64::NAN).is_some());
}

#[test]
fn a_disabled_drive_is_not_expected_to_operate() {
    let mut actuals = healthy();
    actuals.statusword = 0x0040;
    assert_eq!(tripped(&actuals, |v| v.expects_operation = false), None);
}

#[test]
fn a_gyro_that_falls_silent_trips_while_the_loop_needs_it() {
    assert_eq!(tripped(&healthy(), |v| v.feedback_age_s = 0.005), None);
    assert_eq!(tripped(&healthy(), |v| v.feedback_age_s = 0.006), Some("rate feedback"));
    let idle = |v: &mut View<'_>| (v.feedback_age_s, v.expects_operation) = (f64::INFINITY, false);
    assert_eq!(tripped(&healthy(), idle), None);
}

#[test]
fn gyro_and_encoder_that_contradict_each_other_trip_either_way() {
    for rate in [-0.041, 0.041, f64::NAN] {
        let contradicted = |v: &mut View<'_>| v.feedback_disagreement_rad_per_s = rate;
        assert_eq!(tripped(&healthy(), contradicted), Some("rate disagreement"));
    }
    assert_eq!(tripped(&healthy(), |v| v.feedback_disagreement_rad_per_s = 0.039), None);
}
