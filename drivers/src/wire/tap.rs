//! A tap on an Ethernet interface: whoever listens gets a copy of every frame, and nothing else changes.

use std::io;
use std::time::Duration;

use super::{EthernetLink, StoredFrame, Way};

/// A frame, when it passed the tap and which way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TappedFrame {
    /// Time since the start of the run: just before it was handed to the interface, or just after it was taken from it.
    pub at: Duration,
    /// Which way.
    pub way: Way,
    /// The frame, without its check sequence.
    pub frame: StoredFrame,
}

/// Whoever listens at a tap.
pub trait FrameSink {
    /// Takes a frame. Never waits: it is called in the tick.
    fn take(&mut self, frame: &TappedFrame);
}

/// An interface whose frames somebody else gets copies of. A frame that the interface did not take is not among them.
pub struct Tap<L, S> {
    link: L,
    sink: S,
    record: TappedFrame,
}

impl<L: EthernetLink, S: FrameSink> Tap<L, S> {
    /// Taps an interface.
    pub fn new(link: L, sink: S) -> Self {
        let record = TappedFrame { at: Duration::ZERO, way: Way::Out, frame: StoredFrame::EMPTY };
        Self { link, sink, record }
    }

    fn tell(&mut self, at: Duration, way: Way, frame: &[u8]) {
        (self.record.at, self.record.way) = (at, way);
        self.record.frame.keep(frame);
        self.sink.take(&self.record);
    }
}

impl<L: EthernetLink, S: FrameSink> EthernetLink for Tap<L, S> {
    fn name(&self) -> &str {
        self.link.name()
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let at = self.link.now();
        self.link.send(frame)?;
        self.tell(at, Way::Out, frame);
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        let Some(length) = self.link.receive(into)? else { return Ok(None) };
        let length = length.min(into.len());
        self.tell(self.link.now(), Way::Back, &into[..length]);
        Ok(Some(length))
    }

    fn now(&self) -> Duration {
        self.link.now()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        self.link.wait(until)
    }
}
