use super::*;
use crate::unit::UnitSettings;
use crate::world::{StartState, World};

const RATE_HZ: f64 = 20_000.0;

fn axis(settings: &AxisSettings, angle_rad: f64) -> Axis {
    Axis::new(settings, angle_rad, 1.0 / RATE_HZ)
}

fn unit() -> UnitSettings {
    UnitSettings::default()
}

/// All of an axis by classical Runge–Kutta, written once more from the equations.
struct Reference {
    settings: AxisSettings,
    state: [f64; 4],
    step_s: f64,
}

impl Reference {
    fn rates(&self, [angle, velocity, z, age]: [f64; 4], motor_nm: f64) -> [f64; 4] {
        let s = &self.settings;
        let aged = s.ageing_ratio * s.static_torque_nm * (1.0 + age / s.ageing_time_s).ln();
        let exponent = (velocity.abs() / s.stribeck_velocity_rad_per_s).powf(s.stribeck_shape_exponent);
        let bristles =
            s.coulomb_torque_nm + (s.static_torque_nm + aged - s.coulomb_torque_nm) * (-exponent).exp();
        let z_rate = velocity - s.bristle_stiffness_nm_per_rad * velocity.abs() * z / bristles;
        let friction = s.bristle_stiffness_nm_per_rad * z
            + s.bristle_damping_nm_s_per_rad * z_rate
            + s.viscous_damping_nm_s_per_rad * velocity;
        let order = s.cogging_orders_per_rev * angle;
        let loads = s.cogging_amplitude_nm * (order + s.cogging_phase_rad).sin()
            + s.cogging_second_amplitude_nm * (2.0 * order + s.cogging_second_phase_rad).sin()
            + s.unbalance_nm * angle.cos()
            - s.spring_stiffness_nm_per_rad * (angle - s.spring_rest_rad);
        let age_rate = 1.0 - velocity.abs() * age * s.bristle_stiffness_nm_per_rad / s.static_torque_nm;
        [velocity, (motor_nm - friction + loads) / s.inertia_kg_m2, z_rate, age_rate]
    }

    fn advance(&mut self, motor_nm: f64, duration_s: f64) {
        let h = self.step_s;
        let moved =
            |state: [f64; 4], rate: [f64; 4], by: f64| std::array::from_fn(|k| state[k] + by * rate[k]);
        for _ in 0..(duration_s / h).round() as u32 {
            let one = self.rates(self.state, motor_nm);
            let two = self.rates(moved(self.state, one, h / 2.0), motor_nm);
            let three = self.rates(moved(self.state, two, h / 2.0), motor_nm);
            let four = self.rates(moved(self.state, three, h), motor_nm);
            let mean = std::array::from_fn(|k| (one[k] + 2.0 * two[k] + 2.0 * three[k] + four[k]) / 6.0);
            self.state = moved(self.state, mean, h);
        }
    }
}

/// Runs a torque (held for 250 µs as the loop holds it) through both; largest differences of angle and velocity.
fn compare(settings: &AxisSettings, start_rad: f64, torque: impl Fn(f64) -> f64, end_s: f64) -> (f64, f64) {
    let mut stepped = axis(settings, start_rad);
    let mut reference =
        Reference { settings: settings.clone(), state: [start_rad, 0.0, 0.0, 0.0], step_s: 1e-6 };
    let mut angle_error = 0.0_f64;
    let mut velocity_error = 0.0_f64;
    for tick in 0..(end_s * 4000.0).round() as u32 {
        let held = torque(f64::from(tick) / 4000.0);
        (0..5).for_each(|_| stepped.step(held));
        reference.advance(held, 250e-6);
        angle_error = angle_error.max((stepped.angle_rad() - reference.state[0]).abs());
        velocity_error = velocity_error.max((stepped.velocity_rad_per_s() - reference.state[1]).abs());
    }
    (angle_error, velocity_error)
}

/// Presliding, breakaway and gross sliding with cogging: 3 s of a 120 N·m/s ramp. Breakaway amplifies any difference,
/// still the angle agrees to a thirtieth of an encoder count.
#[test]
fn a_torque_ramp_through_breakaway_follows_the_fine_reference() {
    let (angle, velocity) = compare(&unit().az, 0.1, |t| 120.0 * t, 3.0);
    assert!(angle < 3e-9, "angle {angle:e} rad");
    assert!(velocity < 3e-9, "velocity {velocity:e} rad/s");
}

