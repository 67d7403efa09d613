use super::*;
use crate::unit::UnitSettings;
use proptest::prelude::*;

const STEP_S: f64 = 50e-6;

fn both() -> [AxisSettings; 2] {
    let unit = UnitSettings::default();
    [unit.az, unit.el]
}

/// The equations of the module's head with nothing but `exp` and `ln`, by classical Runge–Kutta at 1 µs.
fn reference_torque(axis: &AxisSettings, velocity: impl Fn(f64) -> f64, end_s: f64) -> (Contact, f64) {
    let rates = |t: f64, z: f64, age: f64| {
        let w = velocity(t);
        let distance = axis.static_torque_nm / axis.bristle_stiffness_nm_per_rad;
        let aged = axis.ageing_ratio * axis.static_torque_nm * (1.0 + age / axis.ageing_time_s).ln();
        let excess = axis.static_torque_nm + aged - axis.coulomb_torque_nm;
        let exponent = (w.abs() / axis.stribeck_velocity_rad_per_s).powf(axis.stribeck_shape_exponent);
        let s = axis.coulomb_torque_nm + excess * (-exponent).exp();
        (w - axis.bristle_stiffness_nm_per_rad * w.abs() * z / s, 1.0 - w.abs() * age / distance)
    };
    let h = 1e-6;
    let mut z = 0.0;
    let mut age = 0.0;
    for k in 0..(end_s / h).round() as u32 {
        let t = f64::from(k) * h;
        let (z1, a1) = rates(t, z, age);
        let (z2, a2) = rates(t + h / 2.0, z + h / 2.0 * z1, age + h / 2.0 * a1);
        let (z3, a3) = rates(t + h / 2.0, z + h / 2.0 * z2, age + h / 2.0 * a2);
        let (z4, a4) = rates(t + h, z + h * z3, age + h * a3);
        z += h / 6.0 * (z1 + 2.0 * z2 + 2.0 * z3 + z4);
        age += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
    let torque = axis.bristle_stiffness_nm_per_rad * z
        + axis.bristle_damping_nm_s_per_rad * rates(end_s, z, age).0
        + axis.viscous_damping_nm_s_per_rad * velocity(end_s);
    (Contact { deflection_rad: z, age_s: age }, torque)
}

/// Mean torque of the two steps around `end_s`, the velocity of each taken at its middle.
fn stepped_torque(axis: &AxisSettings, velocity: impl Fn(f64) -> f64, end_s: f64) -> (Contact, f64) {
    let law = LuGre::new(axis, STEP_S);
    let mut contact = Contact::default();
    let steps = (end_s / STEP_S).round() as u32;
    let middle = |k: u32| velocity((f64::from(k) + 0.5) * STEP_S);
    let mut before = 0.0;
    (0..steps).for_each(|k| before = law.advance(&mut contact, middle(k)));
    let end = contact;
    (end, 0.5 * (before + law.advance(&mut contact, middle(steps))))
}

#[test]
fn reversals_follow_a_fine_reference_within_2e_5_of_the_static_torque() {
    for axis in both() {
        for amplitude in [0.3 * axis.stribeck_velocity_rad_per_s, 0.2] {
            let velocity = |t: f64| amplitude * (7.0 * t).sin();
            for end_s in [0.3, 0.47, 0.9] {
                let (reference, torque) = reference_torque(&axis, velocity, end_s);
                let (contact, stepped) = stepped_torque(&axis, velocity, end_s);
                let error = (stepped - torque).abs() / axis.static_torque_nm;
                assert!(error < 2e-5, "torque error {error:e} at {end_s} s, amplitude {amplitude}");
                assert!((contact.deflection_rad - reference.deflection_rad).abs() < 1e-7);
                assert!((contact.age_s - reference.age_s).abs() < 2e-4 * reference.age_s + 1e-7);
            }
        }
    }
}

#[test]
fn sliding_long_ends_at_the_stribeck_curve() {
    for axis in both() {
        let law = LuGre::new(&axis, STEP_S);
        for speed in [0.001, 0.01, 0.1, 1.0] {
            for velocity in [speed, -speed] {
                let mut contact = Contact::default();
                let steps = (20.0 * 3e-3 / speed / STEP_S) as u32 + 1000;
                let torque = (0..steps).fold(0.0, |_, _| law.advance(&mut contact, velocity));
                let expected = law.steady_torque_nm(velocity);
                assert!((torque - expected).abs() < 1e-8 * expected.abs(), "{torque} is not {expected}");
                assert_eq!(expected.signum(), velocity.signum());
            }
        }
    }
}

/// At the plan velocities the ageing term is what its steady age D_c/|ω| makes of it, under 0.4 N·m.
#[test]
fn ageing_in_steady_sliding_is_small_but_there() {
    let [az, _] = both();
    let law = LuGre::new(&az, STEP_S);
    let fresh = law.sliding_torque_nm(0.01, 0.0) + 273.6 * 0.01;
    let aged = law.steady_torque_nm(0.01) - fresh;
    let expected = 0.02 * 210.0 * (1.0 + 210.0 / 90_000.0 / 0.01_f64).ln();
    assert!((aged - expected).abs() < 0.01 * expected && aged < 0.9, "{aged} against {expected}");
}

#[test]
fn rest_ages_the_contact_up_to_its_limit() {
    let [az, _] = both();
    let law = LuGre::new(&az, 0.01);
    let mut contact = Contact::default();
    (0..1000).for_each(|_| {
        law.advance(&mut contact, 0.0);
    });
    assert!((contact.age_s - 10.0).abs() < 1e-9);
    (0..100_000).for_each(|_| {
        law.advance(&mut contact, 0.0);
    });
    assert_eq!(contact.age_s, 1000.0);
    let growth = law.sliding_torque_nm(0.0, 10.0) - law.sliding_torque_nm(0.0, 0.0);
    assert!((growth - 0.02 * 210.0 * 11.0_f64.ln()).abs() < 1e-9);
}

#[test]
fn the_extinct_stribeck_term_changes_no_bit() {
    for axis in both() {
        let law = LuGre::new(&axis, STEP_S);
        let edge = law.extinct_velocity_rad_per_s;
        assert_eq!(law.sliding_torque_nm(edge * (1.0 - 1e-12), 1.0), axis.coulomb_torque_nm);
        assert_eq!(law.sliding_torque_nm(edge, 1.0), axis.coulomb_torque_nm);
        assert!(law.sliding_torque_nm(edge * 0.5, 1.0) > axis.coulomb_torque_nm);
    }
}

#[test]
fn relaxation_is_continuous_where_the_series_ends() {
    for x in [0.0, 1e-18, 1e-9, 1e-3, 0.05, 0.0999999, 0.1, 0.1000001, 3.0, 900.0_f64] {
        let (decay, growth) = relaxation(x);
        let exact = if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x };
        assert!((growth - exact).abs() < 4e-14, "{x}: {growth} is not {exact}");
        assert!((decay - (-x).exp()).abs() < 4e-15, "{x}");
    }
}

proptest! {
    /// Unconditionally stable: no velocity and no step width bends the bristles past their limit.
    #[test]
    fn bristles_stay_bounded_at_any_step(
        velocities in prop::collection::vec(-50.0..50.0f64, 1..200), exponent in -6.0..0.0f64,
    ) {
        let [_, el] = both();
        let law = LuGre::new(&el, 10.0_f64.powf(exponent));
        let mut contact = Contact::default();
        let limit = law.sliding_torque_nm(0.0, 1000.0) / el.bristle_stiffness_nm_per_rad;
        for velocity in velocities {
            law.advance(&mut contact, velocity);
            prop_assert!(contact.deflection_rad.abs() <= limit * (1.0 + 1e-9));
        }
    }
}
