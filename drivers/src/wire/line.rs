//! Byte lines (RS-422, RS-232, pty): what was sent comes out at the other end, in order, later.

use std::time::Duration;

use crate::device::DeviceError;

/// A full-duplex byte line, as the host sees it. Never blocks.
pub trait ByteLine {
    /// Name for errors, e.g. `imu line`.
    fn name(&self) -> &str;

    /// Takes what arrived up to `now` (since the start of the run) into `into`; the number of bytes, 0 if none.
    ///
    /// # Errors
    /// When the line is gone.
    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError>;

    /// Sends bytes.
    ///
    /// # Errors
    /// When the line is gone.
    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError>;
}

impl<L: ByteLine + ?Sized> ByteLine for Box<L> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        (**self).read(now, into)
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        (**self).write(now, bytes)
    }
}
