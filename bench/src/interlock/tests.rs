use drivers::cia402::Actuals;
use procedures::case::Bounds;

use super::memory::{GyroSeen, Seen};
use super::*;

const PERIOD_S: f64 = 250e-6;
const QUANTUM_RAD: f64 = std::f64::consts::TAU / (1 << 26) as f64;

fn guard() -> AxisGuard {
    AxisGuard {
        stop: StopModel {
            travel_rad: [-1.0, 1.0],
            soft_limits_rad: [-0.95, 0.95],
            inertia_kg_m2: 1000.0,
            deceleration_rad_per_s2: 1.5,
            jerk_rad_per_s3: 150.0,
            reaction_s: 0.002,
            friction: crate::stopping::LeastFriction {
                static_nm: 200.0,
                coulomb_nm: 150.0,
                viscous_nm_s_per_rad: 0.0,
            },
            end_stop_energy_j: 1000.0,
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
        encoder_quantum_rad: QUANTUM_RAD,
        worst_load_nm: 100.0,
        emergency_stop_bit: Some(3),
        enabling_switch_bit: Some(4),
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
        following_error_rad: None,
        bounds: None,
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

fn still() -> Tick {
    Tick { actuals: healthy(), gyro: None, sent_nm: 0.0, expects_operation: true }
}

/// What trips while an axis does this for so many ticks, and after how many.
fn played(ticks: u32, mut at: impl FnMut(u32) -> Tick) -> Option<(&'static str, u32)> {
    let (guard, mut memory) = (guard(), Memory::new(PERIOD_S));
    (0..ticks).find_map(|k| {
        let Tick { actuals, gyro, sent_nm, expects_operation } = at(k);
        memory.take(&Seen {
            guard: &guard,
            actuals: &actuals,
            fresh: true,
            expects_operation,
            gyro,
            sent_nm,
        });
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
    let bounds = Some(Bounds { displacement_rad: 0.02, speed_rad_per_s: 0.05 });
    let (guard, mut memory) = (guard(), Memory::new(PERIOD_S));
    let mut at = |position_rad: f64, rate: f64, expects_operation| {
        let mut actuals = healthy();
        (actuals.position_rad, actuals.velocity_rad_per_s) = (position_rad, rate);
        actuals.position_counts = (position_rad / QUANTUM_RAD) as i32;
        let seen = Seen {
            guard: &guard,
            actuals: &actuals,
            fresh: true,
            expects_operation,
            gyro: None,
            sent_nm: 0.0,
        };
        memory.take(&seen);
        let view = |v: &mut View<'_>| v.bounds = bounds;
        remembering(&memory, &actuals, view)
    };
    assert_eq!(at(0.3, 0.0, false), None, "not in operation yet: it does not count as where it stood");
    assert_eq!(at(0.5, 0.0, true), None);
    assert_eq!(at(0.519, 0.0, true), None);
    assert_eq!(at(0.481, -0.049, true), None);
    assert_eq!(at(0.479, 0.0, true), Some("bounds of displacement"));
    assert_eq!(at(0.5, -0.051, true), Some("bounds of speed"));
}

#[test]
fn an_encoder_that_jumps_trips_as_acceleration_and_hard_braking_does_not() {
    let braking = |k: u32| {
        let mut tick = still();
        let rate = 0.5 - 2.0 * PERIOD_S * f64::from(k);
        tick.actuals.velocity_rad_per_s = rate;
        tick.actuals.position_counts = k as i32;
        tick
    };
    assert_eq!(played(400, braking), None);
    let jump = |k: u32| {
        let mut tick = braking(k);
        tick.actuals.velocity_rad_per_s += if k >= 100 { 0.5 } else { 0.0 };
        tick
    };
    assert_eq!(played(400, jump), Some(("acceleration", 100)));
    let no_number = |k: u32| {
        let mut tick = braking(k);
        tick.actuals.velocity_rad_per_s = if k >= 100 { f64::NAN } else { 0.5 };
        tick
    };
    assert_eq!(played(400, no_number).map(|(_, k)| k), Some(100));
}

#[test]
fn the_mean_torque_trips_after_the_time_that_its_time_constant_says() {
    let load = |torque_nm: f64| {
        move |_| {
            let mut tick = still();
            (tick.actuals.torque_nm, tick.sent_nm) = (torque_nm, torque_nm);
            // Held by more friction than the rig file knows of: the count must change.
            tick
        }
    };
    let counted = |torque_nm: f64| {
        move |k: u32| {
            let mut tick = load(torque_nm)(k);
            tick.actuals.position_counts = k as i32;
            tick
        }
    };
    // 10 s · ln(1/(1 − (500/1000)²)) = 2.877 s.
    let (name, ticks) = played(20_000, counted(1000.0)).expect("twice the continuous torque");
    let after_s = f64::from(ticks) * PERIOD_S;
    assert_eq!(name, "I2t");
    assert!((after_s - 2.877).abs() < 0.01, "{after_s} s");
    assert_eq!(played(20_000, counted(499.0)), None);
}

#[test]
fn an_axis_at_rest_is_not_frozen_however_long() {
    assert_eq!(played(40_000, |k| Tick { gyro: gyro(k, 20e-6), ..still() }), None);
    let pushed = |_| {
        let mut tick = still();
        tick.actuals.torque_nm = 380.0;
        tick
    };
    assert_eq!(played(8000, pushed), None, "380 N·m may be held by friction");
}

#[test]
fn an_encoder_whose_count_stands_while_gyro_torque_or_its_own_speed_say_otherwise_is_frozen() {
    let at_50_ms = |from: u32| Some(("frozen encoder", from + 200));
    let by_gyro = |k: u32| Tick { gyro: gyro(k, 0.001), ..still() };
    assert_eq!(played(2000, by_gyro).map(|(name, _)| name), Some("frozen encoder"));
    let by_torque = |_| {
        let mut tick = still();
        tick.actuals.torque_nm = 600.0;
        tick
    };
    assert_eq!(played(2000, by_torque).map(|(name, _)| name), Some("frozen encoder"));
    // It turned at 0.2 rad/s (and its drive no longer says so), no torque, no gyro: it cannot have stopped in a tick.
    let by_momentum = |k: u32| {
        let mut tick = moving(k.min(100), 0.2);
        tick.actuals.velocity_rad_per_s = if k > 100 { 0.0 } else { 0.2 };
        tick
    };
    // The speed that falls in one tick trips first where the rig's limit of acceleration is that low.
    assert_eq!(played(2000, by_momentum).map(|(name, k)| (name, k)), Some(("acceleration", 101)));
    let sent_on = |k: u32| Tick { actuals: moving(k.min(100), 0.2).actuals, ..moving(100, 0.2) };
    assert_eq!(played(2000, sent_on), at_50_ms(100));
    assert_eq!(played(2000, |k| moving(k, 0.2)), None);
}

#[test]
fn a_gyro_that_repeats_itself_while_the_encoder_moves_is_frozen() {
    let healthy = |k: u32| Tick { gyro: gyro(k, 0.01), ..moving(k, 0.01) };
    assert_eq!(played(2000, healthy), None);
    let same_rates = |k: u32| Tick {
        gyro: gyro(7, 0.01).map(|g| GyroSeen { sequence: (k % 128) as u8, ..g }),
        ..healthy(k)
    };
    assert_eq!(played(2000, same_rates), Some(("frozen gyro", 200)));
    let same_number =
        |k: u32| Tick { gyro: gyro(k, 0.01).map(|g| GyroSeen { sequence: 7, ..g }), ..healthy(k) };
    assert_eq!(played(2000, same_number), Some(("frozen gyro", 200)));
    assert_eq!(played(2000, |_| Tick { gyro: gyro(7, 0.0), ..still() }), None, "an axis at rest");
}

/// An axis of 1000 kg·m² whose motor does `factor` times what its torque says, against 150 N·m of friction.
fn pushed(factor: f64, torque_nm: f64, friction_nm: f64) -> impl FnMut(u32) -> Tick {
    let (mut rate, mut at_rad) = (0.0, 0.0);
    move |_| {
        let acceleration: f64 =
            (factor * torque_nm - friction_nm * factor.signum() * torque_nm.signum()) / 1000.0;
        rate += acceleration * PERIOD_S;
        at_rad += rate * PERIOD_S;
        let mut tick = still();
        tick.actuals.velocity_rad_per_s = rate;
        tick.actuals.position_rad = at_rad;
        tick.actuals.position_counts = (at_rad / QUANTUM_RAD) as i32;
        (tick.actuals.torque_nm, tick.sent_nm) = (torque_nm, torque_nm);
        tick
    }
}

#[test]
fn an_axis_that_speeds_up_against_its_torque_is_a_runaway_within_30_ms() {
    for torque_nm in [400.0, -800.0] {
        let (name, ticks) = played(400, pushed(-1.0, torque_nm, 150.0)).expect("the wrong way");
        assert_eq!(name, "runaway");
        assert!((80..120).contains(&ticks), "after {ticks} ticks");
    }
    assert_eq!(played(400, pushed(1.0, 400.0, 150.0)), None);
    assert_eq!(played(400, pushed(-1.0, 220.0, 150.0)), None, "not clearly above breakaway");
    let mut disabled = pushed(-1.0, 400.0, 150.0);
    assert_eq!(played(400, |k| Tick { expects_operation: false, ..disabled(k) }), None);
}

#[test]
fn an_axis_that_friction_brakes_against_its_torque_is_no_runaway() {
    // Twice the friction of the rig file, and torque that only softens the stop.
    let mut rate = 1.0_f64;
    let braked = |k: u32| {
        rate = (rate - 0.5 * PERIOD_S).max(0.0);
        let mut tick = still();
        tick.actuals.velocity_rad_per_s = rate;
        tick.actuals.position_counts = k as i32;
        (tick.actuals.torque_nm, tick.sent_nm) = (400.0, 400.0);
        tick
    };
    assert_eq!(played(400, braked), None);
}

/// The deceleration relied on after so many ticks of this.
fn relied_on(ticks: u32, mut at: impl FnMut(u32) -> (f64, f64)) -> f64 {
    let (guard, mut memory) = (guard(), Memory::new(PERIOD_S));
    for k in 0..ticks {
        let mut actuals = healthy();
        let (sent_nm, shown_nm) = at(k);
        (actuals.torque_nm, actuals.position_counts) = (shown_nm, k as i32);
        let seen = Seen {
            guard: &guard,
            actuals: &actuals,
            fresh: true,
            expects_operation: true,
            gyro: None,
            sent_nm,
        };
        memory.take(&seen);
    }
    memory.deceleration_rad_per_s2(&guard)
}

#[test]
fn a_motor_that_gives_less_than_it_is_told_is_relied_on_for_what_it_has_shown() {
    // (600 − 100)/1000 = 0.5 rad/s².
    let weak = |_| (-900.0, -600.0);
    assert_eq!(relied_on(200, weak), 0.5);
    assert_eq!(relied_on(50, weak), 1.5, "10 ms must pass");
    assert_eq!(
        relied_on(400, |k| if k < 200 { (900.0, 600.0) } else { (0.0, 0.0) }),
        0.5,
        "it is not forgotten"
    );
    assert_eq!(relied_on(400, |k| (900.0, if k < 200 { 300.0 } else { 600.0 })), 0.5, "the largest counts");
    assert_eq!(relied_on(200, |_| (900.0, 120.0)), 0.075, "at least a twentieth");
    assert_eq!(relied_on(200, |_| (900.0, 860.0)), 1.5, "4 % are noise");
}

#[test]
fn the_delay_of_transport_and_current_loop_is_no_deficit() {
    // A sine of 40 Hz over the whole torque, seen 3 ms late.
    let sine = |time_s: f64| 1000.0 * (std::f64::consts::TAU * 40.0 * time_s).sin();
    let at = |k: u32| (sine(f64::from(k) * PERIOD_S), sine(f64::from(k) * PERIOD_S - 0.003));
    assert_eq!(relied_on(4000, at), 1.5);
    assert_eq!(
        relied_on(4000, |k| (if k < 200 { 0.0 } else { 1000.0 }, if k < 212 { 0.0 } else { 1000.0 })),
        1.5
    );
}

#[test]
fn what_the_motor_has_shown_moves_the_braking_curve() {
    let (guard, mut memory) = (guard(), Memory::new(PERIOD_S));
    let mut actuals = healthy();
    (actuals.velocity_rad_per_s, actuals.torque_nm) = (0.5, 300.0);
    // 0.5²/(2·1.5) = 0.083 rad with the whole motor, 0.5²/(2·0.2) = 0.625 rad with what it gives.
    actuals.position_rad = 0.4;
    assert_eq!(remembering(&memory, &actuals, |_| {}), None);
    for k in 0..100 {
        actuals.position_counts = k;
        let seen = Seen {
            guard: &guard,
            actuals: &actuals,
            fresh: true,
            expects_operation: true,
            gyro: None,
            sent_nm: 900.0,
        };
        memory.take(&seen);
    }
    assert_eq!(remembering(&memory, &actuals, |_| {}), Some("braking curve"));
}
