//! Rates of the axes from the inertial unit, as the production velocity loops use them.

use controllers::DirectorGains;
use controllers::earth_rate::EarthRate;
use controllers::line_of_sight::ImuMount;
use drivers::cia402::Actuals;
use drivers::kvh::Kvh;

/// Newest rates of azimuth and elevation relative to the ground.
#[derive(Clone, Debug)]
pub struct RateFeedback {
    mount: ImuMount,
    earth: EarthRate,
    rad_per_s: [f64; 2],
    smoothed_rad_per_s: [f64; 2],
    disagreement_rad_per_s: [f64; 2],
    age_ticks: u32,
}

/// Approach of the smoothed disagreement per sample: 20 ms at 4 kHz.
const SMOOTHING: f64 = 1.0 / 80.0;

impl RateFeedback {
    /// No sample yet.
    pub fn new(gains: &DirectorGains) -> Self {
        Self {
            mount: ImuMount::new(gains.elevation_sign),
            earth: EarthRate::new(&gains.earth),
            rad_per_s: [0.0; 2],
            smoothed_rad_per_s: [0.0; 2],
            disagreement_rad_per_s: [0.0; 2],
            age_ticks: u32::MAX,
        }
    }

    /// Once a tick: turns the newest valid sample into axis rates; `axes` are azimuth and elevation. Without a new one
    /// the rates stay and age.
    pub fn update(&mut self, imu: Option<&Kvh>, axes: &[Actuals]) {
        self.age_ticks = self.age_ticks.saturating_add(1);
        let (Some(imu), [az, el, ..]) = (imu, axes) else { return };
        let valid = imu.sample().filter(|sample| sample.valid[..3] == [true; 3]);
        if let (0, Some(sample)) = (imu.age_ticks(), valid) {
            let rates = self.mount.axis_rates(sample.rate_rad_per_s, el.position_rad);
            // What the gyro reads on an axis that stands still on the Earth is no motion of that axis.
            self.rad_per_s = [
                rates.az_rad_per_s - self.earth.azimuth_rad_per_s(),
                rates.el_rad_per_s - self.earth.elevation_rad_per_s(az.position_rad),
            ];
            self.age_ticks = 0;
            let encoders = [az.velocity_rad_per_s, el.velocity_rad_per_s];
            for (k, smoothed) in self.disagreement_rad_per_s.iter_mut().enumerate() {
                *smoothed += SMOOTHING * (self.rad_per_s[k] - encoders[k] - *smoothed);
            }
            for (smoothed, rate) in self.smoothed_rad_per_s.iter_mut().zip(self.rad_per_s) {
                *smoothed += SMOOTHING * (rate - *smoothed);
            }
        }
    }

    /// Gyro rate less encoder rate of an axis, smoothed over 20 ms.
    pub fn disagreement_rad_per_s(&self, axis: usize) -> f64 {
        self.disagreement_rad_per_s[axis]
    }

    /// Rate of an axis, smoothed over 20 ms: quiet enough to tell standstill.
    pub fn smoothed_rad_per_s(&self, axis: usize) -> f64 {
        self.smoothed_rad_per_s[axis]
    }

    /// Rate of an axis: 0 azimuth, 1 elevation.
    pub fn rad_per_s(&self, axis: usize) -> f64 {
        self.rad_per_s[axis]
    }

    /// Ticks since a valid sample arrived; the largest number before the first.
    pub fn age_ticks(&self) -> u32 {
        self.age_ticks
    }
}
