//! Motions that begin and end at rest: the jerk-limited profile, and a sine that fades in and out.

use std::f64::consts::TAU;

use super::{ProfileLimits, Setpoint};

/// A jerk-limited move from rest to rest over a signed distance, starting at 0.
///
/// Seven phases (jerk up, constant acceleration, jerk down, cruise, and the mirror image). Where the distance is
/// too short for the limits, first the cruise velocity and then the acceleration shrink (Biagiotti & Melchiorri,
/// *Trajectory Planning for Automatic Machines and Robots*, 2008, section 3.4).
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    sign: f64,
    jerk_rad_per_s3: f64,
    /// Durations of jerk, constant acceleration and cruise.
    jerk_s: f64,
    acceleration_s: f64,
    cruise_s: f64,
    distance_rad: f64,
}

impl Profile {
    /// The profile over `distance_rad` within `limits` (all limits > 0).
    pub fn new(distance_rad: f64, limits: &ProfileLimits) -> Self {
        let ProfileLimits { velocity_rad_per_s: v, acceleration_rad_per_s2: a, jerk_rad_per_s3: j } = *limits;
        let distance = distance_rad.abs();
        let (jerk_s, acceleration_s) = ramp(v, a, j);
        let ramp_s = 2.0 * jerk_s + acceleration_s;
        let ramps_rad = j * jerk_s * (jerk_s + acceleration_s) * ramp_s;
        let peak = if ramps_rad <= distance { v } else { peak_velocity(distance, a, j) };
        let (jerk_s, acceleration_s) = ramp(peak, a, j);
        let ramps_rad = peak * (2.0 * jerk_s + acceleration_s);
        let cruise_s = if peak > 0.0 { ((distance - ramps_rad) / peak).max(0.0) } else { 0.0 };
        Self {
            sign: if distance_rad < 0.0 { -1.0 } else { 1.0 },
            jerk_rad_per_s3: j,
            jerk_s,
            acceleration_s,
            cruise_s,
            distance_rad: distance,
        }
    }

    /// Duration of the move.
    pub fn duration_s(&self) -> f64 {
        2.0 * self.ramp_s() + self.cruise_s
    }

    /// Duration of the cruise at constant velocity.
    pub fn cruise_s(&self) -> f64 {
        self.cruise_s
    }

    /// Position, velocity and acceleration `t_s` after the start; rests at the end.
    pub fn at(&self, t_s: f64) -> Setpoint {
        let total_s = self.duration_s();
        let (position, velocity, acceleration) = if t_s >= total_s {
            (self.distance_rad, 0.0, 0.0)
        } else if t_s > total_s / 2.0 {
            let (p, v, a) = self.first_half(total_s - t_s);
            (self.distance_rad - p, v, -a)
        } else {
            self.first_half(t_s.max(0.0))
        };
        Setpoint {
            position_rad: self.sign * position,
            velocity_rad_per_s: self.sign * velocity,
            acceleration_rad_per_s2: self.sign * acceleration,
            torque_nm: 0.0,
        }
    }

    fn ramp_s(&self) -> f64 {
        2.0 * self.jerk_s + self.acceleration_s
    }

    fn first_half(&self, t_s: f64) -> (f64, f64, f64) {
        let j = self.jerk_rad_per_s3;
        let mut p = 0.0;
        let mut v = 0.0;
        let mut a = 0.0;
        let mut left = t_s;
        for (jerk, duration_s) in [(j, self.jerk_s), (0.0, self.acceleration_s), (-j, self.jerk_s)] {
            let dt = left.min(duration_s);
            p += v * dt + a * dt * dt / 2.0 + jerk * dt * dt * dt / 6.0;
            v += a * dt + jerk * dt * dt / 2.0;
            a += jerk * dt;
            left -= dt;
            if left <= 0.0 {
                return (p, v, a);
            }
        }
        (p + v * left, v, 0.0)
    }
}

/// Durations of each jerk phase and of the constant-acceleration phase that lead from rest to `v`.
fn ramp(v: f64, a: f64, j: f64) -> (f64, f64) {
    if v * j >= a * a { (a / j, v / a - a / j) } else { ((v / j).max(0.0).sqrt(), 0.0) }
}

