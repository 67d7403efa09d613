use std::f64::consts::FRAC_1_SQRT_2;

use super::*;
use crate::physics::inertial::Mount;

const ELEVATIONS_DEG: [f64; 9] = [-10.0, 0.0, 10.0, 30.0, 45.0, 60.0, 75.0, 89.9, 90.0];

/// The study's mapping (App. B), written out here: [ω_el, ω_az] from the rates about X, Y, Z.
fn mapped(elevation_rad: f64, [x, y, z]: [f64; 3]) -> [f64; 2] {
    let c = FRAC_1_SQRT_2;
    let (sin, cos) = elevation_rad.sin_cos();
    [c * x - c * y, c * cos * x + c * cos * y + sin * z]
}

/// Rates that the driver reports after ten messages of a steady turn.
fn rates_of_a_turn(imu: &ImuSettings, start_rad: [f64; 2], rate_rad_per_s: [f64; 2]) -> ([f64; 3], f64) {
    let motion = |tick: u64| {
        let t = tick as f64 / RATE_HZ;
        let frame_rad = [start_rad[0] + rate_rad_per_s[0] * t, start_rad[1] + rate_rad_per_s[1] * t];
        Motion { frame_rad, frame_rad_per_s: rate_rad_per_s, ..Motion::default() }
    };
    let mut pair = Pair::open(imu, driver_settings(), &motion(0));
    while pair.tick < 100 {
        let next = motion(pair.tick + 1);
        pair.tick(&next);
    }
    // The newest message taken is that of tick 99; it holds the mean since tick 98.
    let middle_rad = start_rad[1] + rate_rad_per_s[1] * 98.5 / RATE_HZ;
    (pair.driver.valid_sample().expect("healthy").rate_rad_per_s, middle_rad)
}

#[test]
fn azimuth_spin_returns_its_rate_at_all_elevations() {
    for degrees in ELEVATIONS_DEG {
        let elevation = degrees.to_radians();
        let (rates, _) = rates_of_a_turn(&perfect(), [0.4, elevation], [0.8, 0.0]);
        let [el, az] = mapped(elevation, rates);
        assert!((az - 0.8).abs() < 1e-7 && el.abs() < 1e-7, "{degrees}°: {az} {el}");
    }
}

/// The nominal unit's misalignment (141 µrad about a transverse axis at most) and scale errors show, and nothing more.
#[test]
fn the_nominal_unit_returns_the_spin_within_its_tolerances() {
    let imu = ImuSettings { gyro_noise_factor: 0.0, ..UnitSettings::default().imu };
    for degrees in ELEVATIONS_DEG {
        let elevation = degrees.to_radians();
        let (rates, _) = rates_of_a_turn(&imu, [0.4, elevation], [0.8, 0.0]);
        let [el, az] = mapped(elevation, rates);
        let earth_up = 72.92e-6 * 40.0_f64.to_radians().sin();
        assert!((az - 0.8 - earth_up).abs() < 2e-4 * 0.8, "{degrees}°: {az}");
        assert!(el.abs() < 3e-4 * 0.8 && el.abs() > 1e-6, "{degrees}°: {el}");
    }
}

#[test]
fn raising_the_elevation_turns_backwards_about_its_axis() {
    let (rates, middle) = rates_of_a_turn(&perfect(), [0.0, 0.2], [0.0, 0.5]);
    let [el, az] = mapped(middle, rates);
    assert!((el + 0.5).abs() < 1e-7 && az.abs() < 1e-7, "{el} {az}");
}

#[test]
fn both_axes_at_once_are_told_apart() {
    let (rates, middle) = rates_of_a_turn(&perfect(), [0.1, 0.3], [-0.6, 0.9]);
    let [el, az] = mapped(middle, rates);
    assert!((el + 0.9).abs() < 1e-7 && (az + 0.6).abs() < 1e-7, "{el} {az}");
}

/// With the sign of one gyro wrong the spin comes back as Ω·sin² el, or worse: the test has teeth.
#[test]
fn a_wrong_gyro_sign_does_not_return_the_spin() {
    for sensor in 0..3 {
        let mut imu = perfect();
        imu.gyro_sign_factor[sensor] = -1.0;
        let (rates, _) = rates_of_a_turn(&imu, [0.4, 45.0_f64.to_radians()], [0.8, 0.0]);
        let [_, az] = mapped(45.0_f64.to_radians(), rates);
        assert!((az - 0.8).abs() > 0.3, "gyro {sensor}: {az}");
    }
}

/// At the pole star's height the line of sight, heading north, is the axis of the Earth.
#[test]
fn the_earth_turns_about_its_pole() {
    let omega = 72.921_15e-6;
    let imu = ImuSettings { earth_rate_rad_per_s: omega, ..perfect() };
    let latitude = imu.latitude_rad;
    let (to_pole, _) = rates_of_a_turn(&imu, [0.0, latitude], [0.0; 2]);
    assert!((to_pole[2] - omega).abs() < 1e-11 && to_pole[0].abs() < 1e-11 && to_pole[1].abs() < 1e-11);
    let (west, _) = rates_of_a_turn(&imu, [90.0_f64.to_radians(), 0.0], [0.0; 2]);
    let [el, az] = mapped(0.0, west);
    // Looking west the left hand points south.
    assert!((el + omega * latitude.cos()).abs() < 1e-11, "{el}");
    assert!((az - omega * latitude.sin()).abs() < 1e-11, "{az}");
    assert!((az - 46.9e-6).abs() < 0.05e-6);
}

