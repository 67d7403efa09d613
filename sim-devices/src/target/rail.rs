//! A cart on rails: back and forth, reversed by hand, a heave at every joint.

use std::f64::consts::TAU;

use super::tones::Tones;
use super::{Place, velocity_step};
use crate::physics::noise::SeedAddress;
use crate::unit::TargetSettings;

/// The heave has died to 2 % when this many time constants are over.
const TIME_CONSTANTS_TO_2_PERCENT: f64 = 3.912;
/// Time constants of the heave to those of its onset; without an onset its velocity would jump.
const DECAY_PER_ONSET: f64 = 8.0;
/// Wavelengths of the unevenness, longest and shortest, in cycles per metre (ours).
const RIPPLE_PER_M: [f64; 2] = [0.1, 1.0];
/// Wavelengths of their height (ours).
const WAVES_PER_M: [f64; 2] = [0.05, 0.5];

#[derive(Clone, Debug)]
pub(super) struct Rail {
    speed_m_per_s: f64,
    joint_m: f64,
    rails_count: f64,
    /// Time from one reversal to the next.
    leg_s: f64,
    reversal_s: f64,
    ripple: Tones,
    waves: Tones,
    /// Path offset and height at the start of the track: taken away, so that the target stands where it shall.
    ripple_at_start_m: f64,
    waves_at_start_m: f64,
    jerk_m: f64,
    jerk_rad_per_s: f64,
    decay_s: f64,
}

/// One way along the rails, its reversal included: velocity changes by `change` from the start on.
struct Leg {
    start_m: f64,
    start_m_per_s: f64,
    change_m_per_s: f64,
    /// Since the leg began.
    time_s: f64,
}

impl Rail {
    pub(super) fn new(settings: &TargetSettings, address: &SeedAddress) -> Self {
        let rails_count = settings.rail_count.round().max(1.0);
        let leg_s = rails_count * settings.rail_length_m / settings.rail_speed_m_per_s;
        let ripple = Tones::new(address, "target.rail-ripple", RIPPLE_PER_M, settings.rail_ripple_ratio);
        let waves = Tones::new(address, "target.rail-waves", WAVES_PER_M, settings.rail_waviness_ratio);
        Self {
            speed_m_per_s: settings.rail_speed_m_per_s,
            joint_m: settings.rail_length_m,
            rails_count,
            leg_s,
            reversal_s: settings.rail_reversal_s.min(leg_s),
            ripple_at_start_m: ripple.at(0.0).0,
            ripple,
            waves_at_start_m: waves.at(0.0).0,
            waves,
            jerk_m: settings.rail_jerk_m,
            jerk_rad_per_s: TAU * settings.rail_jerk_hz,
            decay_s: settings.rail_jerk_s / TIME_CONSTANTS_TO_2_PERCENT,
        }
    }

    pub(super) fn length_m(&self) -> f64 {
        self.joint_m * self.rails_count
    }

    pub(super) fn at(&self, time_s: f64) -> Place {
        if time_s <= 0.0 {
            return Place::default();
        }
        let leg = self.leg(time_s);
        let (share, integral_s) = velocity_step(leg.time_s, self.reversal_s);
        let path_m = leg.start_m + leg.start_m_per_s * leg.time_s + leg.change_m_per_s * integral_s;
        let path_m_per_s = leg.start_m_per_s + leg.change_m_per_s * share;
        // Unevenness belongs to the rails, so it is the same on the way back and stands still with the cart.
        let (ripple_m, ripple_rate) = self.ripple.at(path_m);
        let (wave_m, slope) = self.waves.at(path_m);
        let (heave_m, heave_m_per_s) = self.heave(&leg);
        Place {
            along_m: path_m + ripple_m - self.ripple_at_start_m,
            up_m: wave_m - self.waves_at_start_m + heave_m,
            along_m_per_s: path_m_per_s * (1.0 + ripple_rate),
            up_m_per_s: slope * path_m_per_s + heave_m_per_s,
        }
    }

    /// Positions at the start of each leg: 0, then v(T − r/2) and v·r/2 in turn, as the reversals at both ends take
    /// the same time as the first departure.
    fn leg(&self, time_s: f64) -> Leg {
        let number = (time_s / self.leg_s).floor();
        let time_s = time_s - number * self.leg_s;
        let speed = self.speed_m_per_s;
        let half_m = 0.5 * speed * self.reversal_s;
        if number == 0.0 {
            Leg { start_m: 0.0, start_m_per_s: 0.0, change_m_per_s: speed, time_s }
        } else if number % 2.0 == 1.0 {
            let start_m = speed * self.leg_s - half_m;
            Leg { start_m, start_m_per_s: speed, change_m_per_s: -2.0 * speed, time_s }
        } else {
            Leg { start_m: half_m, start_m_per_s: -speed, change_m_per_s: 2.0 * speed, time_s }
        }
    }

    /// Height and its rate after the last joint of this leg.
    fn heave(&self, leg: &Leg) -> (f64, f64) {
        let velocity = leg.start_m_per_s + leg.change_m_per_s;
        // The straight line on which the cart runs once the reversal is over.
        let origin_m = leg.start_m - 0.5 * leg.change_m_per_s * self.reversal_s;
        let on_line_m = origin_m + velocity * leg.time_s;
        let joint = if velocity > 0.0 {
            (on_line_m / self.joint_m).floor().min(self.rails_count - 1.0)
        } else {
            (on_line_m / self.joint_m).ceil().max(1.0)
        };
        let since_s = leg.time_s - (joint * self.joint_m - origin_m) / velocity;
        let exists = joint >= 1.0 && joint <= self.rails_count - 1.0;
        if exists && since_s > 0.0 && leg.time_s >= self.reversal_s { self.jolt(since_s) } else { (0.0, 0.0) }
    }

    /// `h = A·e^(−t/τ)·(1 − e^(−t/τ₀))·sin ωt` and its rate.
    fn jolt(&self, since_s: f64) -> (f64, f64) {
        let onset_s = self.decay_s / DECAY_PER_ONSET;
        let decay = (-since_s / self.decay_s).exp();
        let onset = (-since_s / onset_s).exp();
        let (sine, cosine) = (self.jerk_rad_per_s * since_s).sin_cos();
        let envelope = decay * (1.0 - onset);
        let envelope_rate = decay * (onset / onset_s - (1.0 - onset) / self.decay_s);
        let rate = envelope_rate * sine + envelope * self.jerk_rad_per_s * cosine;
        (self.jerk_m * envelope * sine, self.jerk_m * rate)
    }
}

#[cfg(test)]
impl Rail {
    pub(super) fn jerk_m(&self) -> f64 {
        self.jerk_m
    }
}
