//! The position loop around the velocity loop, linear.

use num_complex::Complex64;

use super::Subject;
use crate::linear::{Sensor, VelocityLoop, step_response};

/// Rate of the control computer.
pub const LOOP_RATE_HZ: f64 = 4000.0;
/// Hold and plant leave (f/f_s)²/k² of image k: below 1e-4 of the response from the second on up to 80 Hz.
const NEAREST_IMAGES: i32 = 1;
/// A move that the torque limit leaves linear.
const STEP_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// What the series behind the step response leaves uncertain, as a ratio of the step.
const SERIES_RATIO: f64 = 1e-4;

/// The velocity loop on the gyro.
pub(super) fn velocity(subject: &Subject<'_>, axis: usize, elevation_deg: f64) -> VelocityLoop {
    let unit = subject.unit;
    let gains = subject.gains(axis);
    let elevation_rad = elevation_deg.to_radians();
    let full = VelocityLoop::new(unit, axis, elevation_rad, Sensor::Gyro, gains, LOOP_RATE_HZ);
    VelocityLoop { images_count: NEAREST_IMAGES, ..full }
}

/// Position command to position, with the encoder's age in the feedback.
pub(super) fn closed(subject: &Subject<'_>, axis: usize, velocity: &VelocityLoop, hz: f64) -> Complex64 {
    let s = Complex64::new(0.0, std::f64::consts::TAU * hz);
    let forward = subject.gains(axis).position_gain_per_s * velocity.command_to_shaft(hz) / s;
    let aged = (-s * subject.axis(axis).sensor_delay_s).exp();
    forward / (1.0 + forward * aged)
}

/// Overshoot of a step of the position command; 0 where the series cannot tell it from none.
pub(super) fn overshoot_rad(subject: &Subject<'_>, axis: usize) -> f64 {
    let velocity = velocity(subject, axis, 0.0);
    let ratio = step_response(|hz| closed(subject, axis, &velocity, hz)).overshoot_ratio;
    if ratio > SERIES_RATIO { ratio * STEP_RAD } else { 0.0 }
}
