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
    age_ticks: u32,
}

impl RateFeedback {
    /// No sample yet.
    pub fn new(gains: &DirectorGains) -> Self {
        Self {
            mount: ImuMount::new(gains.elevation_sign),
            earth: EarthRate::new(&gains.earth),
            rad_per_s: [0.0; 2],
            age_ticks: u32::MAX,
        }
    }

    /// Once a tick: turns the newest valid sample into axis rates; `axes` are azimuth and elevation. Without a new one
    /// the rates stay and age.
    pub fn update(&mut self, imu: Option<&Kvh>, axes: &[Actuals]) {
        self.age_ticks = self.age_ticks.saturating_add(1);
        let (Some(imu), [az, el, ..]) = (imu, axes) else { return };
        if let (0, Ok(sample)) = (imu.age_ticks(), imu.valid_sample()) {
            let rates = self.mount.axis_rates(sample.rate_rad_per_s, el.position_rad);
            // What the gyro reads on an axis that stands still on the Earth is no motion of that axis.
            self.rad_per_s = [
                rates.az_rad_per_s - self.earth.azimuth_rad_per_s(),
                rates.el_rad_per_s - self.earth.elevation_rad_per_s(az.position_rad),
            ];
            self.age_ticks = 0;
        }
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
