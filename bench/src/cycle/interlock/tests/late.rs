//! Interlocks in a loop that misses periods, and on axes whose gyros show the other axis, too.

use super::*;

/// Ticks of a loop that misses all periods between `from` and `from + missed`.
fn with_gap(ticks: u32, from: u32, missed: u32) -> impl Iterator<Item = u32> {
    (0..ticks).filter(move |&k| k < from || k >= from + missed)
}

/// Braking at 102 deg/s² from 1 rad/s, as a healthy axis does it in a stop.
fn braking(k: u32) -> Tick {
    let time_s = PERIOD_S * f64::from(k);
    let rate = 102_f64.to_radians();
    let mut tick = still();
    tick.actuals.velocity_rad_per_s = 1.0 - rate * time_s;
    tick.actuals.position_rad = -0.5 + time_s * (1.0 - 0.5 * rate * time_s);
    tick.actuals.position_counts = (tick.actuals.position_rad / QUANTUM_RAD) as i32;
    tick
}

/// The limit of these tests is that of the simulated rig, 200 deg/s².
fn acceleration_after(ticks: impl Iterator<Item = u32>) -> f64 {
    let guard = guard();
    let mut memory = Memory::new(PERIOD_S);
    let mut before = 0;
    let mut most = 0.0_f64;
    for k in ticks {
        let Tick { actuals, gyro, sent_nm, expects_operation } = braking(k);
        let seen = Seen { guard: &guard, actuals: &actuals, fresh: true, expects_operation, gyro, sent_nm };
        memory.take(&seen, (k - before).max(1));
        before = k;
        most = most.max(memory.acceleration_rad_per_s2().abs().to_degrees());
    }
    most
}

#[test]
fn a_braking_at_102_deg_per_s2_is_no_more_after_32_missed_periods() {
    for missed in [1, 4, 20, 32, 80] {
        let most = acceleration_after(with_gap(1000, 500, missed));
        assert!((101.0..102.001).contains(&most), "{most} deg/s² after {missed} missed periods");
    }
    assert_eq!(played_at(with_gap(1000, 500, 32), braking), None);
}

/// The mean square over true time: 1000 N·m for 0.5 s, nothing for 0.5 s, in turn, whatever ticks see of it.
#[test]
fn i2t_after_missed_periods_is_the_mean_over_the_time_that_has_passed() {
    let mean_nm = |ticks: &mut dyn Iterator<Item = u32>| {
        let guard = guard();
        let mut memory = Memory::new(PERIOD_S);
        let mut before = 0;
        for k in ticks {
            let mut actuals = healthy();
            actuals.torque_nm = if (k / 2000) % 2 == 0 { 1000.0 } else { 0.0 };
            memory.take(&driven(&guard, &actuals, actuals.torque_nm), (k - before).max(1));
            before = k;
        }
        memory.mean_torque_nm()
    };
    let whole = mean_nm(&mut (0..=20_000));
    let sparse = mean_nm(&mut (0..=20_000).filter(|k| k % 20 == 0));
    // 5 s of a mean square of 0.5 · 1000²: 0.5 · (1 − e^(−0.5)) of it, and what the last half period left out.
    assert!((whole - 430.0).abs() < 15.0, "{whole} N·m");
    assert!((sparse / whole - 1.0).abs() < 0.005, "{sparse} N·m, {whole} N·m in every tick");
}

#[test]
fn an_encoder_that_stands_is_frozen_after_50_ms_however_few_of_their_ticks_came() {
    let stuck = |k: u32| Tick { actuals: moving(k.min(100), 0.2).actuals, ..moving(100, 0.2) };
    let (name, tick) = played_at(with_gap(2000, 140, 32), stuck).expect("it stands");
    assert!(name == "frozen encoder" && (300..=301).contains(&tick), "{name} in tick {tick}");
    let sparse = (0..2000).filter(|k| k % 8 == 0);
    let (name, tick) = played_at(sparse, stuck).expect("it stands");
    assert!(name == "frozen encoder" && (300..=312).contains(&tick), "{name} in tick {tick}");
}

