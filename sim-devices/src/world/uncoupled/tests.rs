use super::*;
use crate::unit::{AxisSettings, TableAxis};

const STEP_S: f64 = 50e-6;

/// An axis of the table built in without cogging.
fn smooth() -> AxisSettings {
    let settings = TableAxis::new("table").settings;
    AxisSettings { cogging_amplitude_nm: 0.0, cogging_second_amplitude_nm: 0.0, ..settings }
}

/// An axis with nothing but viscous friction.
fn slippery(viscous_damping_nm_s_per_rad: f64) -> AxisSettings {
    AxisSettings {
        coulomb_torque_nm: 1e-9,
        static_torque_nm: 1e-9,
        bristle_damping_nm_s_per_rad: 0.0,
        viscous_damping_nm_s_per_rad,
        ..smooth()
    }
}

fn world(settings: &AxisSettings, angle_rad: f64) -> UncoupledAxes {
    let mut world = UncoupledAxes::new(STEP_S);
    world.add("table", settings, angle_rad);
    world
}

fn run(world: &mut UncoupledAxes, motor_nm: &[f64], duration_s: f64) {
    (0..(duration_s / STEP_S).round() as u32).for_each(|_| world.step(motor_nm));
}

fn rate_rad_per_s(world: &UncoupledAxes) -> f64 {
    world.truth()[0].rate_rad_per_s
}

/// `J·ω̇ = T − c·ω`: from rest `ω = T/c·(1 − e^(−ct/J))`, and without torque `ω = ω_0·e^(−ct/J)`.
#[test]
fn viscous_friction_alone_lets_the_axis_run_up_and_coast_down_exponentially() {
    let settings = slippery(6.0);
    let time_s = settings.inertia_kg_m2 / settings.viscous_damping_nm_s_per_rad;
    let mut world = world(&settings, 0.0);
    run(&mut world, &[3.0], 1.0);
    let reached = 3.0 / 6.0 * (1.0 - (-1.0 / time_s).exp());
    assert!((rate_rad_per_s(&world) / reached - 1.0).abs() < 1e-6, "{}", rate_rad_per_s(&world));
    let from_rad = world.angle_rad(0);
    run(&mut world, &[0.0], 4.0);
    let left = reached * (-4.0 / time_s).exp();
    assert!((rate_rad_per_s(&world) / left - 1.0).abs() < 1e-6, "{}", rate_rad_per_s(&world));
    let way_rad = reached * time_s * (1.0 - (-4.0 / time_s).exp());
    assert!(((world.angle_rad(0) - from_rad) / way_rad - 1.0).abs() < 1e-6);
}

/// Coulomb friction takes `T_C/J` off the rate per second once the Stribeck range is left behind.
#[test]
fn coulomb_friction_brakes_at_a_constant_rate() {
    let settings = AxisSettings {
        viscous_damping_nm_s_per_rad: 0.0,
        static_torque_nm: 5.0,
        coulomb_torque_nm: 5.0,
        ..smooth()
    };
    let mut world = world(&settings, 0.0);
    run(&mut world, &[17.0], 1.0);
    let before = rate_rad_per_s(&world);
    run(&mut world, &[0.0], 1.0);
    let lost = before - rate_rad_per_s(&world);
    assert!((lost - 5.0 / 12.0).abs() < 1e-3, "{lost} rad/s lost in a second");
}

/// Below breakaway the contact creeps by `−T_S/σ_0·ln(1 − T/T_S)` and holds; above it the axis leaves.
#[test]
fn static_friction_holds_an_axis_until_its_breakaway_torque() {
    let settings = AxisSettings { ageing_ratio: 0.0, ..smooth() };
    let mut held = world(&settings, 0.2);
    (0..4000).for_each(|k| run(&mut held, &[1e-3 * f64::from(k)], 2e-3));
    run(&mut held, &[4.0], 20.0);
    let crept_rad = held.angle_rad(0) - 0.2;
    let most_nm = settings.static_torque_nm;
    let expected_rad = -most_nm / settings.bristle_stiffness_nm_per_rad * (1.0 - 4.0 / most_nm).ln();
    assert!((crept_rad / expected_rad - 1.0).abs() < 0.02, "{crept_rad} rad, expected {expected_rad}");
    assert!(rate_rad_per_s(&held).abs() < 1e-9, "{}", rate_rad_per_s(&held));
    let mut left = world(&settings, 0.2);
    run(&mut left, &[1.02 * settings.static_torque_nm], 5.0);
    assert!(left.angle_rad(0) > 0.21, "{}", left.angle_rad(0));
}