#[test]
fn accelerometers_read_plus_one_g_on_what_points_up() {
    let mut mount = Mount::new(&perfect());
    let mut force = |degrees: f64| {
        let motion = Motion { frame_rad: [0.0, degrees.to_radians()], ..Motion::default() };
        mount.feel(&motion).specific_force_m_per_s2
    };
    let g = 9.806_65;
    let close = |found: [f64; 3], expected: [f64; 3]| {
        assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-12), "{found:?} {expected:?}");
    };
    close(force(0.0), [g * FRAC_1_SQRT_2, g * FRAC_1_SQRT_2, 0.0]);
    close(force(90.0), [0.0, 0.0, g]);
    close(force(30.0), [g * 0.75_f64.sqrt() * FRAC_1_SQRT_2, g * 0.75_f64.sqrt() * FRAC_1_SQRT_2, 0.5 * g]);
}

/// Position of the unit on the ground by the angles alone, differentiated twice numerically.
#[test]
fn accelerations_at_the_lever_arm_are_those_of_its_path() {
    let imu = ImuSettings { lever_arm_m: [0.2, 0.3, 0.25], gravity_m_per_s2: 0.0, ..perfect() };
    let angles = |t: f64| [0.3 + 0.9 * t - 0.4 * t * t, 0.5 - 0.7 * t + 0.6 * t * t];
    // Axes on the ground: ahead and left at azimuth 0, up.
    let basis = |[az, el]: [f64; 2]| {
        let heading = [az.cos(), az.sin(), 0.0];
        let left = [-az.sin(), az.cos(), 0.0];
        let along = [0, 1, 2].map(|k| el.cos() * heading[k] + if k == 2 { el.sin() } else { 0.0 });
        let up = [0, 1, 2].map(|k| -el.sin() * heading[k] + if k == 2 { el.cos() } else { 0.0 });
        [left, up, along]
    };
    let place = |t: f64| {
        let [left, up, along] = basis(angles(t));
        [0, 1, 2].map(|k| 0.2 * left[k] + 0.3 * up[k] + 0.25 * along[k])
    };
    let h = 1e-4;
    let before = place(-h);
    let here = place(0.0);
    let after = place(h);
    let path = [0, 1, 2].map(|k| (before[k] - 2.0 * here[k] + after[k]) / (h * h));
    let motion = Motion {
        frame_rad: angles(0.0),
        frame_rad_per_s: [0.9, -0.7],
        frame_rad_per_s2: [-0.8, 1.2],
        ..Motion::default()
    };
    let [x, y, z] = Mount::new(&imu).feel(&motion).specific_force_m_per_s2;
    let c = FRAC_1_SQRT_2;
    let [left, up, along] =
        basis(angles(0.0)).map(|axis| axis[0] * path[0] + axis[1] * path[1] + axis[2] * path[2]);
    for (found, expected) in [(c * (x - y), left), (c * (x + y), up), (z, along)] {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

/// 20 K of warm-up with a time constant of 300 s, 60 ppm and 3 °/h a kelvin: nothing when the campaign begins, all of it after
/// an hour of plan, and the rate of a point in between is that of its place in the plan.
#[test]
fn a_unit_that_warms_up_has_the_scale_and_bias_of_its_place_in_the_plan() {
    let imu = ImuSettings {
        warm_up_degc: 20.0,
        gyro_scale_per_k_ratio: 60e-6,
        gyro_bias_per_k_rad_per_s: 1.5e-5,
        ..perfect()
    };
    let z_at = |planned_s: f64, rate_rad_per_s: f64| {
        let motion = |tick: u64| Motion {
            frame_rad: [rate_rad_per_s * tick as f64 / RATE_HZ, std::f64::consts::FRAC_PI_2],
            frame_rad_per_s: [rate_rad_per_s, 0.0],
            ..Motion::default()
        };
        let mut unit = Kvh::new(&imu, &address(), RATE_HZ).after(planned_s);
        (0..3).for_each(|tick| unit.pulse(tick, &motion(tick)));
        unit.sensors.reported().rate_rad_per_s[2]
    };
    for (planned_s, warmer) in [(0.0, 0.0), (300.0, 20.0 * (1.0 - (-1.0_f64).exp())), (36_000.0, 20.0)] {
        let expected = 0.5 * (1.0 + 60e-6 * warmer) + 1.5e-5 * warmer;
        let found = z_at(planned_s, 0.5);
        // A millisecond of the point warms the unit, too: 20 K/300 s.
        assert!((found - expected).abs() < 1e-8, "{planned_s} s: {found} for {expected}");
    }
}