#[test]
fn a_gap_counts_as_a_spell_only_where_both_of_its_ends_show_it() {
    // Torque that nobody asked for: 200 N·m against the 100 N·m that are tolerated.
    let shown = |from: u32| {
        move |k: u32| {
            let mut tick = still();
            tick.actuals.position_counts = k as i32;
            tick.actuals.torque_nm = if k >= from { 200.0 } else { 0.0 };
            tick
        }
    };
    let trip = |from| played_at(with_gap(400, 200, 32), shown(from));
    assert_eq!(trip(190), Some(("uncommanded torque", 232)), "10 ticks before the gap, 8 ms of it");
    let (name, tick) = trip(210).expect("it lasts");
    assert!(
        name == "uncommanded torque" && (271..=272).contains(&tick),
        "it may have begun at the end: {tick}"
    );
}

#[test]
fn what_was_asked_for_is_forgotten_after_20_ms_however_few_of_their_ticks_came() {
    let stuck = |k: u32| {
        let mut tick = still();
        tick.actuals.position_counts = k as i32;
        tick.actuals.torque_nm = 500.0;
        tick.sent_nm = if k < 800 { 500.0 } else { 0.0 };
        tick
    };
    // 20 ms, the stretch under way, and 10 ms of torque that nobody asked for.
    let (name, tick) = played_at((0..4000).filter(|k| k % 8 == 0), stuck).expect("nobody asked for it");
    assert!(name == "uncommanded torque" && (900..960).contains(&tick), "{name} in tick {tick}");
}

/// An axis at rest whose gyro shows a share of the other axis' 60 deg/s, and may show another.
fn beside_a_slew(share: f64, allowed: f64) -> impl FnMut(u32) -> Tick {
    move |k| {
        let others_rad_per_s = 60_f64.to_radians();
        let error_rad_per_s = BIAS_RAD_PER_S + allowed * others_rad_per_s;
        let seen = gyro(k, share * others_rad_per_s);
        Tick { gyro: seen.map(|seen| GyroSeen { error_rad_per_s, ..seen }), ..still() }
    }
}

#[test]
fn what_a_gyro_shows_of_the_other_axis_is_no_motion_that_the_encoder_missed() {
    for share in [-0.02, -0.001, 0.001, 0.02, 0.035] {
        assert_eq!(played(4000, beside_a_slew(share, 0.04)), None, "{share}");
    }
    for (share, declared) in [(0.05, 0.04), (0.01, 0.005), (-0.001, 0.0)] {
        let found = played(4000, beside_a_slew(share, declared));
        assert_eq!(
            found.map(|(name, _)| name),
            Some("frozen encoder"),
            "{share} where {declared} is declared"
        );
    }
}

#[test]
fn a_bias_that_the_rig_file_declares_is_no_motion_and_a_larger_one_is() {
    let at_rest = |bias: f64| move |k| Tick { gyro: gyro(k, bias), ..still() };
    assert_eq!(played(4000, at_rest(BIAS_RAD_PER_S + 73e-6)), None, "bias and the Earth");
    let found = played(4000, at_rest(BIAS_RAD_PER_S + 300e-6));
    assert_eq!(found.map(|(name, _)| name), Some("frozen encoder"));
}

#[test]
fn an_encoder_that_freezes_beside_a_slew_of_the_other_axis_is_found_within_50_ms() {
    let freezes_at = |rate: f64, torque_nm: f64| {
        let mut beside = beside_a_slew(0.02, 0.04);
        move |k: u32| {
            let mut tick = moving(k.min(200), if k <= 200 { rate } else { 0.0 });
            if k > 200 {
                tick.actuals = moving(200, rate).actuals;
            }
            let leaked = beside(k).gyro.expect("a gyro");
            let rate_rad_per_s = leaked.rate_rad_per_s + rate;
            tick.gyro = Some(GyroSeen { rate_rad_per_s, ..leaked });
            (tick.actuals.torque_nm, tick.sent_nm) = (torque_nm, torque_nm);
            tick
        }
    };
    // By what it must have moved before it can have stopped, by its gyro, and by torque and gyro together.
    for (rate, torque_nm) in [(0.02, 0.0), (0.2, 0.0), (0.005, 700.0)] {
        let found = played(2000, freezes_at(rate, torque_nm));
        let (name, tick) = found.expect("the count stands");
        assert!(name == "frozen encoder" && tick <= 401, "{rate} rad/s: {name} in tick {tick}");
    }
}
