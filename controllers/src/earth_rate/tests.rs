use std::f64::consts::{FRAC_PI_2, PI};
use std::vec::Vec;

use super::*;
use crate::AxisGains;
use crate::line_of_sight::ImuMount;
use crate::position::PositionController;
use crate::velocity::VelocityController;

const SETTINGS: EarthSettings =
    EarthSettings { latitude_rad: 40.0 / 180.0 * PI, azimuth_zero_heading_rad: 0.3 };
const PERIOD_S: f64 = 250e-6;

/// The Earth's rate in the IMU's axes: north-west-up, turned by azimuth, then by elevation, then by 45°.
fn seen_by_the_imu(azimuth_rad: f64, elevation_rad: f64) -> [f64; 3] {
    let heading = SETTINGS.azimuth_zero_heading_rad - azimuth_rad;
    let north = EARTH_RATE_RAD_PER_S * SETTINGS.latitude_rad.cos();
    let up = EARTH_RATE_RAD_PER_S * SETTINGS.latitude_rad.sin();
    let ahead = north * heading.cos();
    let left = north * heading.sin();
    // e1 points left, e2 up in the image, e3 along the line of sight.
    let e2 = up * elevation_rad.cos() - ahead * elevation_rad.sin();
    let e3 = up * elevation_rad.sin() + ahead * elevation_rad.cos();
    let c = 0.5_f64.sqrt();
    [c * (e2 + left), c * (e2 - left), e3]
}

#[test]
fn vertical_part_is_46_9_microradians_per_second_at_40_degrees() {
    assert!((EarthRate::new(&SETTINGS).azimuth_rad_per_s() - 46.9e-6).abs() < 0.05e-6);
}

#[test]
fn line_of_sight_to_the_east_sinks_and_to_the_north_does_not_move_in_elevation() {
    let earth = EarthRate::new(&EarthSettings { azimuth_zero_heading_rad: 0.0, ..SETTINGS });
    let north = EARTH_RATE_RAD_PER_S * SETTINGS.latitude_rad.cos();
    assert!((earth.elevation_rad_per_s(-FRAC_PI_2) + north).abs() < 1e-18, "azimuth -90 deg is east");
    assert!((earth.elevation_rad_per_s(FRAC_PI_2) - north).abs() < 1e-18);
    assert!(earth.elevation_rad_per_s(0.0).abs() < 1e-18);
}

#[test]
fn readings_are_those_of_an_imu_that_is_turned_into_every_pose() {
    let earth = EarthRate::new(&SETTINGS);
    let mount = ImuMount::new(-1.0);
    for azimuth_rad in [-2.7, -1.0, 0.0, 0.4, 2.0] {
        for elevation_rad in [-0.17, 0.0, 0.8, 1.57] {
            let rates = mount.axis_rates(seen_by_the_imu(azimuth_rad, elevation_rad), elevation_rad);
            assert!((rates.az_rad_per_s - earth.azimuth_rad_per_s()).abs() < 1e-18);
            let expected = earth.elevation_rad_per_s(azimuth_rad);
            assert!((rates.el_rad_per_s - expected).abs() < 1e-18);
            let expected = earth.cross_elevation_rad_per_s(azimuth_rad, elevation_rad);
            assert!((rates.cross_elevation_rad_per_s - expected).abs() < 1e-18);
        }
    }
}

/// Position errors of a step by `step_rad`, the velocity loop on a gyro that also feels the Earth. P gain 4.5.
fn errors_after_a_step(step_rad: f64, compensation_rad_per_s: f64) -> Vec<f64> {
    let gains = AxisGains {
        velocity_kp_nm_s_per_rad: 23_600.0,
        velocity_ki_nm_per_rad: 447_500.0,
        position_gain_per_s: 4.5,
        ..AxisGains::default()
    };
    let position_loop = PositionController::new(&gains, 1.0);
    let mut velocity_loop = VelocityController::new(&gains, 1e6, PERIOD_S);
    let earth_rad_per_s = EarthRate::new(&SETTINGS).azimuth_rad_per_s();
    let mut angle_rad = 0.0;
    let mut rate_rad_per_s = 0.0;
    (0..24_000)
        .map(|_| {
            let command = position_loop.update(step_rad, angle_rad, compensation_rad_per_s);
            let torque_nm = velocity_loop.update(command, rate_rad_per_s + earth_rad_per_s, 0.0);
            rate_rad_per_s += (torque_nm - 273.6 * rate_rad_per_s) / 1200.0 * PERIOD_S;
            angle_rad += rate_rad_per_s * PERIOD_S;
            step_rad - angle_rad
        })
        .collect()
}

#[test]
fn uncompensated_earth_rate_leaves_10_4_microradians() {
    let last_rad = errors_after_a_step(5e-3, 0.0)[23_999];
    assert!((last_rad - 10.4e-6).abs() < 0.05e-6, "{last_rad}");
}

#[test]
fn compensated_earth_rate_leaves_no_error_and_no_overshoot() {
    let errors_rad = errors_after_a_step(5e-3, EarthRate::new(&SETTINGS).azimuth_rad_per_s());
    assert!(errors_rad[23_999].abs() < 1e-12, "{}", errors_rad[23_999]);
    let overshoot_rad = errors_rad.iter().fold(0.0, |worst: f64, error| worst.max(-error));
    // Only from the first instant, before the loop's integral knows the Earth: a thousandth of the limit of 3 µrad.
    assert!(overshoot_rad < 3e-9, "{overshoot_rad}");
}
