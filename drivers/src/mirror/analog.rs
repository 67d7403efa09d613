//! What mirrors behind any controller have in common: analog channels, the stroke, settings that cannot be.

use std::time::Duration;

use super::Actuals;
use crate::device::DeviceError;
use crate::wire::AnalogPort;

impl Actuals {
    /// Sends commands as voltages.
    ///
    /// # Errors
    /// When the card is gone.
    pub(crate) fn send_analog(
        &mut self,
        card: &mut dyn AnalogPort,
        outputs: [usize; 2],
        command_v: [f64; 2],
        scale_rad_per_v: [f64; 2],
        now: Duration,
    ) -> Result<(), DeviceError> {
        for axis in 0..2 {
            card.write_v(now, outputs[axis], command_v[axis])?;
            self.command_rad[axis] = command_v[axis] * scale_rad_per_v[axis];
        }
        Ok(())
    }

    /// Takes the feedback that is there as voltages.
    ///
    /// # Errors
    /// When the card is gone.
    pub(crate) fn take_analog(
        &mut self,
        card: &mut dyn AnalogPort,
        inputs: [usize; 2],
        scale_rad_per_v: [f64; 2],
        now: Duration,
    ) -> Result<(), DeviceError> {
        for axis in 0..2 {
            self.angle_rad[axis] = scale_rad_per_v[axis] * card.read_v(now, inputs[axis])?;
        }
        self.is_fresh(now);
        Ok(())
    }

    /// The feedback is that of now.
    pub(crate) fn is_fresh(&mut self, now: Duration) {
        self.feedback_at = now;
        self.feedback_counter = self.feedback_counter.wrapping_add(1);
    }
}

/// A command within ± the stroke; one that is not a number is 0.
pub(crate) fn within_stroke(command_rad: f64, stroke_rad: f64) -> f64 {
    let command_rad = if command_rad.is_finite() { command_rad } else { 0.0 };
    command_rad.clamp(-stroke_rad, stroke_rad)
}

/// Settings that must be finite and above zero.
///
/// # Errors
/// [`DeviceError::Setting`] with the first that is not.
pub(crate) fn check_positive(device: &str, settings: &[(&'static str, f64)]) -> Result<(), DeviceError> {
    match settings.iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        None => Ok(()),
        Some(&(setting, value)) => Err(DeviceError::Setting {
            device: device.to_owned(),
            setting,
            value,
            allowed: "it must be finite and not 0".to_owned(),
        }),
    }
}
