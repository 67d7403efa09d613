//! Cross-checks of the whole plant: energy, step width, what standing and sliding contacts show.

use super::*;
use crate::unit::AxisSettings;

fn start(el_deg: f64) -> StartState {
    StartState { az_rad: 0.1, el_rad: el_deg.to_radians(), heat_sink_degc: 40.0 }
}

fn without_friction(axis: &mut AxisSettings) {
    (axis.coulomb_torque_nm, axis.static_torque_nm) = (1e-15, 1e-15);
    (axis.bristle_stiffness_nm_per_rad, axis.bristle_damping_nm_s_per_rad) = (1e-12, 0.0);
    (axis.viscous_damping_nm_s_per_rad, axis.ageing_ratio) = (0.0, 0.0);
}

/// Gravity, spring and cogging as potentials: what their torques take, they give back.
fn potential_j(s: &AxisSettings, angle: f64) -> f64 {
    let order = s.cogging_orders_per_rev;
    let first = s.cogging_amplitude_nm / order * (order * angle + s.cogging_phase_rad).cos();
    let second = s.cogging_second_amplitude_nm / (2.0 * order)
        * (2.0 * order * angle + s.cogging_second_phase_rad).cos();
    let spring = 0.5 * s.spring_stiffness_nm_per_rad * (angle - s.spring_rest_rad).powi(2);
    first + second - s.unbalance_nm * angle.sin() + spring
}

/// Swinging between unbalance and spring with ringing modes that do not decay, 60 s: nothing is lost or gained.
#[test]
fn a_plant_without_friction_keeps_its_energy_for_a_minute() {
    let mut unit = UnitSettings::default();
    without_friction(&mut unit.el);
    unit.el.spring_stiffness_nm_per_rad = 54.0;
    unit.el_structure = unit.el_structure.frozen_at(0.7);
    unit.el_structure.modes.iter_mut().for_each(|mode| mode.damping_ratio.fill(0.0));
    let mut world = World::new(&unit, start(40.0));
    (0..400).for_each(|_| world.step([0.0, 1500.0]));
    let energy = |axis: &Axis| axis.energy_j() + potential_j(&unit.el, axis.angle_rad());
    let first = energy(&world.axes[1]);
    let mut worst = 0.0_f64;
    for k in 0..60 * 20_000 {
        world.step([0.0, 0.0]);
        if k % 97 == 0 {
            worst = worst.max((energy(&world.axes[1]) / first - 1.0).abs());
        }
    }
    assert!(world.record().crashes.is_empty());
    assert!(worst < 1e-6, "energy of {first} J drifts by {worst:e}");
}

/// Largest differences of frame angle and rate of both axes when a whole second of accelerating, reversing and
/// braking is stepped at two rates.
fn differences(mut unit: UnitSettings, coarse_hz: f64, fine_hz: f64) -> (f64, f64) {
    let mut at_rate = |rate_hz: f64| {
        unit.step_rate_hz = rate_hz;
        World::new(&unit, start(30.0))
    };
    let mut coarse = at_rate(coarse_hz);
    let mut fine = at_rate(fine_hz);
    let mut angle = 0.0_f64;
    let mut rate = 0.0_f64;
    for tick in 0..4000_u32 {
        let t = f64::from(tick) / 4000.0;
        let torque = [900.0 * (9.0 * t).sin(), 700.0 * (11.0 * t).cos()];
        (0..(coarse_hz / 4000.0) as u32).for_each(|_| coarse.step(torque));
        (0..(fine_hz / 4000.0) as u32).for_each(|_| fine.step(torque));
        let a = coarse.motion();
        let b = fine.motion();
        for k in 0..2 {
            angle = angle.max((a.frame_rad[k] - b.frame_rad[k]).abs());
            rate = rate.max((a.frame_rad_per_s[k] - b.frame_rad_per_s[k]).abs());
        }
    }
    (angle, rate)
}

/// Stated tolerance of the 20 kHz step, structure fixed: an encoder count is 9.4e-8 rad, the gyro's noise 2e-4 rad/s.
#[test]
fn halving_the_step_changes_less_than_a_tenth_of_an_encoder_count() {
    let mut unit = UnitSettings::default();
    unit.az_structure = unit.az_structure.frozen_at(0.5);
    unit.el_structure = unit.el_structure.frozen_at(0.5);
    let (angle, rate) = differences(unit, 20_000.0, 40_000.0);
    assert!(angle < 9e-9, "angle {angle:e} rad");
    assert!(rate < 2e-7, "rate {rate:e} rad/s");
}

