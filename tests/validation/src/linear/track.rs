//! Coarse track loop around the velocity loop.

use controllers::{Prediction, TrackSettings};
use num_complex::Complex64;
use sim_devices::unit::UnitSettings;

use super::{VelocityLoop, hold};

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
    /// Age that the law believes the line of sight to have.
    pub believed_age_s: f64,
    /// α and β of the target's prediction; 1 and 0 hold the newest frame.
    pub estimate: [f64; 2],
}

impl CoarseCamera {
    /// The coarse camera of a unit under the law that a velocity loop is closed over by.
    pub fn new(
        unit: &UnitSettings,
        velocity: &VelocityLoop,
        settings: &TrackSettings,
        law_period_s: f64,
    ) -> Self {
        let track = &velocity.gains.track;
        let camera = &unit.trackers.coarse;
        Self {
            gain_per_s: track.gain_per_s,
            integral_s: track.integral_time_s,
            rate_s: track.gyro_lead_s,
            law_period_s,
            frame_period_s: 1.0 / camera.frame_rate_hz,
            latency_s: camera.latency_s,
            scale_ratio: camera.scale_ratio,
            gyro_delay_s: velocity.plant.sensor_delay_s(),
            believed_age_s: settings.gyro_age_s,
            estimate: match settings.prediction {
                Prediction::Off => [1.0, 0.0],
                Prediction::ConstantVelocity => [settings.alpha, settings.beta],
            },
        }
    }

    /// From the target's angle at the exposures to the angle that the law has between frames: with z a frame,
    /// `x̂ = z(αz + β − α)/D`, `v̂ = (β/T)·z(z − 1)/D`, `D = z² + (α + β − 2)z + 1 − α` (Bar-Shalom et al. 2001, §6.5),
    /// and `x̂ + v̂·age` from the arrival of one frame to that of the next.
    fn frames(&self, s: Complex64) -> Complex64 {
        let late = (-s * self.latency_s).exp();
        let x = s * self.frame_period_s;
        let [alpha, beta] = self.estimate;
        if beta == 0.0 || x.norm() < 1e-9 {
            return late * hold(x);
        }
        let z = x.exp();
        let denominator = z * z + (alpha + beta - 2.0) * z + (1.0 - alpha);
        let angle = z * (alpha * z + beta - alpha) / denominator;
        let rate = beta * z * (z - 1.0) / denominator;
        // Mean of (d + t)·e^(−st) over a frame, in frames.
        let ahead = self.latency_s / self.frame_period_s * hold(x) + (hold(x) - (-x).exp()) / x;
        late * (angle * hold(x) + rate * ahead)
    }
}

/// Open loop at the velocity command: `Kt·(1 + 1/(Tt·s))·T_v·E` (modes.md §6, variant b).
///
/// The error answers the frame's rate by `E = A + e^{−s·d}·Tp + (scale/s − e^{s·a}·A)·F` with the line of sight
/// `A = e^{−s·d}·T·z/(z − 1)`, summed from rates of age d, which the law believes to be a old: the frames F see what
/// is wrong with the camera's scale and with that belief, and nothing else.
pub fn coarse_open_loop(velocity: &VelocityLoop, camera: &CoarseCamera, frequency_hz: f64) -> Complex64 {
    let s = Complex64::new(0.0, std::f64::consts::TAU * frequency_hz);
    let z = (s * camera.law_period_s).exp();
    let sum = camera.law_period_s * z / (z - 1.0);
    let law = camera.gain_per_s * (1.0 + sum / camera.integral_s);
    let half_hold = (-s * 0.5 * (camera.law_period_s - velocity.period_s)).exp();
    let aged = (-s * camera.gyro_delay_s).exp();
    let unseen = camera.scale_ratio / s - (s * camera.believed_age_s).exp() * aged * sum;
    let error = aged * (sum + camera.rate_s) + unseen * camera.frames(s);
    law * half_hold * velocity.command_to_frame(frequency_hz) * error
}
