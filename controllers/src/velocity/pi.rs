//! PI with feed-forward, saturation and anti-windup.

use crate::{AxisGains, finite_or_zero};

/// `I += Ki·Ts·e; T = Kp·e + I + T_ff`, integral first, saturated at the torque limit.
///
/// Anti-windup by conditional integration: while the output is saturated the integral takes no step that drives it
/// further into saturation (Åström & Hägglund, *Advanced PID Control*, 2006, section 3.5). Unsaturated the law is
/// exactly linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Pi {
    kp_nm_s_per_rad: f64,
    /// Ki·Ts.
    ki_step_nm_s_per_rad: f64,
    torque_limit_nm: f64,
    integral_nm: f64,
    saturated: bool,
}

impl Pi {
    pub(super) fn new(gains: &AxisGains, torque_limit_nm: f64, period_s: f64) -> Self {
        Self {
            kp_nm_s_per_rad: gains.velocity_kp_nm_s_per_rad,
            ki_step_nm_s_per_rad: gains.velocity_ki_nm_per_rad * period_s,
            torque_limit_nm: finite_or_zero(torque_limit_nm).abs(),
            integral_nm: 0.0,
            saturated: false,
        }
    }

    pub(super) fn reset(&mut self, torque_nm: f64) {
        self.integral_nm = self.limited(finite_or_zero(torque_nm));
        self.saturated = false;
    }

    pub(super) fn take_over(
        &mut self,
        torque_nm: f64,
        reference_rad_per_s: f64,
        velocity_rad_per_s: f64,
        feed_forward_nm: f64,
    ) {
        let error_rad_per_s = finite_or_zero(reference_rad_per_s - velocity_rad_per_s);
        let direct_nm = self.kp_nm_s_per_rad * error_rad_per_s + finite_or_zero(feed_forward_nm);
        // The integral may lie beyond the limit where it stands against the rest; the torque does not.
        self.integral_nm = self.limited(finite_or_zero(torque_nm)) - direct_nm;
        self.saturated = false;
    }

    pub(super) fn update(
        &mut self,
        reference_rad_per_s: f64,
        velocity_rad_per_s: f64,
        feed_forward_nm: f64,
    ) -> f64 {
        let error_rad_per_s = finite_or_zero(reference_rad_per_s - velocity_rad_per_s);
        let step_nm = self.ki_step_nm_s_per_rad * error_rad_per_s;
        let direct_nm = self.kp_nm_s_per_rad * error_rad_per_s + finite_or_zero(feed_forward_nm);
        let wanted_nm = direct_nm + self.integral_nm + step_nm;
        let torque_nm = self.limited(wanted_nm);
        self.saturated = torque_nm != wanted_nm;
        if !self.saturated || step_nm * wanted_nm < 0.0 {
            self.integral_nm += step_nm;
        }
        torque_nm
    }

    pub(super) fn is_saturated(&self) -> bool {
        self.saturated
    }

    fn limited(&self, torque_nm: f64) -> f64 {
        torque_nm.max(-self.torque_limit_nm).min(self.torque_limit_nm)
    }
}
