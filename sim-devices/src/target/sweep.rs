//! A target simulator: a light that sweeps back and forth about its first direction at a constant rate.
//!
//! Nothing in the study moves as fast as an axis must turn to slide (0.03 and 0.20 rad/s against the rail's 0.012): with
//! it the loop is seen as it is in a fast engagement, not with the contact as a spring.

use super::TargetState;
use crate::unit::TargetSettings;

/// Constant rate between turn-rounds of constant acceleration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sweep {
    rates_rad_per_s: [f64; 2],
    /// From the middle of one turn-round to the middle of the next.
    leg_s: f64,
    /// From rest to the whole rate: half a turn-round.
    ramp_s: f64,
}

impl Sweep {
    pub(super) fn new(settings: &TargetSettings) -> Self {
        let leg_s = settings.sweep_leg_s;
        let rates_rad_per_s =
            [settings.sweep_azimuth_rate_rad_per_s, settings.sweep_elevation_rate_rad_per_s];
        Self { rates_rad_per_s, leg_s, ramp_s: (0.5 * settings.sweep_turn_s).min(0.5 * leg_s) }
    }

    /// Offset from the first direction and rate, a time after it began to move.
    pub(super) fn at(&self, time_s: f64) -> TargetState {
        let (way_s, share) = self.along(time_s);
        TargetState {
            angle_rad: self.rates_rad_per_s.map(|rate| rate * way_s),
            rate_rad_per_s: self.rates_rad_per_s.map(|rate| rate * share),
        }
    }

    /// Way as time at the whole rate, and rate as a share of it. The first leg is half a way: it begins in the middle.
    fn along(&self, time_s: f64) -> (f64, f64) {
        if time_s <= 0.0 {
            return (0.0, 0.0);
        }
        let half_way_s = 0.5 * (self.leg_s - self.ramp_s);
        let first_s = half_way_s + self.ramp_s;
        if time_s < first_s {
            return self.leg(time_s, first_s);
        }
        let legs = (time_s - first_s) / self.leg_s;
        let sign = if legs.floor() % 2.0 == 0.0 { -1.0 } else { 1.0 };
        let (way_s, share) = self.leg(legs.fract() * self.leg_s, self.leg_s);
        (sign * (way_s - half_way_s), sign * share)
    }

    /// One leg from rest to rest.
    fn leg(&self, time_s: f64, leg_s: f64) -> (f64, f64) {
        let ramp_s = self.ramp_s;
        let left_s = leg_s - time_s;
        if time_s < ramp_s {
            (0.5 * time_s * time_s / ramp_s, time_s / ramp_s)
        } else if left_s < ramp_s {
            (leg_s - ramp_s - 0.5 * left_s * left_s / ramp_s, left_s / ramp_s)
        } else {
            (time_s - 0.5 * ramp_s, 1.0)
        }
    }
}
