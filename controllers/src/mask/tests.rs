use std::collections::VecDeque;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;

const PERIOD_S: f64 = 1e-3;
const SETTINGS: EnvelopeSettings = EnvelopeSettings { deceleration_rad_per_s2: 1.0, reaction_time_s: 0.051 };
/// One tick less than the reaction time.
const LATE_TICKS: usize = 50;
const ZONE: Zone = Zone { lower_rad: [-0.3, -0.2], upper_rad: [0.4, 0.3] };

/// Both axes, late and braking as the settings promise.
struct Gimbal {
    position_rad: [f64; 2],
    rate_rad_per_s: [f64; 2],
    late: VecDeque<[f64; 2]>,
}

impl Gimbal {
    fn new(position_rad: [f64; 2]) -> Self {
        let late = std::iter::repeat_n([0.0; 2], LATE_TICKS).collect();
        Self { position_rad, rate_rad_per_s: [0.0; 2], late }
    }

    fn step(&mut self, command_rad_per_s: [f64; 2]) {
        self.late.push_back(command_rad_per_s);
        let due = self.late.pop_front().expect("just pushed");
        let most = SETTINGS.deceleration_rad_per_s2 * PERIOD_S;
        for ((rate, position), due) in self.rate_rad_per_s.iter_mut().zip(&mut self.position_rad).zip(due) {
            *rate += (due - *rate).clamp(-most, most);
            *position += *rate * PERIOD_S;
        }
    }
}

fn keeper(zones: &[Zone]) -> MaskKeeper {
    let mut keeper = MaskKeeper::new(&SETTINGS, PERIOD_S);
    assert!(zones.iter().all(|zone| keeper.add(*zone)));
    keeper
}

fn contains(zone: &Zone, position_rad: [f64; 2]) -> bool {
    (0..2).all(|axis| (zone.lower_rad[axis]..=zone.upper_rad[axis]).contains(&position_rad[axis]))
}

/// Runs with a wish for some time; whether a zone was entered.
fn run(gimbal: &mut Gimbal, keeper: &mut MaskKeeper, wish: [f64; 2], ticks: usize, zones: &[Zone]) -> bool {
    (0..ticks).any(|_| {
        let allowed = keeper.limit(gimbal.position_rad, gimbal.rate_rad_per_s, wish);
        gimbal.step(allowed);
        zones.iter().any(|zone| contains(zone, gimbal.position_rad))
    })
}

#[test]
fn zone_in_the_way_stops_one_axis_in_front_of_it() {
    let mut gimbal = Gimbal::new([-1.0, 0.1]);
    let mut keeper = keeper(&[ZONE]);
    assert!(!run(&mut gimbal, &mut keeper, [0.5, 0.0], 10_000, &[ZONE]));
    assert!((gimbal.position_rad[0] + 0.3).abs() < 1e-6, "{:?}", gimbal.position_rad);
}

#[test]
fn zone_is_passed_beside_at_full_rate() {
    let mut gimbal = Gimbal::new([-1.0, 0.5]);
    let mut keeper = keeper(&[ZONE]);
    for _ in 0..5000 {
        let wish = [0.5, 0.0];
        let allowed = keeper.limit(gimbal.position_rad, gimbal.rate_rad_per_s, wish);
        if gimbal.position_rad[0] > -0.6 {
            assert_eq!(allowed, wish, "elevation is the farther one and keeps out");
        }
        gimbal.step(allowed);
    }
    assert!(gimbal.position_rad[0] > 0.9);
}

#[test]
fn zone_is_gone_around() {
    let mut gimbal = Gimbal::new([-1.0, 0.1]);
    let mut keeper = keeper(&[ZONE]);
    for (wish, ticks) in [([0.6, 0.0], 3000), ([0.0, 0.4], 2500), ([0.6, 0.0], 4000), ([0.0, -0.6], 2500)] {
        assert!(!run(&mut gimbal, &mut keeper, wish, ticks, &[ZONE]));
    }
    let [az, el] = gimbal.position_rad;
    assert!(az > 1.0 && el < 0.1, "{az} {el}: on the other side");
}