#[test]
fn torque_reversals_in_sliding_follow_the_fine_reference() {
    let torque = |t: f64| if ((t / 0.4) as u32).is_multiple_of(2) { 400.0 } else { -400.0 };
    for (settings, start) in [(unit().az, 0.0), (unit().el, 0.7)] {
        let (angle, velocity) = compare(&settings, start, torque, 1.6);
        assert!(angle < 3e-9, "angle {angle:e} rad");
        assert!(velocity < 2e-8, "velocity {velocity:e} rad/s");
    }
}

#[test]
fn constant_torque_ends_at_the_velocity_where_friction_balances_it() {
    let mut settings = unit().az;
    (settings.cogging_amplitude_nm, settings.cogging_second_amplitude_nm) = (0.0, 0.0);
    (settings.lower_stop_rad, settings.upper_stop_rad) = (-1e4, 1e4);
    let mut axis = axis(&settings, 0.0);
    let law = LuGre::new(&settings, 1.0 / RATE_HZ);
    (0..60 * 20_000).for_each(|_| axis.step(300.0));
    let friction = law.steady_torque_nm(axis.velocity_rad_per_s());
    assert!((friction - 300.0).abs() < 0.01, "{friction} N·m at {} rad/s", axis.velocity_rad_per_s());
}

/// Torque at which a 60 N·m/s (1 A/s) ramp after a rest first makes the axis faster than 2 mrad/s: by the world, and
/// by the reference.
fn onset_nm(settings: &AxisSettings, dwell_s: f64) -> (f64, f64) {
    let mut axis = axis(settings, 0.0);
    (0..(dwell_s * RATE_HZ) as u32).for_each(|_| axis.step(0.0));
    let mut torque = 0.0;
    while axis.velocity_rad_per_s() < 2e-3 {
        torque += 60.0 / 4000.0;
        (0..5).for_each(|_| axis.step(torque));
    }
    let mut reference =
        Reference { settings: settings.clone(), state: [0.0, 0.0, 0.0, dwell_s], step_s: 25e-6 };
    let mut expected = 0.0;
    while reference.state[1] < 2e-3 {
        expected += 60.0 / 4000.0;
        reference.advance(expected, 250e-6);
    }
    (torque, expected)
}

/// The contact rejuvenates while it creeps, so about half of the static ageing is left at the onset.
#[test]
fn a_longer_rest_raises_the_onset_of_motion_as_the_reference_says() {
    let mut settings = unit().az;
    (settings.cogging_amplitude_nm, settings.cogging_second_amplitude_nm) = (0.0, 0.0);
    let torques = [0.0, 1.0, 10.0, 100.0].map(|dwell| onset_nm(&settings, dwell));
    for (torque, expected) in torques {
        assert!((torque - expected).abs() <= 0.015 + 1e-9, "{torque} N·m instead of {expected}");
    }
    let rises: Vec<f64> = torques.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    let full_nm = 210.0 * 0.02 * (101.0_f64 / 11.0).ln();
    assert!(rises[2] > 0.4 * full_nm && rises[2] < full_nm, "{rises:?}");
    assert!(rises.iter().all(|rise| *rise > 0.0), "{rises:?}");
}

#[test]
fn sliding_into_a_stop_is_recorded_with_time_and_speed_and_loses_energy() {
    let settings = unit().el;
    let mut world = World::new(&unit(), StartState { az_rad: 0.0, el_rad: 1.3, heat_sink_degc: 40.0 });
    let mut last_speed = 0.0;
    while world.record().crashes.is_empty() {
        last_speed = world.axes[1].velocity_rad_per_s();
        world.axes[1].step(300.0);
    }
    let (name, time_s, speed) = world.record().crashes[0].clone();
    assert_eq!(name, "el");
    assert!((speed / last_speed - 1.0).abs() < 1e-3 && speed > 0.1, "{speed}");
    let axis = &mut world.axes[1];
    assert!((time_s - axis.steps_count as f64 / RATE_HZ).abs() < 1e-9);
    let mut deepest = 0.0_f64;
    let mut rebound = 0.0_f64;
    for _ in 0..20_000 {
        axis.step(0.0);
        deepest = deepest.max(axis.stops.depth_rad(axis.angle_rad()));
        rebound = rebound.max(-axis.velocity_rad_per_s());
    }
    assert!(deepest > 0.0 && deepest < 1.0_f64.to_radians(), "{deepest}");
    assert!(rebound > 0.0 && rebound < 0.6 * speed, "{rebound} after {speed}");
    assert!(axis.angle_rad() < settings.upper_stop_rad);
}

