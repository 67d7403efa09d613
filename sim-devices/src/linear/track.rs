//! Coarse track loop around the velocity loop.

use num_complex::Complex64;

use super::VelocityLoop;

/// The camera and the law that closes the loop over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoarseCamera {
    /// Proportional gain Kt.
    pub gain_per_s: f64,
    /// Integral time Tt.
    pub integral_s: f64,
    /// Rate damping Tp.
    pub rate_s: f64,
    /// Period of the law.
    pub law_period_s: f64,
    /// Period of the frames; 0 for a camera that answers at every period of the law.
    pub frame_period_s: f64,
    /// From exposure to the law.
    pub latency_s: f64,
    /// Angle that the camera reports per true angle.
    pub scale_ratio: f64,
    /// Age of the gyro rates that the line of sight is integrated from.
    pub gyro_delay_s: f64,
}

/// Open loop at the velocity command: `Kt·(1 + 1/(Tt·s))·T_v·E`, where the error answers the line of sight by
/// `E = e^{−s·d}·(1/s + Tp) + (scale − 1)·F/s`: gyro-integrated line of sight of age d, and what the frames F add
/// where the camera's scale is wrong (modes.md §6, variant b).
pub fn coarse_open_loop(velocity: &VelocityLoop, camera: &CoarseCamera, frequency_hz: f64) -> Complex64 {
    let s = Complex64::new(0.0, std::f64::consts::TAU * frequency_hz);
    let z = (s * camera.law_period_s).exp();
    let law = camera.gain_per_s * (1.0 + camera.law_period_s / camera.integral_s * z / (z - 1.0));
    let half_hold = (-s * 0.5 * (camera.law_period_s - velocity.period_s)).exp();
    let aged = (-s * camera.gyro_delay_s).exp();
    let frames = (-s * camera.latency_s).exp() * hold(s * camera.frame_period_s);
    let error = aged * (1.0 / s + camera.rate_s) + (camera.scale_ratio - 1.0) * frames / s;
    law * half_hold * velocity.command_to_frame(frequency_hz) * error
}

fn hold(x: Complex64) -> Complex64 {
    if x.norm() < 1e-9 { Complex64::new(1.0, 0.0) } else { (1.0 - (-x).exp()) / x }
}
