use super::tones::Tones;
use super::*;
use crate::unit::UnitSettings;

fn address(seed: u64) -> SeedAddress {
    SeedAddress { seed, procedure: "TEST".into(), point: "1".into() }
}

fn settings(kind: f64) -> TargetSettings {
    TargetSettings { kind_count: kind, ..UnitSettings::default().target }
}

fn target(kind: f64) -> Target {
    Target::new(&settings(kind), &address(1))
}

/// Two minutes, not on a grid that the courses share.
fn times() -> impl Iterator<Item = f64> {
    (0..40_000).map(|k| f64::from(k) * 3.017e-3)
}

#[test]
fn a_star_stands_where_it_was_set() {
    let star = TargetSettings { azimuth_rad: 0.3, elevation_rad: 0.7, ..settings(0.0) };
    let state = Target::new(&star, &address(1)).at(Duration::from_secs(100));
    assert_eq!(state, TargetState { angle_rad: [0.3, 0.7], rate_rad_per_s: [0.0, 0.0] });
}

#[test]
fn every_target_begins_in_the_set_direction() {
    for kind in [0.0, 1.0, 2.0, 3.0] {
        let set = TargetSettings { azimuth_rad: -0.4, elevation_rad: 0.5, ..settings(kind) };
        let angle_rad = Target::new(&set, &address(3)).at(Duration::ZERO).angle_rad;
        assert!((angle_rad[0] + 0.4).abs() < 1e-12 && (angle_rad[1] - 0.5).abs() < 1e-12, "{kind}");
    }
}

/// Central differences of the angle over 20 µs against the rate, through joints, reversals and starts: position and
/// velocity are continuous and belong together.
#[test]
fn rates_are_the_slopes_of_the_angles() {
    for kind in [1.0, 2.0, 3.0] {
        let target = target(kind);
        for time_s in times() {
            let state = target.at_s(time_s);
            let before = target.at_s(time_s - 1e-5);
            let after = target.at_s(time_s + 1e-5);
            for axis in 0..2 {
                let slope = (after.angle_rad[axis] - before.angle_rad[axis]) / 2e-5;
                let rate = state.rate_rad_per_s[axis];
                assert!((slope - rate).abs() < 1e-7, "kind {kind}, {time_s} s: {slope} against {rate}");
            }
        }
    }
}

/// 2·v/R in 0.1 s at the fastest bounds the acceleration; a jump of velocity would show as 1/δt.
#[test]
fn velocity_never_jumps() {
    let bound_rad_per_s2 = [1.0, 2.0].map(|kind| if kind == 1.0 { 0.2 } else { 0.3 });
    for (kind, bound) in [1.0, 2.0].into_iter().zip(bound_rad_per_s2) {
        let target = target(kind);
        for time_s in times() {
            let before = target.at_s(time_s);
            let after = target.at_s(time_s + 1e-6);
            for axis in 0..2 {
                let change = after.rate_rad_per_s[axis] - before.rate_rad_per_s[axis];
                assert!(change.abs() < bound * 1e-6, "kind {kind}, {time_s} s: {}", change / 1e-6);
            }
        }
    }
}

#[test]
fn the_rail_shows_0_674_deg_per_s_from_85_m_and_0_764_at_1_13_m_per_s() {
    for (speed, deg_per_s) in [(1.0, 0.674), (1.13, 0.762)] {
        let even = TargetSettings { rail_speed_m_per_s: speed, rail_ripple_ratio: 0.0, ..settings(1.0) };
        let target = Target::new(&even, &address(1));
        let fastest = times().map(|t| target.at_s(t).rate_rad_per_s[0]).fold(0.0, f64::max);
        assert!((fastest.to_degrees() - deg_per_s).abs() < 1e-3, "{}", fastest.to_degrees());
    }
}

#[test]
fn the_rail_ends_where_its_rails_end_and_comes_back() {
    let even = TargetSettings { rail_ripple_ratio: 0.0, ..settings(1.0) };
    let rail = Rail::new(&even, &address(1));
    let places: Vec<f64> = (0..20_000).map(|k| rail.at(f64::from(k) * 0.01).along_m).collect();
    let (lowest, highest) = places.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
    assert!(lowest >= 0.0 && highest <= 42.0 && highest > 41.5, "{lowest} to {highest}");
    let period_s = 84.0;
    for time_s in [20.0, 50.0, 71.3] {
        // The first leg starts from rest, so whole periods count from the first reversal on.
        let place = rail.at(42.0 + time_s);
        assert!((place.along_m - rail.at(42.0 + period_s + time_s).along_m).abs() < 1e-9);
    }
}

