//! What the bench believes of an axis while it is being stopped.

use drivers::cia402::Actuals;

/// Time over which standstill looks at rates.
const STANDSTILL_SMOOTHING_S: f64 = 0.020;

/// Error codes of drives whose position is not valid (protocols.md: 7305h incremental sensor, 7306h and on encoder).
const SENSOR_ERRORS: std::ops::RangeInclusive<u16> = 0x7300..=0x733F;

/// What was learned about an axis: whether its encoder lies, whether its torque drives it; and its angle without an encoder.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reckoning {
    pub(super) position_rad: f64,
    /// Rate of the encoder, smoothed over 20 ms: one count of it is more than standstill allows.
    pub(super) smoothed_rad_per_s: f64,
    pub(super) distrusts_encoder: bool,
    pub(super) loses_torque: bool,
}

impl Reckoning {
    /// Once a tick, `passed_s` after the one before: where the encoder cannot be trusted any more, the gyro carries the
    /// angle on over all the time that has passed.
    pub(super) fn take(&mut self, actuals: &Actuals, gyro_rad_per_s: f64, passed_s: f64) {
        self.distrusts_encoder |= SENSOR_ERRORS.contains(&actuals.error_code);
        let share = (passed_s / STANDSTILL_SMOOTHING_S).min(1.0);
        self.smoothed_rad_per_s += share * (actuals.velocity_rad_per_s - self.smoothed_rad_per_s);
        if self.distrusts_encoder {
            self.position_rad += gyro_rad_per_s * passed_s;
        } else {
            self.position_rad = actuals.position_rad;
        }
    }
}

/// Slower than this is standing still (safety.md: standstill).
const STANDSTILL_RAD_PER_S: f64 = 0.05 * std::f64::consts::PI / 180.0;

/// Angle and rate of an axis, from whichever sensor is believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Believed {
    /// Angle.
    pub position_rad: f64,
    /// Rate, signed.
    pub rate_rad_per_s: f64,
    /// Speed, the larger of what encoder and gyro say: standstill is what both show.
    pub speed_rad_per_s: f64,
}

impl Believed {
    /// Whether both sensors show standstill. A speed that is no number is none.
    pub fn stands(&self) -> bool {
        self.speed_rad_per_s < STANDSTILL_RAD_PER_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An axis that turned at 0.5 rad/s when its encoder broke, by a gyro that is right.
    fn reckoned(ticks: &[u32]) -> f64 {
        let mut reckoned = Reckoning::default();
        let actuals = Actuals { position_rad: 0.3, ..Actuals::default() };
        reckoned.take(&actuals, 0.5, 250e-6);
        reckoned.distrusts_encoder = true;
        for &periods in ticks {
            reckoned.take(&actuals, 0.5, 250e-6 * f64::from(periods));
        }
        reckoned.position_rad
    }

    #[test]
    fn without_an_encoder_the_gyro_carries_the_angle_over_missed_periods_too() {
        let (whole, gap) = (reckoned(&[1; 100]), reckoned(&[&[1; 34][..], &[33], &[1; 33]].concat()));
        assert!((whole - 0.3 - 0.5 * 0.025).abs() < 1e-12, "{whole}");
        assert!((gap - whole).abs() < 1e-12, "{gap} rad instead of {whole}");
    }

    #[test]
    fn a_twentieth_of_a_degree_per_second_is_motion_and_so_is_a_speed_that_nobody_knows() {
        let at = |deg_per_s: f64| Believed {
            position_rad: 0.0,
            rate_rad_per_s: 0.0,
            speed_rad_per_s: deg_per_s.to_radians(),
        };
        assert!(at(0.049).stands());
        assert!(!at(0.051).stands() && !at(f64::NAN).stands());
    }
}