/// Peak velocity of a move without cruise.
fn peak_velocity(distance: f64, a: f64, j: f64) -> f64 {
    let full_acceleration = distance >= 2.0 * a * a * a / (j * j);
    if full_acceleration {
        let b = a * a / j;
        (-b + (b * b + 4.0 * a * distance).sqrt()) / 2.0
    } else {
        (distance * distance * j / 4.0).cbrt()
    }
}

/// Largest slope and curvature of the fade 6x⁵ − 15x⁴ + 10x³ over 0…1: 15/8 and 10/√3.
const FADE_SLOPE: f64 = 1.875;
const FADE_CURVATURE: f64 = 5.773_502_691_896_258;

/// Largest rate and acceleration, an upper bound: those of the sine and of the fade added up.
pub(super) fn sine_peaks(amplitude_rad: f64, frequency_hz: f64, fade_s: f64) -> [f64; 2] {
    let amplitude = amplitude_rad.abs();
    let omega = TAU * frequency_hz;
    let slope = FADE_SLOPE / fade_s;
    let curvature = FADE_CURVATURE / (fade_s * fade_s);
    [amplitude * (omega + slope), amplitude * (omega * omega + 2.0 * slope * omega + curvature)]
}

/// The sine at a time, relative to its middle; it lasts and fades for as long as `[lasts_s, fade_s]` say.
pub(super) fn sine_at(
    amplitude_rad: f64,
    frequency_hz: f64,
    [lasts_s, fade_s]: [f64; 2],
    t_s: f64,
) -> Setpoint {
    if t_s <= 0.0 || t_s >= lasts_s {
        return Setpoint::default();
    }
    let rising = t_s / fade_s;
    let falling = (lasts_s - t_s) / fade_s;
    // Of two fades the one that is farther from full size counts; both at once only where they do not fit.
    let (x, sign) = if rising <= falling { (rising.min(1.0), 1.0) } else { (falling.min(1.0), -1.0) };
    let w = x * x * x * (10.0 + x * (6.0 * x - 15.0));
    let slope = sign * 30.0 * x * x * (1.0 - x) * (1.0 - x) / fade_s;
    let curvature = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (fade_s * fade_s);
    let omega = TAU * frequency_hz;
    let (sin, cos) = (omega * t_s).sin_cos();
    Setpoint {
        position_rad: amplitude_rad * w * sin,
        velocity_rad_per_s: amplitude_rad * (slope * sin + w * omega * cos),
        acceleration_rad_per_s2: amplitude_rad
            * (curvature * sin + 2.0 * slope * omega * cos - w * omega * omega * sin),
        torque_nm: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn limits(v: f64, a: f64, j: f64) -> ProfileLimits {
        ProfileLimits { velocity_rad_per_s: v, acceleration_rad_per_s2: a, jerk_rad_per_s3: j }
    }

    proptest! {
        #[test]
        fn stays_inside_its_limits_and_reaches_the_target(
            distance in -6.0..6.0f64, v in 1e-4..2.0f64, a in 0.01..3.0f64, j in 0.1..100.0f64,
        ) {
            let profile = Profile::new(distance, &limits(v, a, j));
            let total = profile.duration_s();
            let end = profile.at(total);
            prop_assert!((end.position_rad - distance).abs() < 1e-9);
            let mut last = profile.at(0.0);
            let steps = 400;
            for k in 1..=steps {
                let t = total * f64::from(k) / f64::from(steps);
                let now = profile.at(t);
                prop_assert!(now.velocity_rad_per_s.abs() <= v * (1.0 + 1e-9));
                prop_assert!(now.acceleration_rad_per_s2.abs() <= a * (1.0 + 1e-9));
                let dt = total / f64::from(steps);
                let jump = (now.acceleration_rad_per_s2 - last.acceleration_rad_per_s2).abs();
                prop_assert!(jump <= j * dt * (1.0 + 1e-6) + 1e-9, "jerk {} over {j}", jump / dt);
                let moved = now.position_rad - last.position_rad;
                prop_assert!(moved.abs() <= v * dt * (1.0 + 1e-6) + 1e-12);
                last = now;
            }
        }
    }

    #[test]
    fn a_long_move_cruises_at_the_plateau_velocity() {
        let profile = Profile::new(2.0, &limits(0.1, 0.5, 5.0));
        let middle = profile.at(profile.duration_s() / 2.0);
        assert!((middle.velocity_rad_per_s - 0.1).abs() < 1e-12);
        assert!((middle.position_rad - 1.0).abs() < 1e-9);
        assert!(profile.cruise_s() > 19.0);
    }
}