#[test]
fn corner_is_not_cut() {
    for wish in [[0.8, -0.8], [0.8, -0.4], [0.3, -0.9]] {
        for start in [[-1.0, 1.0], [-0.6, 0.9], [-1.4, 0.4]] {
            let mut gimbal = Gimbal::new(start);
            let mut keeper = keeper(&[ZONE]);
            assert!(!run(&mut gimbal, &mut keeper, wish, 5000, &[ZONE]), "{wish:?} from {start:?}");
        }
    }
}

#[test]
fn guard_changes_only_to_an_axis_that_could_have_stopped_for_a_whole_reaction_time() {
    let mut keeper = keeper(&[ZONE]);
    // Azimuth is the farther one at first, and so the guard.
    keeper.limit([-1.3, 1.2], [0.0; 2], [0.0; 2]);
    let near = [-0.8, 1.2];
    let held = BrakingCurve::new(&SETTINGS).rate_rad_per_s(0.5);
    for _ in 0..200 {
        assert_eq!(keeper.limit(near, [0.0, -3.0], [3.0, 0.0]), [held, 0.0], "elevation is too fast to stop");
    }
    for _ in 0..51 {
        assert_eq!(keeper.limit(near, [0.0; 2], [3.0, 0.0]), [held, 0.0], "not for long enough");
    }
    assert_eq!(keeper.limit(near, [0.0; 2], [3.0, 0.0]), [3.0, 0.0], "elevation keeps out");
}

#[test]
fn inside_a_zone_only_the_way_out_is_open() {
    let mut keeper = keeper(&[ZONE]);
    // The upper edge of elevation is nearest.
    let allowed = |keeper: &mut MaskKeeper, wish| keeper.limit([0.0, 0.2], [0.0; 2], wish)[1];
    assert_eq!(allowed(&mut keeper, [0.0, -0.5]), 0.0);
    assert_eq!(allowed(&mut keeper, [0.0, 0.5]), 0.5);
}

#[test]
fn there_is_room_for_eight_zones_and_none_for_a_turned_one() {
    let mut keeper = MaskKeeper::new(&SETTINGS, PERIOD_S);
    assert!(!keeper.add(Zone { lower_rad: ZONE.upper_rad, upper_rad: ZONE.lower_rad }));
    assert!((0..MASKS).all(|_| keeper.add(ZONE)));
    assert!(!keeper.add(ZONE));
}

#[test]
fn unknown_position_moves_nothing() {
    let mut keeper = keeper(&[ZONE]);
    assert_eq!(keeper.limit([f64::NAN, 0.5], [0.0; 2], [1.0, 1.0]), [0.0; 2]);
    assert_eq!(keeper.limit([1.0, 1.0], [f64::NAN; 2], [f64::INFINITY, 0.1]), [0.0, 0.1]);
}

fn zones() -> impl Strategy<Value = Vec<Zone>> {
    let zone = (-1.5..1.0_f64, -0.5..1.2_f64, 0.05..0.8_f64, 0.05..0.8_f64)
        .prop_map(|(az, el, wide, high)| Zone { lower_rad: [az, el], upper_rad: [az + wide, el + high] });
    prop::collection::vec(zone, 1..4)
}

proptest! {
    #[test]
    fn no_sequence_of_wishes_enters_a_zone(
        zones in zones(),
        start in (-2.0..2.0_f64, -1.0..2.0_f64),
        wishes in prop::collection::vec(((-1.5..1.5_f64, -1.5..1.5_f64), 1..900_usize), 1..25),
    ) {
        let start = [start.0, start.1];
        prop_assume!(!zones.iter().any(|zone| contains(zone, start)));
        let mut gimbal = Gimbal::new(start);
        let mut keeper = keeper(&zones);
        for ((az, el), ticks) in wishes {
            prop_assert!(!run(&mut gimbal, &mut keeper, [az, el], ticks, &zones), "{:?}", gimbal.position_rad);
        }
    }
}
