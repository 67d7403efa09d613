//! Faults of an Ethernet interface, on purpose: frames are lost, late, doubled, damaged, cut off or out of order.
//!
//! Which frames these are depends on seed, way and frame number alone: the same seed gives the same faults, whatever else
//! happens. Frames are counted from 1, each way for itself, from [`FaultControl::begin`] on; before that nothing is
//! touched.
//!
//! [`FaultyByteLine`] and [`FaultyDatagramPort`] do the like to the bytes of a line and the datagrams of a port.
//!
//! An interface's own check sequence is added and removed behind this seam. A damaged frame therefore arrives, other than on
//! a cable, where the check finds it and it is lost. EtherCAT has no other check: a changed byte of process data is taken.

mod byte_line;
mod control;
mod datagram_port;
mod held;
mod plan;
#[cfg(test)]
mod tests;

use std::io;
use std::sync::Arc;
use std::time::Duration;

pub use byte_line::{
    ByteFaultControl, ByteFaultCounts, ByteFaultKind, ByteLineFault, ByteLineFaultPlan, FaultyByteLine,
};
pub use control::{FaultControl, FaultCounts};
pub use datagram_port::{CounterJump, FaultyDatagramPort, PortFaultPlan, PortSilence};
pub use plan::{FaultKind, FaultPlan, FrameFault, MIN_TRUNCATED_BYTES, Occurrence};

use self::control::Counted;
use self::held::Held;
use super::{EthernetLink, StoredFrame, Way};

/// Frames that are looked at before the time is looked at again: lost ones cannot hold up a tick.
const MOST_FRAMES: usize = 32;

/// An interface with faults.
pub struct FaultyLink<L> {
    link: L,
    plan: FaultPlan,
    control: Arc<FaultControl>,
    out: Lane,
    back: Lane,
    frame: StoredFrame,
}

/// One way: how many frames have come, and which of them are still to go on.
struct Lane {
    frames_count: u64,
    held: Held,
}

impl Lane {
    fn new() -> Self {
        Self { frames_count: 0, held: Held::new() }
    }
}

impl<L: EthernetLink> FaultyLink<L> {
    /// An interface that has these faults from the moment when `control` begins them.
    pub fn new(link: L, plan: FaultPlan, control: Arc<FaultControl>) -> Self {
        Self { link, plan, control, out: Lane::new(), back: Lane::new(), frame: StoredFrame::EMPTY }
    }

    /// Does to the frame what is due to the next one of this way. `true` if it goes on now.
    fn befall(&mut self, way: Way) -> bool {
        let lane = match way {
            Way::Out => &mut self.out,
            Way::Back => &mut self.back,
        };
        let fate = self.plan.fate(way, lane.frames_count + 1, self.frame.bytes().len());
        let tally = |what| self.control.count(way, what);
        if fate.is_dropped {
            tally(Counted::Dropped);
            return false;
        }
        if let Some((byte, mask)) = fate.flip
            && let Some(byte) = self.frame.bytes_mut().get_mut(byte)
        {
            *byte ^= mask;
            tally(Counted::Corrupted);
        }
        if let Some(bytes) = fate.truncate_to.filter(|&bytes| bytes < self.frame.bytes().len()) {
            self.frame.truncate(bytes);
            tally(Counted::Truncated);
        }
        if fate.is_doubled {
            tally(Counted::Duplicated);
        }
        let due = match (fate.delay, fate.is_behind_next) {
            (Some(by), _) => {
                tally(Counted::Delayed);
                Some(self.link.now() + by)
            }
            (None, true) => {
                tally(Counted::Reordered);
                None
            }
            (None, false) => {
                if fate.is_doubled && !lane.held.push(Some(Duration::ZERO), &self.frame) {
                    tally(Counted::Overflowed);
                }
                return true;
            }
        };
        for _ in 0..1 + u8::from(fate.is_doubled) {
            if !lane.held.push(due, &self.frame) {
                tally(Counted::Overflowed);
            }
        }
        false
    }

    /// Sends what has waited long enough. A full queue of the interface is no failure: it is offered again.
    fn send_due(&mut self) -> io::Result<()> {
        while let Some(due) = self.out.held.next_due() {
            if due > self.link.now() {
                break;
            }
            let Some(frame) = self.out.held.first_due() else { break };
            match self.link.send(frame.bytes()) {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                sent => {
                    self.out.held.pop_due();
                    sent?;
                }
            }
        }
        Ok(())
    }

    /// A frame that has waited long enough on its way back.
    fn received_due(&mut self, into: &mut [u8]) -> Option<usize> {
        let due = self.back.held.next_due()?;
        if due > self.link.now() {
            return None;
        }
        let count = self.back.held.first_due()?.copy_into(into);
        self.back.held.pop_due();
        Some(count)
    }
}

impl<L: EthernetLink> EthernetLink for FaultyLink<L> {
    fn name(&self) -> &str {
        self.link.name()
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        self.send_due()?;
        if !self.control.is_active() {
            return self.link.send(frame);
        }
        self.frame.keep(frame);
        if self.befall(Way::Out) {
            let sent = self.link.send(self.frame.bytes());
            if sent.is_err() {
                // It will be offered again under the same number.
                self.out.held.forget_doubles();
                return sent;
            }
            self.out.held.release();
        }
        self.out.frames_count += 1;
        self.control.count(Way::Out, Counted::Frames);
        self.send_due()
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        self.send_due()?;
        if let Some(count) = self.received_due(into) {
            return Ok(Some(count));
        }
        if !self.control.is_active() {
            return self.link.receive(into);
        }
        for _ in 0..MOST_FRAMES {
            let Some(count) = self.link.receive(&mut *into)? else { break };
            self.frame.keep(&into[..count.min(into.len())]);
            let goes_on = self.befall(Way::Back);
            self.back.frames_count += 1;
            self.control.count(Way::Back, Counted::Frames);
            if goes_on {
                self.back.held.release();
                return Ok(Some(self.frame.copy_into(into)));
            }
        }
        Ok(None)
    }

    fn now(&self) -> Duration {
        self.link.now()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        self.send_due()?;
        let back = self.back.held.next_due();
        if back.is_some_and(|due| due <= self.link.now()) {
            return Ok(());
        }
        let next = [self.out.held.next_due(), back].into_iter().flatten().fold(until, Duration::min);
        self.link.wait(next)?;
        self.send_due()
    }
}