/// Cogging of amplitude A holds an axis without friction in its trough and lets it swing there: `ω² = A·n/J`.
#[test]
fn cogging_alone_lets_the_axis_swing_in_its_trough() {
    let cogged = AxisSettings { cogging_amplitude_nm: 1.2, ..slippery(0.0) };
    let order = cogged.cogging_orders_per_rev;
    let inertia = cogged.inertia_kg_m2;
    let trough_rad = std::f64::consts::PI / order;
    let mut world = world(&cogged, trough_rad + 1e-4);
    let period_s = std::f64::consts::TAU / (1.2 * order / inertia).sqrt();
    run(&mut world, &[0.0], 0.5 * period_s);
    assert!((world.angle_rad(0) - trough_rad + 1e-4).abs() < 1e-6, "{}", world.angle_rad(0) - trough_rad);
    run(&mut world, &[0.0], 0.5 * period_s);
    assert!((world.angle_rad(0) - trough_rad - 1e-4).abs() < 1e-6, "{}", world.angle_rad(0) - trough_rad);
}

/// A damped contact that is met at `v` is entered by `v/ω·e^(−ζφ/√(1−ζ²))`, `tan φ = √(1−ζ²)/ζ`, and seen once.
#[test]
fn a_hard_stop_is_entered_as_deep_as_its_stiffness_and_damping_say() {
    let settings = slippery(0.0);
    let upper_rad = settings.upper_stop_rad;
    let mut world = world(&settings, upper_rad - 0.2);
    while world.truth()[0].angle_rad < upper_rad - 0.1 {
        world.step(&[60.0]);
    }
    let speed = rate_rad_per_s(&world);
    let mut deepest_rad: f64 = 0.0;
    for _ in 0..20_000 {
        world.step(&[0.0]);
        deepest_rad = deepest_rad.max(world.angle_rad(0) - upper_rad);
    }
    let omega = (settings.stop_stiffness_nm_per_rad / settings.inertia_kg_m2).sqrt();
    let zeta = settings.stop_damping_nm_s_per_rad / (2.0 * settings.inertia_kg_m2 * omega);
    let root = (1.0 - zeta * zeta).sqrt();
    let expected_rad = speed / omega * (-zeta / root * (root / zeta).atan()).exp();
    assert!((deepest_rad / expected_rad - 1.0).abs() < 0.02, "{deepest_rad} rad, expected {expected_rad}");
    assert!(rate_rad_per_s(&world) < 0.0, "it comes back, slower: {}", rate_rad_per_s(&world));
    let crashes = world.record().crashes;
    assert_eq!(crashes.len(), 1, "{crashes:?}");
    assert!((crashes[0].2 - speed).abs() < 1e-6 && crashes[0].0 == "table", "{crashes:?}");
}

#[test]
fn a_stop_that_was_left_can_be_met_again_and_both_contacts_are_told_in_order() {
    let mut world = UncoupledAxes::new(STEP_S);
    let settings = AxisSettings { stop_damping_nm_s_per_rad: 100.0, ..slippery(0.0) };
    world.add("first", &settings, settings.upper_stop_rad - 0.01);
    world.add("second", &settings, settings.lower_stop_rad + 0.005);
    run(&mut world, &[20.0, -20.0], 3.0);
    let crashes = world.record().crashes;
    assert!(crashes.windows(2).all(|pair| pair[0].1 <= pair[1].1), "{crashes:?}");
    assert_eq!(crashes[0].0, "second", "it had half the way");
    assert!(crashes.iter().filter(|crash| crash.0 == "first").count() > 1, "{crashes:?}");
}

#[test]
fn what_one_axis_does_the_others_do_not_feel() {
    let settings = TableAxis::new("table").settings;
    let mut together = UncoupledAxes::new(STEP_S);
    let torques = [9.0, -14.0, 0.0, 25.0];
    let names = ["a", "b", "c", "d"];
    names.iter().for_each(|name| together.add(name, &settings, 0.1));
    run(&mut together, &torques, 0.5);
    for (place, torque_nm) in torques.into_iter().enumerate() {
        let mut alone = world(&settings, 0.1);
        run(&mut alone, &[torque_nm], 0.5);
        let ours = &together.truth()[place];
        let theirs = &alone.truth()[0];
        assert_eq!(ours.name, names[place]);
        assert_eq!((ours.angle_rad, ours.rate_rad_per_s), (theirs.angle_rad, theirs.rate_rad_per_s));
    }
}
