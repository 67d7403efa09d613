use std::collections::VecDeque;

use proptest::prelude::*;

use super::*;

const PERIOD_S: f64 = 1e-3;
const SETTINGS: EnvelopeSettings = EnvelopeSettings { deceleration_rad_per_s2: 1.0, reaction_time_s: 0.051 };
/// One tick less than the reaction time.
const LATE_TICKS: usize = 50;

/// An axis that gets its commands late and brakes no harder than it must be able to.
struct Axis {
    position_rad: f64,
    rate_rad_per_s: f64,
    late: VecDeque<f64>,
}

impl Axis {
    fn new(position_rad: f64) -> Self {
        Self { position_rad, rate_rad_per_s: 0.0, late: std::iter::repeat_n(0.0, LATE_TICKS).collect() }
    }

    fn step(&mut self, command_rad_per_s: f64) {
        self.late.push_back(command_rad_per_s);
        let due = self.late.pop_front().expect("just pushed");
        let most = SETTINGS.deceleration_rad_per_s2 * PERIOD_S;
        self.rate_rad_per_s += (due - self.rate_rad_per_s).clamp(-most, most);
        self.position_rad += self.rate_rad_per_s * PERIOD_S;
    }
}

#[test]
fn curve_leaves_room_for_reaction_and_braking() {
    let curve = BrakingCurve::new(&SETTINGS);
    for distance_rad in [1e-6, 1e-3, 0.1, 1.0, 5.0] {
        let rate = curve.rate_rad_per_s(distance_rad);
        let needed = rate * SETTINGS.reaction_time_s + rate * rate / 2.0;
        assert!(needed < distance_rad, "{needed} of {distance_rad}");
    }
    let far = curve.rate_rad_per_s(5.0);
    assert!(far > 0.95 * 10.0_f64.sqrt(), "far off it is the plain braking curve: {far}");
    assert_eq!(curve.rate_rad_per_s(0.0), 0.0);
    assert_eq!(curve.rate_rad_per_s(-0.1), 0.0);
    assert_eq!(curve.rate_rad_per_s(f64::NAN), 0.0);
}

#[test]
fn axis_arrives_at_its_limit_and_stays_there() {
    let limits = SoftLimits::new(-1.0, 1.0, &SETTINGS).expect("ordered");
    let mut axis = Axis::new(-0.9);
    for _ in 0..20_000 {
        axis.step(limits.limit(axis.position_rad, 1.0));
        assert!(axis.position_rad <= 1.0);
    }
    assert!(axis.position_rad > 0.999_999, "{}", axis.position_rad);
}

#[test]
fn without_the_factor_for_delay_the_limit_would_be_passed() {
    // What the textbook's stopping distance alone gives: slope times delay of 1.
    let mut axis = Axis::new(-0.9);
    let mut farthest_rad = -0.9_f64;
    for _ in 0..20_000 {
        let reaction = SETTINGS.reaction_time_s;
        let left_rad = (1.0 - axis.position_rad).max(0.0);
        axis.step(((reaction * reaction + 2.0 * left_rad).sqrt() - reaction).min(1.0));
        farthest_rad = farthest_rad.max(axis.position_rad);
    }
    assert!(farthest_rad > 1.0, "{farthest_rad}");
}

#[test]
fn beyond_a_limit_only_the_way_back_is_open() {
    let limits = SoftLimits::new(-1.0, 1.0, &SETTINGS).expect("ordered");
    assert_eq!(limits.limit(1.1, 0.5), 0.0);
    assert_eq!(limits.limit(1.1, -0.5), -0.5);
    assert_eq!(limits.limit(-1.1, -0.5), 0.0);
    assert_eq!(limits.limit(-1.1, 0.5), 0.5);
}

#[test]
fn unknown_position_or_rate_moves_nothing_and_turned_limits_are_refused() {
    let limits = SoftLimits::new(-1.0, 1.0, &SETTINGS).expect("ordered");
    assert_eq!(limits.limit(f64::NAN, 0.5), 0.0);
    assert_eq!(limits.limit(0.0, f64::NAN), 0.0);
    assert_eq!(SoftLimits::new(1.0, -1.0, &SETTINGS), None);
    assert_eq!(SoftLimits::new(f64::NAN, 1.0, &SETTINGS), None);
    let broken = EnvelopeSettings { deceleration_rad_per_s2: f64::NAN, reaction_time_s: 0.1 };
    let limits = SoftLimits::new(-1.0, 1.0, &broken).expect("ordered");
    assert_eq!(limits.limit(0.0, 0.5), 0.0);
}

proptest! {
    #[test]
    fn no_sequence_of_wishes_passes_a_limit(
        start in -0.99..0.99_f64,
        wishes in prop::collection::vec((-3.0..3.0_f64, 1..800_usize), 1..20),
    ) {
        let limits = SoftLimits::new(-1.0, 1.0, &SETTINGS).expect("ordered");
        let mut axis = Axis::new(start);
        for (wish, ticks) in wishes {
            for _ in 0..ticks {
                let command = limits.limit(axis.position_rad, wish);
                prop_assert!(command * wish >= 0.0 && command.abs() <= wish.abs(), "only ever smaller");
                axis.step(command);
                prop_assert!(axis.position_rad.abs() <= 1.0, "{}", axis.position_rad);
            }
        }
    }
}