#[test]
fn leaning_on_a_stop_is_one_crash_and_leaving_it_arms_the_next() {
    let mut world = World::new(&unit(), StartState { az_rad: 2.79, el_rad: 0.0, heat_sink_degc: 40.0 });
    let az = &mut world.axes[0];
    for (torque, steps) in [(400.0, 60_000), (-400.0, 40_000), (400.0, 60_000)] {
        for _ in 0..steps {
            az.step(torque);
            az.follow(0.0);
        }
    }
    assert_eq!(az.crashes().len(), 2, "{:?}", az.crashes());
}

/// An undriven axis only ever loses energy (friction is passive, the stops dissipate).
#[test]
fn coasting_never_gains_energy() {
    let mut settings = unit().az;
    (settings.cogging_amplitude_nm, settings.cogging_second_amplitude_nm) = (0.0, 0.0);
    let mut axis = axis(&settings, 0.0);
    (0..20_000).for_each(|_| axis.step(1500.0));
    let mut energy = f64::INFINITY;
    for _ in 0..400_000 {
        axis.step(0.0);
        let bristles = 0.5 * settings.bristle_stiffness_nm_per_rad * axis.contact.deflection_rad.powi(2);
        let now = 0.5 * settings.inertia_kg_m2 * axis.velocity_rad_per_s.powi(2) + bristles;
        assert!(now <= energy * (1.0 + 1e-9) + 1e-12, "{now} after {energy}");
        energy = now;
    }
    assert!(energy < 0.5 * settings.bristle_stiffness_nm_per_rad * (230.0_f64 / 90_000.0).powi(2));
}

/// The short cut of a standing axis: same bits as without it, and it really is taken.
#[test]
fn the_standing_short_cut_changes_no_bit() {
    for (settings, start) in [(unit().az, 0.1), (unit().el, 0.3)] {
        let mut quick = axis(&settings, start);
        let mut plain = axis(&settings, start);
        let mut standing = 0;
        for k in 0..1_200_000_u32 {
            let torque = if k < 1_000_000 { 0.0 } else { 0.001 * f64::from(k - 1_000_000) };
            quick.step(torque);
            plain.standing = false;
            plain.step(torque);
            standing += u32::from(quick.standing);
            assert_eq!(quick.angle_rad.to_bits(), plain.angle_rad.to_bits());
            assert_eq!(quick.contact, plain.contact);
        }
        assert!(standing > 500_000, "stood for {standing} of 1000000 steps");
    }
}

/// Slid at 10 °/s both ways, by the torque that keeps the speed: 30 % more one way, as much less the other, and twice as
/// much in the middle of a spot.
#[test]
fn friction_by_direction_and_a_spot_are_in_the_torque_of_a_sliding_axis() {
    let even = AxisSettings {
        cogging_amplitude_nm: 0.0,
        cogging_second_amplitude_nm: 0.0,
        viscous_damping_nm_s_per_rad: 0.0,
        ..unit().az
    };
    let friction = |settings: &AxisSettings, start_rad: f64, velocity: f64| {
        let law = LuGre::new(settings, 1.0 / RATE_HZ);
        let mut contact = Contact::default();
        let mut torque = 0.0;
        for _ in 0..20_000 {
            let step = law.predict(&contact, start_rad, velocity);
            torque = step.offset_nm + step.slope_nm_s_per_rad * velocity;
            step.apply(&mut contact, velocity);
        }
        torque
    };
    let plain = friction(&even, 0.0, 0.2);
    let lame = AxisSettings { friction_asymmetry_ratio: 0.3, ..even };
    assert!((friction(&lame, 0.0, 0.2) / plain - 1.3).abs() < 1e-3);
    assert!((friction(&lame, 0.0, -0.2) / plain + 0.7).abs() < 1e-3);
    let spotted = AxisSettings { friction_spot_ratio: 1.0, friction_spot_rad: 0.4, ..even };
    assert!((friction(&spotted, 0.4, 0.2) / plain - 2.0).abs() < 1e-3);
    assert!((friction(&spotted, 0.6, 0.2) / plain - 1.0).abs() < 1e-12);
}
