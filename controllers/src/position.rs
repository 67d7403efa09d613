//! Position loop: proportional with velocity feed-forward, around the velocity loop.

use crate::{AxisGains, finite_or_zero};

/// `ω_cmd = k (θ_ref − θ) + ω_ff`, limited. It has no memory: with an exact feed-forward the error decays with the
/// time constant 1/k; a constant rate without feed-forward leaves the error ω/k.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionController {
    gain_per_s: f64,
    velocity_limit_rad_per_s: f64,
}

impl PositionController {
    /// A controller that never commands more than ± `velocity_limit_rad_per_s`.
    pub fn new(gains: &AxisGains, velocity_limit_rad_per_s: f64) -> Self {
        Self {
            gain_per_s: gains.position_gain_per_s,
            velocity_limit_rad_per_s: finite_or_zero(velocity_limit_rad_per_s).abs(),
        }
    }

    /// The velocity command of this tick. A sample that is not finite counts as no error, no feed-forward.
    pub fn update(&self, reference_rad: f64, position_rad: f64, feed_forward_rad_per_s: f64) -> f64 {
        let error_rad = finite_or_zero(reference_rad - position_rad);
        let command = self.gain_per_s * error_rad + finite_or_zero(feed_forward_rad_per_s);
        command.max(-self.velocity_limit_rad_per_s).min(self.velocity_limit_rad_per_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 250e-6;

    fn controller() -> PositionController {
        let gains = AxisGains { position_gain_per_s: 4.5, ..AxisGains::default() };
        PositionController::new(&gains, 1.0)
    }

    /// Error after `t_s` of following a ramp with an axis that does what it is told, from `start_rad` behind.
    fn error_on_a_ramp(t_s: f64, start_rad: f64, ramp_rad_per_s: f64, feed_forward_rad_per_s: f64) -> f64 {
        let mut error_rad = start_rad;
        let ticks = (t_s / PERIOD_S) as usize;
        for _ in 0..ticks {
            let command = controller().update(error_rad, 0.0, feed_forward_rad_per_s);
            error_rad += (ramp_rad_per_s - command) * PERIOD_S;
        }
        error_rad
    }

    #[test]
    fn error_decays_with_the_time_constant_of_the_gain() {
        for t_s in [0.1, 1.0 / 4.5, 0.9] {
            let expected = 0.01 * libm::pow(1.0 - 4.5 * PERIOD_S, libm::floor(t_s / PERIOD_S));
            assert!((error_on_a_ramp(t_s, 0.01, 0.0, 0.0) - expected).abs() < 1e-12);
            assert!((expected / 0.01 - libm::exp(-4.5 * t_s)).abs() < 1e-3);
        }
    }

    #[test]
    fn ramp_lags_by_rate_over_gain_without_feed_forward_and_not_at_all_with_it() {
        assert!((error_on_a_ramp(6.0, 0.0, 0.0118, 0.0) - 0.0118 / 4.5).abs() < 1e-9);
        assert!(error_on_a_ramp(6.0, 0.0, 0.0118, 0.0118).abs() < 1e-12);
    }

    #[test]
    fn command_is_limited_and_never_broken() {
        assert_eq!(controller().update(2.0, 0.0, 0.0), 1.0);
        assert_eq!(controller().update(0.0, 0.0, -3.0), -1.0);
        assert_eq!(controller().update(f64::NAN, 0.0, 0.25), 0.25);
        assert_eq!(controller().update(0.1, 0.0, f64::NAN), 0.45);
    }
}
