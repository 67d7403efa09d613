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

impl<L: EthernetLink + ?Sized> EthernetLink for Box<L> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        (**self).send(frame)
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        (**self).receive(into)
    }

    fn now(&self) -> Duration {
        (**self).now()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        (**self).wait(until)
    }
}

/// Which way a frame goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From this program to the stations.
    Out,
    /// From the stations to this program.
    Back,
}

/// A frame in a place of fixed size: keeping it allocates nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoredFrame {
    length: usize,
    bytes: [u8; MAX_FRAME_BYTES],
}

impl StoredFrame {
    /// No frame.
    pub const EMPTY: Self = Self { length: 0, bytes: [0; MAX_FRAME_BYTES] };

    /// Keeps a frame instead of the one before. What is longer than an Ethernet frame is cut off.
    pub fn keep(&mut self, frame: &[u8]) {
        self.length = frame.len().min(MAX_FRAME_BYTES);
        self.bytes[..self.length].copy_from_slice(&frame[..self.length]);
    }

    /// The frame.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    pub(super) fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes[..self.length]
    }

    pub(super) fn truncate(&mut self, bytes: usize) {
        self.length = self.length.min(bytes);
    }

    /// Copies as much of it as there is room for; how much that was.
    pub(super) fn copy_into(&self, into: &mut [u8]) -> usize {
        let count = self.length.min(into.len());
        into[..count].copy_from_slice(&self.bytes[..count]);
        count
    }
}
