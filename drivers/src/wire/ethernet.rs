//! Ethernet interfaces, as an EtherCAT main device sees them: whole frames, and the time that passes while it waits.

use std::io;
use std::time::Duration;

/// Longest Ethernet frame without its check sequence, which the interface adds and removes.
pub const MAX_FRAME_BYTES: usize = 1514;

/// An interface that carries EtherCAT frames (EtherType 88A4h), destination address first, no check sequence.
///
/// The interface owns the time of its bus: on a real interface it passes by itself, in process it passes while somebody waits.
pub trait EthernetLink {
    /// Name for errors, e.g. `enp3s0`.
    fn name(&self) -> &str;

    /// Sends a frame. Never waits.
    ///
    /// # Errors
    /// When the interface is down, gone or its queue is full.
    fn send(&mut self, frame: &[u8]) -> io::Result<()>;

    /// Takes the oldest frame that has arrived; its length, `None` if none has. Never waits.
    ///
    /// # Errors
    /// When the interface is down or gone.
    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>>;

    /// Time since the start of the run.
    fn now(&self) -> Duration;

    /// Waits until a frame can be taken, at the latest until `until` (time since the start of the run).
    ///
    /// # Errors
    /// When the interface is gone.
    fn wait(&mut self, until: Duration) -> io::Result<()>;
}
