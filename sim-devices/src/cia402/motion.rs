//! The drive's own view of the motion and its own velocity loop: CSV, quick stop and other ramps.

use crate::physics::delay::{DelayLine, steps};
use crate::unit::AxisSettings;

/// Below this speed an axis that was told to stop has stopped.
const STANDSTILL_RAD_PER_S: f64 = 1e-3;
/// Time below it.
const STANDSTILL_S: f64 = 0.02;

/// Encoder counts of the last steps: velocity by a backward difference over a window of whole steps, and what the
/// drive sends to the host, which is older than what it uses itself.
#[derive(Clone, Debug)]
pub(crate) struct Speedometer {
    counts: DelayLine<i64>,
    window: usize,
    delay: usize,
    counts_per_s: f64,
}

impl Speedometer {
    /// Standing at `counts`; what is sent is `delay` steps old.
    pub(crate) fn new(window_s: f64, step_s: f64, delay: usize, counts: i64) -> Self {
        let window = steps(window_s, step_s).max(1);
        Self {
            counts: DelayLine::new(window + delay, counts),
            window,
            delay,
            counts_per_s: 1.0 / (window as f64 * step_s),
        }
    }

    /// Velocity at a step whose count is given, in counts/s.
    #[inline]
    pub(crate) fn velocity(&self, counts: i64) -> f64 {
        (counts - self.counts.ago(self.window - 1)) as f64 * self.counts_per_s
    }

    /// The same, and the count enters the window.
    #[inline]
    pub(crate) fn observe(&mut self, counts: i64) -> f64 {
        let velocity = self.velocity(counts);
        self.counts.push(counts);
        velocity
    }

    /// Counts and velocity in counts/s that are sent at a step whose count is given.
    pub(crate) fn sent(&self, counts: i64) -> (i64, f64) {
        let seen = if self.delay == 0 { counts } else { self.counts.ago(self.delay - 1) };
        let before = self.counts.ago(self.delay + self.window - 1);
        (seen, (seen - before) as f64 * self.counts_per_s)
    }
}

/// PI velocity loop with clamped integrator.
#[derive(Clone, Debug)]
pub(crate) struct VelocityLoop {
    gain_nm_s_per_rad: f64,
    integral_gain_nm: f64,
    integral_nm: f64,
}

impl VelocityLoop {
    pub(crate) fn new(axis: &AxisSettings, step_s: f64) -> Self {
        Self {
            gain_nm_s_per_rad: axis.velocity_gain_nm_s_per_rad,
            integral_gain_nm: axis.velocity_integral_gain_nm_per_rad * step_s,
            integral_nm: 0.0,
        }
    }

    /// Starts from this torque.
    pub(crate) fn reset(&mut self, torque_nm: f64) {
        self.integral_nm = torque_nm;
    }

    /// Torque for this step; the integrator holds while the limit would be exceeded further.
    pub(crate) fn torque_nm(&mut self, error_rad_per_s: f64, feed_forward_nm: f64, limit_nm: f64) -> f64 {
        let growth = self.integral_gain_nm * error_rad_per_s;
        let torque = self.gain_nm_s_per_rad * error_rad_per_s + self.integral_nm + growth + feed_forward_nm;
        if torque.abs() <= limit_nm || torque * growth < 0.0 {
            self.integral_nm += growth;
        }
        torque
    }
}

/// A stop under the drive's own control.
#[derive(Clone, Debug)]
pub(crate) struct Ramp {
    setpoint_rad_per_s: f64,
    deceleration_rad_per_s2: f64,
    slow_steps: u32,
    standstill_steps: u32,
}

impl Ramp {
    /// From a velocity to rest; an infinite deceleration stops at the torque limit.
    pub(crate) fn new(velocity_rad_per_s: f64, deceleration_rad_per_s2: f64, step_s: f64) -> Self {
        Self {
            setpoint_rad_per_s: velocity_rad_per_s,
            deceleration_rad_per_s2,
            slow_steps: 0,
            standstill_steps: (STANDSTILL_S / step_s).round() as u32,
        }
    }

    /// Next velocity setpoint and its acceleration.
    pub(crate) fn next(&mut self, velocity_rad_per_s: f64, step_s: f64) -> (f64, f64) {
        let change = self.deceleration_rad_per_s2 * step_s;
        if self.setpoint_rad_per_s.abs() > change {
            let acceleration = -self.deceleration_rad_per_s2.copysign(self.setpoint_rad_per_s);
            self.setpoint_rad_per_s += acceleration * step_s;
            return (self.setpoint_rad_per_s, acceleration);
        }
        self.setpoint_rad_per_s = 0.0;
        let slow = velocity_rad_per_s.abs() < STANDSTILL_RAD_PER_S;
        self.slow_steps = if slow { self.slow_steps.saturating_add(1) } else { 0 };
        (0.0, 0.0)
    }

    /// Whether the axis stands.
    pub(crate) fn is_over(&self) -> bool {
        self.slow_steps >= self.standstill_steps
    }
}

/// Soft limits of 607Dh around the counts of a single-turn encoder.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoftLimits {
    middle: i64,
    half_span: i64,
    counts_per_rev: i64,
}

impl SoftLimits {
    /// Limits in counts; without effect when they span a turn or more.
    pub(crate) fn new(min: i64, max: i64, counts_per_rev: i64) -> Self {
        Self { middle: min + (max - min) / 2, half_span: (max - min) / 2, counts_per_rev }
    }

    /// Counts left to the lower and upper limit, negative beyond; `None` when there are no limits.
    pub(crate) fn room(&self, counts: i64) -> Option<[i64; 2]> {
        if self.half_span < 0 || 2 * self.half_span >= self.counts_per_rev {
            return None;
        }
        let half_turn = self.counts_per_rev / 2;
        let from_middle = (counts - self.middle + half_turn).rem_euclid(self.counts_per_rev) - half_turn;
        Some([self.half_span + from_middle, self.half_span - from_middle])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::UnitSettings;

    #[test]
    fn the_speedometer_measures_a_ramp_half_a_window_late() {
        let mut meter = Speedometer::new(1e-3, 50e-6, 25, 0);
        let position = |k: i64| k * k; // counts at step k: velocity 2k counts per step
        (1..100).for_each(|k| {
            meter.observe(position(k));
        });
        assert_eq!(meter.velocity(position(100)), f64::from(2 * (100 - 10)) / 50e-6);
        assert_eq!(meter.sent(position(100)), (position(75), f64::from(2 * (75 - 10)) / 50e-6));
    }

    #[test]
    fn soft_limits_work_across_the_wrap_of_the_encoder() {
        let turn = 1 << 26;
        let limits = SoftLimits::new(-1000, 1000, turn);
        assert_eq!(limits.room(999), Some([1999, 1]));
        assert_eq!(limits.room(turn - 1), Some([999, 1001]));
        assert_eq!(limits.room(turn - 1500), Some([-500, 2500]));
        assert_eq!(SoftLimits::new(i64::from(i32::MIN), i64::from(i32::MAX), turn).room(5), None);
    }

    #[test]
    fn a_saturated_loop_does_not_wind_up() {
        let mut velocity_loop = VelocityLoop::new(&UnitSettings::default().az, 50e-6);
        (0..20_000).for_each(|_| {
            velocity_loop.torque_nm(1.0, 0.0, 1000.0);
        });
        assert!(velocity_loop.torque_nm(-0.01, 0.0, 1000.0) < 0.0);
    }
}
