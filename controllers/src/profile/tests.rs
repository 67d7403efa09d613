use proptest::prelude::*;

use super::*;

const PERIOD_S: f64 = 250e-6;
const DIRECTOR: MotionLimits =
    MotionLimits { velocity_rad_per_s: 1.0, acceleration_rad_per_s2: 1.5, jerk_rad_per_s3: 10.0 };

fn generator(limits: MotionLimits) -> ProfileGenerator {
    ProfileGenerator::new(limits, 0.0).expect("all limits above 0")
}

/// Checks one tick against the limits and against the tick before.
fn check_tick(
    limits: &MotionLimits,
    before: Reference,
    now: Reference,
    period_s: f64,
) -> Result<(), TestCaseError> {
    let MotionLimits { velocity_rad_per_s: v, acceleration_rad_per_s2: a, jerk_rad_per_s3: j } = *limits;
    let slack = 1.0 + 1e-9;
    prop_assert!(now.velocity_rad_per_s.abs() <= v * slack, "{now:?}");
    prop_assert!(now.acceleration_rad_per_s2.abs() <= a * slack, "{now:?}");
    let jerk = (now.acceleration_rad_per_s2 - before.acceleration_rad_per_s2) / period_s;
    prop_assert!(jerk.abs() <= j * slack + 1e-6, "jerk {jerk} of {j}");
    // Between ticks velocity and position are integrals: they cannot stray further from the trapezoid than jerk lets.
    let mean_a = (now.acceleration_rad_per_s2 + before.acceleration_rad_per_s2) / 2.0;
    let stray_v = now.velocity_rad_per_s - before.velocity_rad_per_s - mean_a * period_s;
    prop_assert!(stray_v.abs() <= j * period_s * period_s / 2.0 + 1e-9, "velocity jumps by {stray_v}");
    let mean_v = (now.velocity_rad_per_s + before.velocity_rad_per_s) / 2.0;
    let stray_p = now.position_rad - before.position_rad - mean_v * period_s;
    prop_assert!(stray_p.abs() <= a * period_s * period_s + 1e-9, "position jumps by {stray_p}");
    Ok(())
}

/// Runs to rest; returns the extremes of the position on the way.
fn run(
    generator: &mut ProfileGenerator,
    limits: &MotionLimits,
    period_s: f64,
) -> Result<(f64, f64), TestCaseError> {
    let mut before = generator.reference();
    let mut low = before.position_rad;
    let mut high = before.position_rad;
    while !generator.is_at_rest() {
        let now = generator.advance(period_s);
        check_tick(limits, before, now, period_s)?;
        low = low.min(now.position_rad);
        high = high.max(now.position_rad);
        before = now;
    }
    Ok((low, high))
}

#[test]
fn long_move_takes_the_textbook_time() {
    let mut move_ = generator(DIRECTOR);
    move_.move_to(4.0);
    // Seven phases: distance/v + v/a + a/j.
    assert!((move_.duration_s() - (4.0 + 1.0 / 1.5 + 1.5 / 10.0)).abs() < 1e-12);
}

#[test]
fn move_too_short_for_cruise_or_full_acceleration_takes_the_textbook_time() {
    let mut move_ = generator(DIRECTOR);
    // Neither velocity nor acceleration limit is reached: four equal phases of (d/2j)^(1/3).
    move_.move_to(-0.01);
    assert!((move_.duration_s() - 4.0 * libm::cbrt(0.01 / 20.0)).abs() < 1e-9);
    // Acceleration but not velocity limit: d = v(v/a + a/j), solved for v.
    let mut move_ = generator(DIRECTOR);
    move_.move_to(0.4);
    let half = 1.5 * 1.5 / 10.0 / 2.0;
    let velocity = -half + libm::sqrt(half * half + 1.5 * 0.4);
    assert!((move_.duration_s() - 2.0 * (velocity / 1.5 + 1.5 / 10.0)).abs() < 1e-9);
}

#[test]
fn stop_takes_the_textbook_distance() {
    let mut stop = generator(DIRECTOR);
    stop.take_over(Reference { position_rad: 2.0, velocity_rad_per_s: -1.0, acceleration_rad_per_s2: 0.0 });
    // v/2 · (v/a + a/j).
    assert!((stop.end_rad() - (2.0 - 0.5 * (1.0 / 1.5 + 0.15))).abs() < 1e-12);
    assert!((stop.duration_s() - (1.0 / 1.5 + 0.15)).abs() < 1e-12);
}

#[test]
fn motion_is_taken_over_without_a_jump_and_cut_to_the_limits() {
    let motion = Reference { position_rad: 0.3, velocity_rad_per_s: -0.7, acceleration_rad_per_s2: 1.4 };
    let mut taken = generator(DIRECTOR);
    taken.take_over(motion);
    assert_eq!(taken.reference(), motion);
    let now = taken.advance(PERIOD_S);
    assert!((now.position_rad - (0.3 - 0.7 * PERIOD_S)).abs() < 1e-7);
    taken.take_over(Reference { velocity_rad_per_s: 2.0, acceleration_rad_per_s2: 9.0, ..motion });
    let cut = Reference { position_rad: 0.3, velocity_rad_per_s: 1.0, acceleration_rad_per_s2: 0.0 };
    assert_eq!(taken.reference(), cut, "at full speed nothing may be added");
}

