//! Off-load: the gimbal takes over what the mirror holds on average, so that the mirror stays in its stroke.

use crate::filters::Biquad;
use crate::{OffLoadGains, finite_or_zero};

/// `ω = K (m + (1/T) ∫m)`, m the low-passed mirror angle as line of sight (mirror angle ÷ optical gain).
///
/// The fine loop turns the mirror by what the gimbal lacks, so the gimbal closes the loop `K (1 + 1/(Ts))/s`; it is
/// stable as long as it is slower than the fine loop and the velocity loop. Without an integral a target rate v
/// leaves the mirror at v/K: that is for a rate that is added to the coarse tracker's, which has its own integral.
/// With it, the off-load can move the gimbal alone.
#[derive(Clone, Debug, PartialEq)]
pub struct OffLoad {
    filter: Biquad,
    gain_per_s: f64,
    /// Ts/T; 0 without an integral.
    integral_step: f64,
    per_optical_gain: f64,
    rate_limit_rad_per_s: f64,
    integral_rad: f64,
}

impl OffLoad {
    /// An off-load of one axis, at rest. `None` for an optical gain of 0 or a filter above half the rate.
    pub fn new(gains: &OffLoadGains, optical_gain: f64, period_s: f64) -> Option<Self> {
        let per_optical_gain = 1.0 / optical_gain;
        let integral_step = if gains.integral_time_s > 0.0 { period_s / gains.integral_time_s } else { 0.0 };
        Some(Self {
            filter: Biquad::first_order_low_pass(gains.filter_hz, 1.0 / period_s)?,
            gain_per_s: finite_or_zero(gains.gain_per_s),
            integral_step,
            per_optical_gain: per_optical_gain.is_finite().then_some(per_optical_gain)?,
            rate_limit_rad_per_s: finite_or_zero(gains.rate_limit_rad_per_s).abs(),
            integral_rad: 0.0,
        })
    }

    /// Starts anew, the mirror at its centre. With an integral the next rate is `rate_rad_per_s`, the gimbal's own.
    pub fn reset(&mut self, rate_rad_per_s: f64) {
        self.filter.settle(0.0);
        let has_integral = self.integral_step > 0.0 && self.gain_per_s != 0.0;
        let rate = self.limited(finite_or_zero(rate_rad_per_s));
        self.integral_rad = if has_integral { rate / self.gain_per_s } else { 0.0 };
    }

    /// One tick: the mirror's angle. Returns the rate to command or to add. An angle that is not finite counts as 0;
    /// hand in 0 while the fine loop is open and the rate fades away.
    pub fn update(&mut self, mirror_rad: f64) -> f64 {
        let mean_rad = self.filter.update(mirror_rad * self.per_optical_gain);
        let step_rad = self.integral_step * mean_rad;
        let wanted = self.gain_per_s * (mean_rad + self.integral_rad + step_rad);
        let rate = self.limited(wanted);
        if rate == wanted || step_rad * wanted * self.gain_per_s < 0.0 {
            self.integral_rad += step_rad;
        }
        rate
    }

    fn limited(&self, rate: f64) -> f64 {
        rate.max(-self.rate_limit_rad_per_s).min(self.rate_limit_rad_per_s)
    }
}

#[cfg(test)]
mod tests;
