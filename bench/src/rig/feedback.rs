//! Rates of the axes from the inertial unit, as the production velocity loops use them.

use controllers::DirectorGains;
use controllers::earth_rate::EarthRate;
use controllers::line_of_sight::ImuMount;
use drivers::cia402::Actuals;

use super::device::RateSensor;

/// Newest rates of azimuth and elevation relative to the ground.
#[derive(Clone, Debug)]
pub(crate) struct RateFeedback {
    mount: ImuMount,
    earth: EarthRate,
    rad_per_s: [f64; 2],
    smoothed_rad_per_s: [f64; 2],
    disagreement_rad_per_s: [f64; 2],
    period_s: f64,
    /// Age of the newest valid sample in periods, missed ones counted.
    age_ticks: u32,
    /// Periods since it came.
    silent_ticks: u32,
    /// Periods since the last sample that was smoothed; `None` before the first.
    unsmoothed: Option<u32>,
}

/// Time over which rates and their disagreement are smoothed.
const SMOOTHING_S: f64 = 0.020;

impl RateFeedback {
    /// No sample yet; `period_s` is that of the loop.
    pub(crate) fn new(gains: &DirectorGains, period_s: f64) -> Self {
        Self {
            mount: ImuMount::new(gains.elevation_sign),
            earth: EarthRate::new(&gains.earth),
            rad_per_s: [0.0; 2],
            smoothed_rad_per_s: [0.0; 2],
            disagreement_rad_per_s: [0.0; 2],
            period_s,
            age_ticks: u32::MAX,
            silent_ticks: u32::MAX,
            unsmoothed: None,
        }
    }

    /// Once a tick, so many periods after the one before: turns the newest valid sample into axis rates; `axes` are azimuth
    /// and elevation, `None` on a rig without gimbal. Without a new sample the rates stay and age.
    pub(crate) fn update(&mut self, imu: Option<RateSensor>, axes: Option<[&Actuals; 2]>, passed: u32) {
        self.age_ticks = self.age_ticks.saturating_add(passed);
        self.silent_ticks = self.silent_ticks.saturating_add(passed);
        self.unsmoothed = self.unsmoothed.map(|periods| periods.saturating_add(passed));
        let (Some(imu), Some([az, el])) = (imu, axes) else { return };
        let valid = imu.newest.filter(|sample| sample.is_valid);
        if let (0, Some(sample)) = (imu.age_ticks, valid) {
            let rates = self.mount.axis_rates(sample.rate_rad_per_s, el.position_rad);
            // What the gyro reads on an axis that stands still on the Earth is no motion of that axis.
            self.rad_per_s = [
                rates.az_rad_per_s - self.earth.azimuth_rad_per_s(),
                rates.el_rad_per_s - self.earth.elevation_rad_per_s(az.position_rad),
            ];
            self.age_ticks = self.unexplained(&imu, passed);
            self.silent_ticks = 0;
            // What the gyro said before a gap and the encoder after it are not of the same time.
            if self.age_ticks == 0 {
                self.smooth([az.velocity_rad_per_s, el.velocity_rad_per_s]);
            }
        }
    }

    /// Periods of a gap that no message is there for. A unit that sends on its own has sent on in the gap; one that is
    /// triggered by the loop has waited, and its newest message is from before the gap.
    fn unexplained(&self, imu: &RateSensor, passed: u32) -> u32 {
        let messages_s = f64::from(imu.new_count) / imu.message_rate_hz;
        passed.saturating_sub((messages_s / self.period_s).ceil() as u32)
    }

    fn smooth(&mut self, encoders: [f64; 2]) {
        let periods = self.unsmoothed.replace(0).unwrap_or(1);
        let share = (f64::from(periods) * self.period_s / SMOOTHING_S).min(1.0);
        for (k, smoothed) in self.disagreement_rad_per_s.iter_mut().enumerate() {
            *smoothed += share * (self.rad_per_s[k] - encoders[k] - *smoothed);
        }
        for (smoothed, rate) in self.smoothed_rad_per_s.iter_mut().zip(self.rad_per_s) {
            *smoothed += share * (rate - *smoothed);
        }
    }

    /// Gyro rate less encoder rate of an axis, smoothed over 20 ms.
    pub(crate) fn disagreement_rad_per_s(&self, axis: usize) -> f64 {
        self.disagreement_rad_per_s[axis]
    }

    /// Rate of an axis, smoothed over 20 ms: quiet enough to tell standstill.
    pub(crate) fn smoothed_rad_per_s(&self, axis: usize) -> f64 {
        self.smoothed_rad_per_s[axis]
    }

    /// Rate of an axis: 0 azimuth, 1 elevation.
    pub(crate) fn rad_per_s(&self, axis: usize) -> f64 {
        self.rad_per_s[axis]
    }

    /// Periods since the newest valid sample was taken; the largest number before the first.
    pub(crate) fn age_ticks(&self) -> u32 {
        self.age_ticks
    }

    /// Periods since the unit sent a valid sample, however old that was then: a unit that sends is alive.
    pub(crate) fn silent_ticks(&self) -> u32 {
        self.silent_ticks
    }
}