#[test]
fn end_is_exact_and_stays() {
    let mut move_ = generator(DIRECTOR);
    move_.move_to(1.234_567_8);
    for _ in 0..20_000 {
        move_.advance(PERIOD_S);
    }
    assert_eq!(move_.reference(), Reference { position_rad: 1.234_567_8, ..Reference::default() });
    move_.move_to(1.234_567_8);
    assert_eq!(move_.advance(PERIOD_S).position_rad, 1.234_567_8);
    assert_eq!(move_.duration_s(), 0.0);
}

#[test]
fn target_that_cannot_be_met_in_time_is_passed_once_and_come_back_to() {
    let mut move_ = generator(DIRECTOR);
    move_.move_to(2.0);
    while move_.reference().position_rad < 1.0 {
        move_.advance(PERIOD_S);
    }
    let motion = move_.reference();
    let mut stop = move_.clone();
    stop.stop();
    move_.move_to(1.1);
    let (low, high) = run(&mut move_, &DIRECTOR, PERIOD_S).expect("within the limits");
    assert!(low >= motion.position_rad);
    assert!(high > 1.1 && high < stop.end_rad(), "it turns before an immediate stop would end");
    assert_eq!(move_.reference().position_rad, 1.1);
}

#[test]
fn broken_input_changes_nothing() {
    let mut move_ = generator(DIRECTOR);
    move_.move_to(1.0);
    let before = move_.advance(0.3);
    move_.move_to(f64::NAN);
    assert_eq!(move_.advance(f64::NAN), before);
    assert_eq!(move_.advance(-1.0), before);
    assert_eq!(move_.end_rad(), 1.0);
    assert!(ProfileGenerator::new(MotionLimits { jerk_rad_per_s3: 0.0, ..DIRECTOR }, 0.0).is_none());
    assert!(ProfileGenerator::new(MotionLimits { velocity_rad_per_s: f64::NAN, ..DIRECTOR }, 0.0).is_none());
}

fn limits() -> impl Strategy<Value = MotionLimits> {
    (0.01..2.0_f64, 0.05..5.0_f64, 0.1..100.0_f64).prop_map(|(v, a, j)| MotionLimits {
        velocity_rad_per_s: v,
        acceleration_rad_per_s2: a,
        jerk_rad_per_s3: j,
    })
}

proptest! {
    #[test]
    fn move_from_rest_stays_within_limits_and_never_passes_its_target(
        limits in limits(),
        target in prop_oneof![-3.0..3.0_f64, -1e-6..1e-6_f64],
    ) {
        let mut move_ = generator(limits);
        move_.move_to(target);
        let period_s = (move_.duration_s() / 777.0).max(1e-9);
        let (low, high) = run(&mut move_, &limits, period_s)?;
        prop_assert!(low >= target.min(0.0) - 1e-12 && high <= target.max(0.0) + 1e-12);
        prop_assert_eq!(move_.reference().position_rad, target);
    }

    #[test]
    fn plan_leads_to_its_end_without_a_jump(
        limits in limits(),
        target in -3.0..3.0_f64,
        velocity in -1.0..1.0_f64,
        acceleration in -1.0..1.0_f64,
    ) {
        let mut move_ = generator(limits);
        move_.take_over(Reference {
            position_rad: 0.0,
            velocity_rad_per_s: velocity * limits.velocity_rad_per_s,
            acceleration_rad_per_s2: acceleration * limits.acceleration_rad_per_s2,
        });
        let mut stop = move_.clone();
        let start = move_.reference();
        move_.move_to(target);
        let reached = displacement(start, &move_.phases);
        prop_assert!((reached - target).abs() < 1e-10, "{reached} for {target}");
        let period_s = (move_.duration_s() / 777.0).max(1e-9);
        let (low, high) = run(&mut move_, &limits, period_s)?;
        // Neither target nor start is passed further than an immediate stop would have to.
        let stop_period_s = (stop.duration_s() / 2000.0).max(1e-9);
        let (stop_low, stop_high) = run(&mut stop, &limits, stop_period_s)?;
        let slack = limits.acceleration_rad_per_s2 * stop_period_s * stop_period_s + 1e-12;
        prop_assert!(low >= target.min(stop_low) - slack, "{low} below {target} and {stop_low}");
        prop_assert!(high <= target.max(stop_high) + slack, "{high} above {target} and {stop_high}");
    }

    #[test]
    fn any_sequence_of_targets_and_stops_stays_within_limits(
        limits in limits(),
        commands in prop::collection::vec((0.0..1.0_f64, -3.0..3.0_f64, any::<bool>()), 1..12),
    ) {
        let mut move_ = generator(limits);
        let mut before = move_.reference();
        for (part, target, stop) in commands {
            if stop { move_.stop() } else { move_.move_to(target) }
            let ticks = (part * 100.0) as usize;
            let period_s = (move_.duration_s() / 100.0).max(1e-9);
            for _ in 0..ticks {
                let now = move_.advance(period_s);
                check_tick(&limits, before, now, period_s)?;
                before = now;
            }
        }
        move_.stop();
        let period_s = (move_.duration_s() / 300.0).max(1e-9);
        run(&mut move_, &limits, period_s)?;
        prop_assert_eq!(move_.reference().velocity_rad_per_s, 0.0);
    }
}
