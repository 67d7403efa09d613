//! The drive's own view of the motion and its own velocity loop: CSV, quick stop and other ramps.

use crate::physics::delay::{DelayLine, steps};
use crate::unit::AxisSettings;

/// Below this speed an axis that was told to stop has stopped.
const STANDSTILL_RAD_PER_S: f64 = 1e-3;
/// Time below it.
const STANDSTILL_S: f64 = 0.02;

/// Angles of the last steps: from them come the velocity, a backward difference over a window of whole steps, and what
/// the drive sends to the host, which is older than what it uses itself. They become counts only where somebody looks.
#[derive(Clone, Debug)]
pub(crate) struct Speedometer {
    angles_rad: DelayLine<f64>,
    window: usize,
    delay: usize,
    per_s: f64,
}

/// Two angles a window apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    pub(crate) now_rad: f64,
    pub(crate) before_rad: f64,
}

impl Speedometer {
    /// Standing at an angle; what is sent is `delay` steps old.
    pub(crate) fn new(window_s: f64, step_s: f64, delay: usize, angle_rad: f64) -> Self {
        let window = steps(window_s, step_s).max(1);
        let angles_rad = DelayLine::new(window + delay, angle_rad);
        Self { angles_rad, window, delay, per_s: 1.0 / (window as f64 * step_s) }
    }

    /// Length of the window in steps.
    pub(crate) fn steps(&self) -> u64 {
        self.window as u64
    }

    /// One over the length of the window.
    pub(crate) fn per_s(&self) -> f64 {
        self.per_s
    }

    /// The window that ends at a step whose angle is given; the angle enters it.
    #[inline]
    pub(crate) fn observe(&mut self, angle_rad: f64) -> Span {
        let before_rad = self.angles_rad.ago(self.window - 1);
        self.angles_rad.push(angle_rad);
        Span { now_rad: angle_rad, before_rad }
    }

    /// The window that is sent at a step whose angle is given.
    pub(crate) fn sent(&self, angle_rad: f64) -> Span {
        let now_rad = if self.delay == 0 { angle_rad } else { self.angles_rad.ago(self.delay - 1) };
        Span { now_rad, before_rad: self.angles_rad.ago(self.delay + self.window - 1) }
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
    fn the_speedometer_spans_its_window_now_and_as_sent() {
        let mut meter = Speedometer::new(1e-3, 50e-6, 25, 0.0);
        (1..100).for_each(|k| {
            meter.observe(f64::from(k));
        });
        assert_eq!(meter.sent(100.0), Span { now_rad: 75.0, before_rad: 55.0 });
        assert_eq!(meter.observe(100.0), Span { now_rad: 100.0, before_rad: 80.0 });
        assert!((meter.per_s() - 1000.0).abs() < 1e-9);
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
