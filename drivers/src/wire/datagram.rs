//! Datagrams (UDP): whole messages, each arriving once or never.

use std::time::Duration;

use crate::device::DeviceError;

/// A datagram port, as the host sees it. Never blocks.
pub trait DatagramPort {
    /// Name for errors, e.g. `coarse tracker port`.
    fn name(&self) -> &str;

    /// Takes the oldest message that arrived up to `now` (since the start of the run); its length, `None` if none.
    ///
    /// # Errors
    /// When the port is gone.
    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError>;

    /// Sends a message.
    ///
    /// # Errors
    /// When the port is gone.
    fn send(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError>;
}

impl<P: DatagramPort + ?Sized> DatagramPort for Box<P> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError> {
        (**self).receive(now, into)
    }

    fn send(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        (**self).send(now, bytes)
    }
}
