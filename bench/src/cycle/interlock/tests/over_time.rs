//! Interlocks that look at more than one tick.

use super::*;

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
        (tick.actuals.torque_nm, tick.sent_nm) = (380.0, 380.0);
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
        (tick.actuals.torque_nm, tick.sent_nm) = (600.0, 600.0);
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
    assert_eq!(played(2000, by_momentum), Some(("acceleration", 101)));
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
    let mut rate = 0.0;
    let mut at_rad = 0.0;
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
fn an_axis_that_speeds_up_against_its_torque_is_a_runaway_20_ms_after_1_degree_per_second() {
    for torque_nm in [400.0, -800.0] {
        let (name, ticks) = played(400, pushed(-1.0, torque_nm, 150.0)).expect("the wrong way");
        assert_eq!(name, "runaway");
        let to_one_degree_s = 1.0_f64.to_radians() / ((torque_nm.abs() - 150.0) / 1000.0);
        let expected = (to_one_degree_s / PERIOD_S) as u32 + 80;
        assert!((expected - 2..expected + 20).contains(&ticks), "after {ticks} of {expected} ticks");
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
    let guard = guard();
    let mut memory = Memory::new(PERIOD_S);
    for k in 0..ticks {
        let mut actuals = healthy();
        let (sent_nm, shown_nm) = at(k);
        (actuals.torque_nm, actuals.position_counts) = (shown_nm, k as i32);
        memory.take(&driven(&guard, &actuals, sent_nm), 1);
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
    assert_eq!(relied_on(200, |_| (900.0, 120.0)), 0.05 * 1.5, "at least a twentieth");
    assert_eq!(relied_on(200, |_| (900.0, 860.0)), 1.5, "4 % are noise");
    assert_eq!(relied_on(200, |_| (0.0, -600.0)), 1.5, "nothing was asked for");
}

#[test]
fn the_delay_of_transport_and_current_loop_is_no_deficit() {
    // A sine of 40 Hz over the whole torque, seen 3 ms late.
    let sine = |time_s: f64| 1000.0 * (std::f64::consts::TAU * 40.0 * time_s).sin();
    let asked_and_seen = |k: u32| (sine(f64::from(k) * PERIOD_S), sine(f64::from(k) * PERIOD_S - 0.003));
    assert_eq!(relied_on(4000, asked_and_seen), 1.5);
    assert_eq!(
        relied_on(4000, |k| (if k < 200 { 0.0 } else { 1000.0 }, if k < 212 { 0.0 } else { 1000.0 })),
        1.5
    );
}

#[test]
fn what_the_motor_has_shown_moves_the_braking_curve() {
    let guard = guard();
    let mut memory = Memory::new(PERIOD_S);
    let mut actuals = healthy();
    (actuals.velocity_rad_per_s, actuals.torque_nm) = (0.5, 300.0);
    // 0.5²/(2·1.5) = 0.083 rad with the whole motor, 0.5²/(2·0.2) = 0.625 rad with what it gives.
    actuals.position_rad = 0.4;
    assert_eq!(remembering(&memory, &actuals, |_| {}), None);
    // 20 ms until every command that may act was one of these, 10 ms of missing torque.
    for k in 0..150 {
        actuals.position_counts = k;
        memory.take(&driven(&guard, &actuals, 900.0), 1);
    }
    assert_eq!(remembering(&memory, &actuals, |_| {}), Some("braking curve"));
}
