//! CANopen of a served simulator: its nodes answer, and send by themselves.

use std::io;
use std::time::Duration;

use drivers::wire::can::{CanEvent, CanLink};
use sim_devices::canopen::{CanOpenLine, NodeFault};

use super::{BusFault, OTHER_BUS, ServedBus};
use crate::sim::Report;

/// Nodes on a CAN interface.
pub(in crate::sim) struct ServedCan<L: CanLink> {
    link: L,
    line: Box<dyn CanOpenLine>,
}

impl<L: CanLink> ServedCan<L> {
    /// Nodes on the bus of a link.
    pub(in crate::sim) fn new(link: L, line: Box<dyn CanOpenLine>) -> Self {
        Self { link, line }
    }

    /// Sends what nodes have to say. A frame that finds the queue of the interface full is lost, and counted.
    fn answer(&mut self, report: &mut Report) -> io::Result<()> {
        while let Some(event) = self.line.give() {
            let CanEvent::Frame(frame) = event else { continue };
            match self.link.send(&frame) {
                Ok(()) => report.frames += 1,
                Err(error) if error.kind() == io::ErrorKind::NetworkDown => return Err(error),
                Err(_) => report.unsent += 1,
            }
        }
        Ok(())
    }
}

impl<L: CanLink> ServedBus for ServedCan<L> {
    fn now(&self) -> Duration {
        self.link.now()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        self.link.wait(until)
    }

    fn next_due(&self) -> Option<Duration> {
        self.line.next_due()
    }

    fn exchange(&mut self, report: &mut Report) -> io::Result<()> {
        while let Some(event) = self.link.receive()? {
            if let CanEvent::Frame(frame) = event {
                self.line.take(self.link.now(), &frame);
                self.answer(report)?;
            }
        }
        self.line.advance(self.link.now());
        self.answer(report)
    }

    fn inject(&mut self, now: Duration, fault: BusFault) -> Result<(), String> {
        match fault {
            BusFault::Node(fault) => self.line.inject(now, NodeFault::from(fault)),
            BusFault::Wire(_) => Err(OTHER_BUS.to_owned()),
        }
    }
}