/// Five inner joints on 42 m; each sets off 3 Hz that is below 2 % of its amplitude 1.5 s later.
#[test]
fn a_heave_follows_every_joint_and_dies_in_1_5_s() {
    let even = TargetSettings { rail_waviness_ratio: 0.0, ..settings(1.0) };
    let rail = Rail::new(&even, &address(1));
    for leg in 0..4 {
        let heave = |t: f64| rail.at(42.0 * f64::from(leg) + t).up_m;
        let peak = |from: f64, to: f64| {
            let span = (0..1000).map(|k| heave(from + (to - from) * f64::from(k) / 1000.0).abs());
            span.fold(0.0, f64::max)
        };
        for joint in 1..=5 {
            // The cart runs straight as if it had started half a reversal later.
            let passed = 7.0 * f64::from(joint) + 0.9;
            assert!(
                peak(passed - 1.0, passed - 1e-3) < 1e-6 * rail.jerk_m(),
                "quiet before joint {joint} of leg {leg}"
            );
            assert!(
                peak(passed, passed + 0.5) > 0.5 * rail.jerk_m(),
                "loud after joint {joint} of leg {leg}"
            );
            assert!(peak(passed + 1.5, passed + 5.0) < 0.021 * rail.jerk_m());
        }
    }
}

#[test]
fn the_drone_comes_down_flies_out_and_returns_to_its_hover() {
    let calm = TargetSettings { drone_heave_m: 0.0, drone_gust_m_per_s: 0.0, ..settings(2.0) };
    let drone = Drone::new(&calm, &address(1));
    let places: Vec<Place> = (0..20_000).map(|k| drone.at(0.0, f64::from(k) * 0.01)).collect();
    let lowest = places.iter().map(|place| place.up_m).fold(0.0, f64::min);
    let farthest = places.iter().map(|place| place.along_m).fold(0.0, f64::max);
    assert!((lowest + 6.0).abs() < 1e-9 && (farthest - 20.0).abs() < 1e-9, "{lowest}, {farthest}");
    let home = drone.at(0.0, 112.5 - 1e-9);
    assert!(home.along_m.abs() < 1e-6 && home.up_m.abs() < 1e-6, "{home:?}");
}

#[test]
fn gusts_have_their_deviation_and_differ_between_seeds() {
    for seed in 1..=5 {
        let gusts = Tones::new(&address(seed), "target.drone-gust", [0.05, 0.5], 0.03);
        let n = 100_000;
        let power: f64 = (0..n).map(|k| gusts.at(f64::from(k) * 0.02).1.powi(2)).sum::<f64>() / f64::from(n);
        assert!((power.sqrt() / 0.03 - 1.0).abs() < 0.01, "{}", power.sqrt());
    }
    let rate = |seed| Target::new(&settings(2.0), &address(seed)).at_s(3.0).rate_rad_per_s[0];
    assert_ne!(rate(1), rate(2));
    assert_eq!(rate(1), rate(1));
}

/// A sweep of 0.3 rad/s whose turn-rounds take 8 s: 5 s at the whole rate to one side, 10 s to the other, 14 s · 0.3 rad/s
/// from end to end.
#[test]
fn a_sweep_goes_back_and_forth_about_its_first_direction() {
    let set = TargetSettings { azimuth_rad: 0.2, elevation_rad: 0.4, standing_s: 2.0, ..settings(3.0) };
    let sweep = Target::new(&set, &address(1));
    let az = |time_s: f64| sweep.at_s(time_s).angle_rad[0] - 0.2;
    let rate = |time_s: f64| sweep.at_s(time_s).rate_rad_per_s[0];
    let half_rad = 0.5 * 14.0 * 0.3;
    assert_eq!((az(1.9), rate(1.9)), (0.0, 0.0));
    assert!((rate(7.0) - 0.3).abs() < 1e-12 && (rate(22.0) + 0.3).abs() < 1e-12);
    let first_s = 2.0 + 11.0;
    assert!((az(first_s) - half_rad).abs() < 1e-9 && rate(first_s).abs() < 1e-12);
    assert!((az(first_s + 18.0) + half_rad).abs() < 1e-9);
    assert!((az(first_s + 36.0) - half_rad).abs() < 1e-9);
    assert!(times().all(|t| az(t).abs() < half_rad + 1e-9 && sweep.at_s(t).angle_rad[1] == 0.4));
}
