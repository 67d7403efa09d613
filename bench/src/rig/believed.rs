//! What the bench believes of an axis while it is being stopped.

use drivers::cia402::Actuals;

use super::{ArmedRig, FEEDBACK_AGE_TICKS};

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

impl ArmedRig {
    /// What was learned about sensors, torque and DC link while something was stopped is forgotten: a new point begins, and
    /// somebody has looked at the rig since a trip. Track loops begin anew with it.
    pub fn trust_again(&mut self) {
        for reckoned in &mut self.reckoned {
            (reckoned.distrusts_encoder, reckoned.loses_torque) = (false, false);
        }
        (self.distrusts_gyro, self.link_is_full) = (false, false);
        self.tracking.begin_anew();
    }

    /// From now on the encoder of an axis is not believed any more: it is frozen. Gives whether that is new.
    pub fn distrust_encoder(&mut self, axis: usize) -> bool {
        !std::mem::replace(&mut self.reckoned[axis].distrusts_encoder, true)
    }

    /// Whether an axis is steered by the gyro alone.
    pub fn distrusts_an_encoder(&self) -> bool {
        self.reckoned.iter().any(|reckoned| reckoned.distrusts_encoder)
    }

    /// Whether a fresh gyro sees an axis turn at another rate than its encoder does.
    pub fn gyro_contradicts(&self, axis: usize) -> bool {
        let Some(place) = self.gyro_place(axis) else { return false };
        let difference = self.feedback.rad_per_s(place) - self.actuals[axis].velocity_rad_per_s;
        self.feedback.age_ticks() <= FEEDBACK_AGE_TICKS
            && difference.abs() > self.axes[axis].guard.safety.max_rate_disagreement_rad_per_s
    }

    /// From now on the gyro is not believed any more: it is silent or frozen. Gives whether that is new.
    pub fn distrust_gyro(&mut self) -> bool {
        !std::mem::replace(&mut self.distrusts_gyro, true)
    }

    /// From now on the axis gets no torque any more, not even to be stopped: torque is what drives it.
    pub fn forbid_torque(&mut self, axis: usize) {
        self.reckoned[axis].loses_torque = true;
    }

    /// Whether it gets none.
    pub fn torque_is_forbidden(&self, axis: usize) -> bool {
        self.reckoned[axis].loses_torque
    }

    /// What the drive of an axis said, with angle and rate replaced by what is believed.
    pub fn believed_actuals(&self, axis: usize) -> Actuals {
        let believed = self.believed(axis);
        Actuals {
            position_rad: believed.position_rad,
            velocity_rad_per_s: believed.rate_rad_per_s,
            ..self.actuals[axis]
        }
    }

    /// Angle, rate and speed of an axis by all that there is. With a broken encoder the gyro says; with neither nobody
    /// knows, and the speed is infinite: that is no standstill.
    pub fn believed(&self, axis: usize) -> Believed {
        let reckoned = &self.reckoned[axis];
        let encoder = self.actuals[axis].velocity_rad_per_s;
        let smoothed = reckoned.smoothed_rad_per_s;
        let place = self.gyro_place(axis);
        // A loop needs the rate without delay, standstill without noise.
        let raw = place.map_or(0.0, |place| self.feedback.rad_per_s(place));
        let gyro = place.map_or(0.0, |place| self.feedback.smoothed_rad_per_s(place));
        // One late sample is no reason to steer by nothing: the next one is on its way.
        let sends = self.feedback.silent_ticks() <= FEEDBACK_AGE_TICKS && !self.distrusts_gyro;
        let gyro_is_alive = sends && place.is_some();
        let (rate, speed) = match (reckoned.distrusts_encoder, gyro_is_alive) {
            (false, true) => (encoder, smoothed.abs().max(gyro.abs())),
            (false, false) => (encoder, smoothed.abs()),
            (true, true) => (raw, gyro.abs()),
            (true, false) => (raw, f64::INFINITY),
        };
        Believed { position_rad: reckoned.position_rad, rate_rad_per_s: rate, speed_rad_per_s: speed }
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
        let whole = reckoned(&[1; 100]);
        let gap = reckoned(&[&[1; 34][..], &[33], &[1; 33]].concat());
        assert!((whole - 0.3 - 0.5 * 0.025).abs() < 1e-12, "{whole}");
        assert!((gap - whole).abs() < 1e-12, "{gap} rad instead of {whole}");
    }

    #[test]
    fn a_twentieth_of_a_degree_per_second_is_motion_and_so_is_a_speed_that_nobody_knows() {
        let with_speed = |deg_per_s: f64| Believed {
            position_rad: 0.0,
            rate_rad_per_s: 0.0,
            speed_rad_per_s: deg_per_s.to_radians(),
        };
        assert!(with_speed(0.049).stands());
        assert!(!with_speed(0.051).stands() && !with_speed(f64::NAN).stands());
    }
}
