//! Digital inputs.

use std::time::Duration;

use crate::device::DeviceError;

/// A terminal or card with digital inputs, as the host sees it.
pub trait DigitalPort {
    /// Name for errors, e.g. `digital terminal`.
    fn name(&self) -> &str;

    /// Whether an input was on when it was sampled last; `None` before it was sampled for the first time.
    ///
    /// # Errors
    /// When there is no such input or the card is gone.
    fn is_on(&mut self, now: Duration, input: usize) -> Result<Option<bool>, DeviceError>;
}
