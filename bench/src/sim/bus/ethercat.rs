//! EtherCAT of a served simulator: frames in, answers out.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use drivers::wire::{EthernetLink, MAX_FRAME_BYTES};
use sim_devices::ethercat::{EtherCatLine, LineFault};

use super::{BusFault, OTHER_BUS, ServedBus};
use crate::sim::Report;

/// Answers that wait to be sent late.
const MOST_ANSWERS: usize = 4096;

/// An answer that is not due yet.
struct Late {
    due: Duration,
    frame: Vec<u8>,
}

/// SubDevices on an interface.
pub(in crate::sim) struct ServedEtherCat<L: EthernetLink> {
    link: L,
    line: Box<dyn EtherCatLine>,
    late: VecDeque<Late>,
}

impl<L: EthernetLink> ServedEtherCat<L> {
    /// SubDevices at the far end of a link.
    pub(in crate::sim) fn new(link: L, line: Box<dyn EtherCatLine>) -> Self {
        Self { link, line, late: VecDeque::new() }
    }

    /// A frame arrives.
    fn take(&mut self, frame: &mut [u8], report: &mut Report) {
        let now = self.link.now();
        let passage = self.line.pass(now, frame);
        if passage.answers == 0 {
            report.unanswered += 1;
            return;
        }
        report.frames += 1;
        let answer = &frame[..passage.bytes];
        for _ in 0..passage.answers {
            if passage.after.is_zero() {
                report.unsent += u64::from(self.link.send(answer).is_err());
            } else if self.late.len() < MOST_ANSWERS {
                let due = now + passage.after;
                let place = self.late.partition_point(|earlier| earlier.due <= due);
                self.late.insert(place, Late { due, frame: answer.to_vec() });
            }
        }
    }

    fn send_late(&mut self, now: Duration, report: &mut Report) {
        while self.late.front().is_some_and(|late| late.due <= now) {
            let Some(late) = self.late.pop_front() else { return };
            report.unsent += u64::from(self.link.send(&late.frame).is_err());
        }
    }
}

impl<L: EthernetLink> ServedBus for ServedEtherCat<L> {
    fn now(&self) -> Duration {
        self.link.now()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        self.link.wait(until)
    }

    fn next_due(&self) -> Option<Duration> {
        self.late.front().map(|late| late.due)
    }

    fn exchange(&mut self, report: &mut Report) -> io::Result<()> {
        let mut frame = [0; MAX_FRAME_BYTES];
        while let Some(count) = self.link.receive(&mut frame)? {
            self.take(&mut frame[..count], report);
        }
        let now = self.link.now();
        self.send_late(now, report);
        self.line.advance(now);
        Ok(())
    }

    fn inject(&mut self, now: Duration, fault: BusFault) -> Result<(), String> {
        match fault {
            BusFault::Wire(fault) => self.line.inject(now, LineFault::from(fault)),
            BusFault::Node(_) => Err(OTHER_BUS.to_owned()),
        }
    }
}
