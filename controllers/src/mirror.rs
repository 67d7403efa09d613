//! The mirror's own position loop on its strain gauges: PI + I² behind a notch, 20 kHz.

use crate::filters::Biquad;
use crate::{MirrorGains, finite_or_zero};

/// `C(s) = P + I/s + I²/s²` on the notched error; backward Euler:
/// `i1 += I·Ts·e; s += Ts·e; i2 += I²·Ts·s; u = P·e + i1 + i2`.
///
/// Type 2: a ramp is followed without error, a constant acceleration a leaves a/(G·I²). The notch stands in front of
/// the integrals, so what is saturated is what they make: while the drive is at its limit no integral takes a step
/// that drives it further.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorController {
    notch: Biquad,
    proportional: f64,
    /// I·Ts.
    integral_step: f64,
    /// Ts.
    period_s: f64,
    /// I²·Ts.
    double_integral_step: f64,
    drive_limit_rad: f64,
    integral_rad: f64,
    error_integral_rad_s: f64,
    double_integral_rad: f64,
}

impl MirrorController {
    /// A controller of one axis at zero drive. `notch_hz` is that of the axis. `None` where the notch does not exist
    /// at this rate.
    pub fn new(gains: &MirrorGains, notch_hz: f64, sample_rate_hz: f64) -> Option<Self> {
        let numerator = gains.notch_numerator_damping;
        let denominator = gains.notch_denominator_damping;
        let period_s = 1.0 / sample_rate_hz;
        Some(Self {
            notch: Biquad::notch(notch_hz, numerator, denominator, sample_rate_hz)?,
            proportional: gains.proportional,
            integral_step: gains.integral_per_s * period_s,
            period_s,
            double_integral_step: gains.double_integral_per_s2 * period_s,
            drive_limit_rad: finite_or_zero(gains.drive_limit_rad).abs(),
            integral_rad: 0.0,
            error_integral_rad_s: 0.0,
            double_integral_rad: 0.0,
        })
    }

    /// Bumpless start: at zero error the next drive is `drive_rad`.
    pub fn reset(&mut self, drive_rad: f64) {
        self.notch.settle(0.0);
        self.integral_rad = self.limited(finite_or_zero(drive_rad));
        self.error_integral_rad_s = 0.0;
        self.double_integral_rad = 0.0;
    }

    /// One tick: where the mirror shall be and where its strain gauges say it is. Returns the drive, as the angle that
    /// it would hold the mirror at. A sample that is not finite counts as no error.
    pub fn update(&mut self, command_rad: f64, measured_rad: f64) -> f64 {
        let error_rad = self.notch.update(command_rad - measured_rad);
        let single_rad = self.integral_rad + self.integral_step * error_rad;
        let error_integral_rad_s = self.error_integral_rad_s + self.period_s * error_rad;
        let double_rad = self.double_integral_rad + self.double_integral_step * error_integral_rad_s;
        let wanted_rad = self.proportional * error_rad + single_rad + double_rad;
        let drive_rad = self.limited(wanted_rad);
        let saturated = drive_rad != wanted_rad;
        if !(saturated && error_rad * wanted_rad > 0.0) {
            self.integral_rad = single_rad;
            self.error_integral_rad_s = error_integral_rad_s;
        }
        if !(saturated && self.error_integral_rad_s * wanted_rad > 0.0) {
            self.double_integral_rad = double_rad;
        }
        drive_rad
    }

    fn limited(&self, drive_rad: f64) -> f64 {
        drive_rad.max(-self.drive_limit_rad).min(self.drive_limit_rad)
    }
}

#[cfg(test)]
mod tests;
