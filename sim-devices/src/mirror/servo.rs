//! The control law of one axis: PI + I² and a notch at the mode.
//!
//! Stands in for the production law of the crate `controllers`, which takes its place behind the same three calls.

use controllers::filters::Biquad;

use crate::unit::MirrorSettings;

/// `u = N(z)·(P·e + I·Σ e·T + I²·ΣΣ e·T²)`: sums by backward Euler, notch by the bilinear transform with prewarping
/// (see protocols, "PI + I² + notch").
///
/// The output is limited to the range of the amplifier. While it is limited, neither integrator moves further into
/// the limit, and the inner sum, which would go on feeding the outer one, is emptied.
#[derive(Clone, Debug)]
pub(super) struct ServoLaw {
    /// P + I·T + I²·T²: what a new error adds at once.
    direct_gain: f64,
    /// I·T.
    integral_step: f64,
    /// I²·T.
    double_step: f64,
    step_s: f64,
    limit_rad: f64,
    notch: Option<Biquad>,
    integral_rad: f64,
    /// Σ e·T.
    inner_rad_s: f64,
    double_rad: f64,
}

impl ServoLaw {
    pub(super) fn new(settings: &MirrorSettings, axis: usize, limit_rad: f64, step_s: f64) -> Self {
        let notch = Biquad::notch(
            settings.notch_frequency_hz[axis],
            settings.notch_numerator_damping_ratio,
            settings.notch_denominator_damping_ratio,
            1.0 / step_s,
        );
        Self {
            direct_gain: settings.proportional_gain_ratio
                + (settings.integral_gain_per_s + settings.double_integral_gain_per_s2 * step_s) * step_s,
            integral_step: settings.integral_gain_per_s * step_s,
            double_step: settings.double_integral_gain_per_s2 * step_s,
            step_s,
            limit_rad,
            notch: notch.filter(|_| settings.notch_switch >= 0.5),
            integral_rad: 0.0,
            inner_rad_s: 0.0,
            double_rad: 0.0,
        }
    }

    /// Bumpless start: without error the next output is `output_rad`.
    pub(super) fn reset(&mut self, output_rad: f64) {
        (self.integral_rad, self.inner_rad_s, self.double_rad) = (output_rad, 0.0, 0.0);
        if let Some(notch) = &mut self.notch {
            notch.settle(output_rad);
        }
    }

    /// One tick; returns the demanded actuator angle, which the notch may carry a little past the limit.
    pub(super) fn update(&mut self, error_rad: f64) -> f64 {
        let integral_rad = self.integral_rad + self.integral_step * error_rad;
        let inner_rad_s = self.inner_rad_s + self.step_s * error_rad;
        let double_rad = self.double_rad + self.double_step * inner_rad_s;
        // The sum of the three parts; what does not depend on the new error is summed apart from it.
        let known_rad = self.integral_rad + self.double_rad + self.double_step * self.inner_rad_s;
        let wanted_rad = known_rad + self.direct_gain * error_rad;
        let limited_rad = wanted_rad.clamp(-self.limit_rad, self.limit_rad);
        if limited_rad == wanted_rad {
            (self.integral_rad, self.inner_rad_s, self.double_rad) = (integral_rad, inner_rad_s, double_rad);
        } else {
            self.hold_back(wanted_rad, [integral_rad, inner_rad_s, double_rad]);
        }
        match &mut self.notch {
            Some(notch) => notch.update(limited_rad),
            None => limited_rad,
        }
    }

    /// The step that saturates: only what leads out of the limit is kept.
    fn hold_back(&mut self, wanted_rad: f64, [integral_rad, inner_rad_s, double_rad]: [f64; 3]) {
        let sign = wanted_rad.signum();
        if (integral_rad - self.integral_rad) * sign < 0.0 {
            self.integral_rad = integral_rad;
        }
        if (double_rad - self.double_rad) * sign < 0.0 {
            self.double_rad = double_rad;
        }
        self.inner_rad_s = if inner_rad_s * sign > 0.0 { 0.0 } else { inner_rad_s };
    }
}