/// With a structure that follows the elevation on its grid the tolerance is a few counts over a second of full torque.
#[test]
fn halving_the_step_moves_a_structure_that_follows_the_elevation_by_a_few_counts() {
    let (angle, rate) = differences(UnitSettings::default(), 20_000.0, 40_000.0);
    assert!(angle < 4e-7, "angle {angle:e} rad");
    assert!(rate < 1e-6, "rate {rate:e} rad/s");
}

/// `max |ω_el|/|ω_az|` of the frame under a sine torque on azimuth, both axes unbraked.
fn leak(frequency_hz: f64) -> f64 {
    let mut unit = UnitSettings::default();
    unit.el.unbalance_nm = 0.0;
    unit.el.spring_stiffness_nm_per_rad = 0.0;
    let mut world = World::new(&unit, start(20.0));
    let mut az = [0.0; 2];
    let mut el = [0.0; 2];
    let periods = (2.0 * frequency_hz).round().max(4.0);
    let steps = (periods / frequency_hz * 20_000.0).round() as u32;
    for k in 0..2 * steps {
        let phase = std::f64::consts::TAU * frequency_hz * f64::from(k) / 20_000.0;
        world.step([600.0 * phase.cos(), 0.0]);
        if k >= steps {
            let motion = world.motion();
            let (sin, cos) = phase.sin_cos();
            for (sum, rate) in [(&mut az, motion.frame_rad_per_s[0]), (&mut el, motion.frame_rad_per_s[1])] {
                sum[0] += rate * cos;
                sum[1] += rate * sin;
            }
        }
    }
    el[0].hypot(el[1]) / az[0].hypot(az[1])
}

#[test]
fn azimuth_leaks_into_elevation_below_0_3_percent_to_10_hz_and_3_percent_above() {
    for hz in [1.0, 2.0, 5.0, 10.0] {
        assert!(leak(hz) < 0.003, "{} at {hz} Hz", leak(hz));
    }
    let above = [20.0, 30.0, 38.0, 40.85, 45.0, 46.5, 53.7, 60.0, 85.5, 120.0].map(leak);
    assert!(above.iter().all(|ratio| *ratio < 0.03), "{above:?}");
    assert!(above.iter().any(|ratio| *ratio > 0.005), "the coupling must be there: {above:?}");
}

/// A step of the azimuth's inertia and modes over elevation: the rate must not jump with the tables.
#[test]
fn moving_the_elevation_disturbs_no_sliding_azimuth() {
    let mut world = World::new(&UnitSettings::default(), start(5.0));
    let hold_nm = |world: &World| 400.0 * (0.35 - world.axes[0].velocity_rad_per_s()) + 270.0;
    let mut previous = 0.0;
    for k in 0..60_000_u32 {
        let torque = [hold_nm(&world), if k < 20_000 { 1000.0 } else { 60.0 }];
        world.step(torque);
        let rate = world.motion().frame_rad_per_s[0];
        assert!((rate - previous).abs() < 2e-4, "{previous} to {rate} at step {k}");
        previous = rate;
    }
    assert!(world.axes[1].angle_rad() > 0.8, "elevation has moved to {}", world.axes[1].angle_rad());
}

/// A second of azimuth's torque: what leaks into the elevation of the frame is 0.5 % at the horizon and 1.5 % more towards the
/// zenith, by the sine.
#[test]
fn coupling_of_the_axes_that_grows_with_elevation_is_that_of_the_horizon_there() {
    let leak = |growth_ratio: f64, el_deg: f64| {
        let mut unit = UnitSettings { cross_coupling_growth_ratio: growth_ratio, ..UnitSettings::default() };
        unit.az_structure = unit.az_structure.frozen_at(0.5);
        let mut world = World::new(&unit, start(el_deg));
        (0..200).for_each(|_| world.step([2000.0, 0.0]));
        let own = world.axes[1].frame().angle_rad + world.axes[1].rigid_rad();
        (world.frame().rad[1] - own) / world.axes[0].frame().angle_rad
    };
    assert!((leak(0.0, 60.0) - 0.005).abs() < 1e-9);
    assert!((leak(0.015, 0.0) - 0.005).abs() < 1e-6);
    assert!((leak(0.015, 60.0) - 0.005 - 0.015 * 60_f64.to_radians().sin()).abs() < 1e-6);
}
