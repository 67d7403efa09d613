use drivers::cia402::Actuals;
use procedures::case::Bounds;

use super::memory::{GyroSeen, Seen};
use super::*;
use crate::model::safety::Safety;
use crate::model::stopping::{LeastFriction, StopModel};

mod late;
mod over_time;

const PERIOD_S: f64 = 250e-6;
/// Bias of the gyros as a rig file declares it.
const BIAS_RAD_PER_S: f64 = 100e-6;
const QUANTUM_RAD: f64 = std::f64::consts::TAU / (1 << 26) as f64;

fn guard() -> AxisGuard {
    AxisGuard {
        safety: Safety {
            trip_acceleration_rad_per_s2: 10.0,
            continuous_torque_nm: 500.0,
            thermal_time_s: 10.0,
            max_following_error_rad: 0.02,
            max_rate_disagreement_rad_per_s: 0.04,
            trip_velocity_rad_per_s: 1.1,
            max_heat_sink_degc: 80.0,
            bus_voltage_v: [480.0, 620.0],
            watchdog_s: 0.005,
            ..Safety::blank()
        },
        stop: StopModel {
            travel_rad: [-1.0, 1.0],
            soft_limits_rad: [-0.95, 0.95],
            inertia_kg_m2: 1000.0,
            deceleration_rad_per_s2: 1.5,
            jerk_rad_per_s3: 150.0,
            reaction_s: 0.002,
            friction: LeastFriction { static_nm: 200.0, coulomb_nm: 150.0, viscous_nm_s_per_rad: 0.0 },
            end_stop_energy_j: 1000.0,
            ..StopModel::default()
        },
        max_torque_nm: 1000.0,
        encoder_quantum_rad: QUANTUM_RAD,
        worst_load_nm: 100.0,
        emergency_stop_bit: Some(3),
        enabling_switch_bit: Some(4),
        watches_heat_sink: true,
    }
}

/// The inputs of the first drive while the switch is held and nobody has pressed anything.
const SWITCH_HELD: u32 = 1 << 4;

fn healthy() -> Actuals {
    Actuals {
        bus_v: 560.0,
        heat_sink_degc: 45.0,
        statusword: 0x1637,
        digital_inputs: SWITCH_HELD,
        ..Actuals::default()
    }
}

fn trip(change: impl FnOnce(&mut Actuals)) -> Option<&'static str> {
    let mut actuals = healthy();
    change(&mut actuals);
    tripped(&actuals, |_| {})
}

