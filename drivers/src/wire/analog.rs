//! Analog channels, in volts.

use std::time::Duration;

use crate::device::DeviceError;

/// A card of analog outputs and inputs, as the host sees it.
pub trait AnalogPort {
    /// Name for errors, e.g. `analog card`.
    fn name(&self) -> &str;

    /// Sets output `channel`; it holds until the next write.
    ///
    /// # Errors
    /// When there is no such channel or the card is gone.
    fn write_v(&mut self, now: Duration, channel: usize, volts: f64) -> Result<(), DeviceError>;

    /// Samples input `channel`.
    ///
    /// # Errors
    /// When there is no such channel or the card is gone.
    fn read_v(&mut self, now: Duration, channel: usize) -> Result<f64, DeviceError>;
}