fn tripped(actuals: &Actuals, change: impl FnOnce(&mut View<'_>)) -> Option<&'static str> {
    remembering(&Memory::new(PERIOD_S), actuals, change)
}

fn remembering(
    memory: &Memory,
    actuals: &Actuals,
    change: impl FnOnce(&mut View<'_>),
) -> Option<&'static str> {
    let guard = guard();
    let mut view = View {
        guard: &guard,
        actuals,
        memory,
        expects_operation: true,
        uses_gyro: true,
        rig_inputs: actuals.digital_inputs,
        emergency_stop_is_open: false,
        following_error_rad: None,
        bounds: None,
        target_missing_s: None,
        zone: None,
        age_s: 0.0,
        bad_exchanges_in_row: 0,
        bad_exchanges_in_100: 0,
        feedback_age_s: 0.0,
        feedback_disagreement_rad_per_s: 0.0,
        missed_periods: 0,
        max_missed_periods: 4,
        ring_ratio: 0.0,
        silent_s: 0.0,
    };
    change(&mut view);
    first_out(0, &view, None).map(|t| t.interlock)
}

/// One tick of what an axis shows.
#[derive(Clone, Copy)]
struct Tick {
    actuals: Actuals,
    gyro: Option<GyroSeen>,
    sent_nm: f64,
    expects_operation: bool,
}

/// An axis in operation that was sent a torque, without a gyro.
fn driven<'a>(guard: &'a AxisGuard, actuals: &'a Actuals, sent_nm: f64) -> Seen<'a> {
    Seen { guard, actuals, fresh: true, expects_operation: true, gyro: None, sent_nm }
}

fn still() -> Tick {
    Tick { actuals: healthy(), gyro: None, sent_nm: 0.0, expects_operation: true }
}

/// What trips while an axis does this for so many ticks, and after how many.
fn played(ticks: u32, at: impl FnMut(u32) -> Tick) -> Option<(&'static str, u32)> {
    played_at(0..ticks, at)
}

/// The same in these ticks, which are some of all periods: those between them were missed.
fn played_at(
    ticks: impl IntoIterator<Item = u32>,
    mut at: impl FnMut(u32) -> Tick,
) -> Option<(&'static str, u32)> {
    let guard = guard();
    let mut memory = Memory::new(PERIOD_S);
    let mut before = None;
    ticks.into_iter().find_map(|k| {
        let passed = k - before.replace(k).unwrap_or(k.saturating_sub(1)).min(k);
        let Tick { actuals, gyro, sent_nm, expects_operation } = at(k);
        memory.take(
            &Seen { guard: &guard, actuals: &actuals, fresh: true, expects_operation, gyro, sent_nm },
            passed.max(1),
        );
        let tripped = remembering(&memory, &actuals, |v| {
            (v.expects_operation, v.uses_gyro) = (expects_operation, gyro.is_some());
        });
        tripped.map(|name| (name, k))
    })
}

/// An axis that moves evenly, as its encoder counts it.
fn moving(k: u32, rate_rad_per_s: f64) -> Tick {
    let position_rad = rate_rad_per_s * PERIOD_S * f64::from(k);
    let mut tick = still();
    tick.actuals.position_rad = position_rad;
    tick.actuals.position_counts = (position_rad / QUANTUM_RAD) as i32;
    tick.actuals.velocity_rad_per_s = rate_rad_per_s;
    tick
}

fn gyro(k: u32, rate_rad_per_s: f64) -> Option<GyroSeen> {
    let noise = 1e-6 * f64::from(k % 7);
    Some(GyroSeen {
        rate_rad_per_s,
        raw_rad_per_s: [rate_rad_per_s + noise, 0.0, 0.0],
        sequence: (k % 128) as u8,
        error_rad_per_s: BIAS_RAD_PER_S,
    })
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
    assert_eq!(trip(|a| a.digital_inputs = SWITCH_HELD | 1 << 3), Some("emergency stop"));
    assert_eq!(trip(|a| a.digital_inputs = 0), Some("enabling switch"));
    assert_eq!(tripped(&healthy(), |v| v.age_s = 0.006), Some("stale data"));
    assert_eq!(tripped(&healthy(), |v| v.missed_periods = 5), Some("missed cycles"));
    assert_eq!(tripped(&healthy(), |v| v.bad_exchanges_in_row = 3), Some("bus"));
    assert_eq!(tripped(&healthy(), |v| v.bad_exchanges_in_100 = 5), Some("bus"));
    assert_eq!(tripped(&healthy(), |v| v.silent_s = 0.11), Some("liveness"));
    assert_eq!(tripped(&healthy(), |v| v.ring_ratio = 0.9), Some("log ring"));
    assert_eq!(tripped(&healthy(), |v| v.following_error_rad = Some(-0.021)), Some("following error"));
}

#[test]
fn just_below_its_limit_none_of_them_trips() {
    assert_eq!(tripped(&healthy(), |v| v.silent_s = 0.1), None);
    assert_eq!(tripped(&healthy(), |v| v.ring_ratio = 0.89), None);
    assert_eq!(tripped(&healthy(), |v| v.following_error_rad = Some(0.019)), None);
    assert_eq!(tripped(&healthy(), |v| v.bad_exchanges_in_row = 2), None);
    assert_eq!(trip(|a| a.velocity_rad_per_s = 0.9), None);
    assert_eq!(trip(|a| a.torque_nm = 1010.0), None);
}

#[test]
fn names_are_unique_and_documented() {
    for (k, lock) in INTERLOCKS.iter().enumerate() {
        assert!(INTERLOCKS[..k].iter().all(|other| other.name != lock.name), "{}", lock.name);
        assert!(lock.doc.ends_with('.'), "{}", lock.name);
    }
}

#[test]
fn the_braking_curve_trips_before_a_stop_inside_the_soft_limit_is_out_of_reach() {
    // 1²/3 + 1.5/300 + 0.002 = 0.340 rad, with the allowance for settling 0.348: from 1 rad/s the last place is 0.602.
    assert_eq!(trip(|a| (a.position_rad, a.velocity_rad_per_s) = (0.60, 1.0)), None);
    assert_eq!(trip(|a| (a.position_rad, a.velocity_rad_per_s) = (0.61, 1.0)), Some("braking curve"));
    assert_eq!(trip(|a| (a.position_rad, a.velocity_rad_per_s) = (0.61, -1.0)), None);
}

#[test]
fn the_coast_curve_trips_where_end_stops_would_not_take_what_friction_leaves() {
    // 1000/2·1² = 500 J at 1 rad/s from 0.5 rad; friction takes 150·0.5 = 75 J: 425 J arrive.
    let mut actuals = healthy();
    (actuals.position_rad, actuals.velocity_rad_per_s) = (0.5, 1.0);
    let with_stops = |energy_j: f64| {
        let mut guard = guard();
        guard.stop.end_stop_energy_j = energy_j;
        let seen = |v: &mut View<'_>| (motion::COAST_CURVE.check)(&View { guard: &guard, ..*v });
        let mut tripped = None;
        remembering(&Memory::new(PERIOD_S), &actuals, |v| tripped = seen(v));
        tripped
    };
    assert_eq!(with_stops(430.0), None);
    let (arrives_j, allowed_j) = with_stops(420.0).expect("425 J arrive");
    assert!((arrives_j - 425.0).abs() < 0.1 && allowed_j == 420.0, "{arrives_j} J");
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
    assert!(tripped(&healthy(), |v| v.following_error_rad = Some(f64::NAN)).is_some());
    assert!(tripped(&healthy(), |v| v.silent_s = f64::NAN).is_some());
    assert!(tripped(&healthy(), |v| v.ring_ratio = f64::NAN).is_some());
}

#[test]
fn a_disabled_drive_is_not_expected_to_operate_but_its_limits_stay() {
    let mut actuals = healthy();
    (actuals.statusword, actuals.digital_inputs) = (0x0040, 0);
    assert_eq!(tripped(&actuals, |v| v.expects_operation = false), None);
    actuals.heat_sink_degc = 81.0;
    assert_eq!(tripped(&actuals, |v| v.expects_operation = false), Some("temperature"));
}

#[test]
fn a_gyro_that_falls_silent_trips_while_the_loop_needs_it() {
    assert_eq!(tripped(&healthy(), |v| v.feedback_age_s = 0.005), None);
    assert_eq!(tripped(&healthy(), |v| v.feedback_age_s = 0.006), Some("rate feedback"));
    for quiet in [|v: &mut View<'_>| v.expects_operation = false, |v: &mut View<'_>| v.uses_gyro = false] {
        let idle = |v: &mut View<'_>| {
            v.feedback_age_s = f64::INFINITY;
            quiet(v);
        };
        assert_eq!(tripped(&healthy(), idle), None);
    }
}

#[test]
fn gyro_and_encoder_that_contradict_each_other_trip_either_way() {
    for rate in [-0.041, 0.041, f64::NAN] {
        let contradicted = |v: &mut View<'_>| v.feedback_disagreement_rad_per_s = rate;
        assert_eq!(tripped(&healthy(), contradicted), Some("rate disagreement"));
    }
    assert_eq!(tripped(&healthy(), |v| v.feedback_disagreement_rad_per_s = 0.039), None);
}

#[test]
fn a_point_with_bounds_of_its_own_trips_beyond_them_from_where_the_axis_was_enabled() {
    let bounds = Some(Bounds { displacement_rad: 0.02, speed_rad_per_s: 0.005 });
    let guard = guard();
    let mut memory = Memory::new(PERIOD_S);
    let mut at = |position_rad: f64, rate: f64, expects_operation| {
        let mut actuals = healthy();
        (actuals.position_rad, actuals.velocity_rad_per_s) = (position_rad, rate);
        actuals.position_counts = (position_rad / QUANTUM_RAD) as i32;
        let seen = Seen { expects_operation, ..driven(&guard, &actuals, 0.0) };
        memory.take(&seen, 1);
        let view = |v: &mut View<'_>| v.bounds = bounds;
        remembering(&memory, &actuals, view)
    };
    assert_eq!(at(0.3, 0.0, false), None, "not in operation yet: it does not count as where it stood");
    assert_eq!(at(0.5, 0.0, true), None);
    assert_eq!(at(0.519, 0.0, true), None);
    assert_eq!(at(0.481, -0.0049, true), None);
    assert_eq!(at(0.479, 0.0, true), Some("bounds of displacement"));
    assert_eq!(at(0.5, -0.0051, true), Some("bounds of speed"));
}

#[test]
fn a_target_that_is_missing_for_longer_than_allowed_trips_while_an_axis_follows_it() {
    let missing = |seen: Option<(f64, f64)>, expects_operation: bool| {
        tripped(&healthy(), |v| (v.target_missing_s, v.expects_operation) = (seen, expects_operation))
    };
    assert_eq!(missing(Some((0.0603, 0.06)), true), Some("tracker lost"));
    assert_eq!(missing(Some((0.06, 0.06)), true), None);
    assert_eq!(missing(None, true), None);
    assert_eq!(missing(Some((f64::NAN, 0.06)), true), Some("tracker lost"));
    assert_ne!(missing(Some((1.0, 0.06)), false), Some("tracker lost"), "a stop does not follow it");
}
