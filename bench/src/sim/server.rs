//! The loop of a served simulator: frames in, answers out, orders in between.

use std::collections::VecDeque;
use std::io;
use std::sync::atomic::AtomicU16;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::{EthernetLink, MAX_FRAME_BYTES};
use sim_devices::ethercat::LineFault;
use sim_devices::rig::Fault;

use super::Report;
use super::control::{Asked, Control};
use super::lines::ServedLines;
use super::truth::{self, TruthLog};
use crate::people::signals;
use crate::site::FarEnds;
use crate::site::order::{Answer, Order};

/// Longest wait for a frame: watchdogs must act, orders be taken and bytes be moved without any. A serial command and its reply are
/// moved four times: at this wait they take less than a tick of 1 ms, as they do on a cable.
const LONGEST_WAIT: Duration = Duration::from_micros(100);
/// Answers that wait to be sent late.
const MOST_ANSWERS: usize = 4096;

/// An answer that is not due yet.
struct Late {
    due: Duration,
    frame: Vec<u8>,
}

/// Why a server ended by itself.
#[derive(Debug)]
pub(super) enum Broken {
    /// Its interface is gone.
    Interface(io::Error),
    /// A simulated device on a line is gone.
    Line(DeviceError),
}

impl From<io::Error> for Broken {
    fn from(error: io::Error) -> Self {
        Self::Interface(error)
    }
}

impl From<DeviceError> for Broken {
    fn from(error: DeviceError) -> Self {
        Self::Line(error)
    }
}

/// A simulator that is served over an interface, its serial lines and sockets beside it.
pub(super) struct Server<L: EthernetLink> {
    link: L,
    far_ends: FarEnds,
    lines: ServedLines,
    late: VecDeque<Late>,
    truth: Option<TruthLog>,
    next_row: Duration,
    report: Report,
}

impl<L: EthernetLink> Server<L> {
    /// A server of these far ends.
    pub(super) fn new(link: L, far_ends: FarEnds, lines: ServedLines, truth: Option<TruthLog>) -> Self {
        let next_row = link.now();
        let report = Report::default();
        Self { link, far_ends, lines, late: VecDeque::new(), truth, next_row, report }
    }

    /// Serves until an order or a signal ends it.
    ///
    /// # Errors
    /// When the interface or a simulated device is gone.
    pub(super) fn serve(
        mut self,
        control: &Control,
        stop: &AtomicU16,
    ) -> Result<(Report, Option<TruthLog>), Broken> {
        let mut frame = [0; MAX_FRAME_BYTES];
        loop {
            let now = self.link.now();
            let next = self.late.front().map_or(now + LONGEST_WAIT, |late| late.due.min(now + LONGEST_WAIT));
            self.link.wait(next)?;
            while let Some(count) = self.link.receive(&mut frame)? {
                self.take(&mut frame[..count]);
            }
            let now = self.link.now();
            self.send_late(now);
            self.far_ends.line.advance(now);
            self.lines.pump(now)?;
            self.keep_truth(now);
            while let Some(asked) = control.next() {
                if self.obey(asked, now) {
                    return Ok(self.end());
                }
            }
            if signals::exit_code(stop) != 0 {
                return Ok(self.end());
            }
        }
    }

    fn end(mut self) -> (Report, Option<TruthLog>) {
        self.report.contacts = self.far_ends.world.surroundings().contacts();
        (self.report, self.truth)
    }

    /// A frame arrives.
    fn take(&mut self, frame: &mut [u8]) {
        let now = self.link.now();
        let passage = self.far_ends.line.pass(now, frame);
        if passage.answers == 0 {
            self.report.unanswered += 1;
            return;
        }
        self.report.frames += 1;
        let answer = &frame[..passage.bytes];
        for _ in 0..passage.answers {
            if passage.after.is_zero() {
                self.report.unsent += u64::from(self.link.send(answer).is_err());
            } else if self.late.len() < MOST_ANSWERS {
                let due = now + passage.after;
                let place = self.late.partition_point(|earlier| earlier.due <= due);
                self.late.insert(place, Late { due, frame: answer.to_vec() });
            }
        }
    }

    fn send_late(&mut self, now: Duration) {
        while self.late.front().is_some_and(|late| late.due <= now) {
            let Some(late) = self.late.pop_front() else { return };
            self.report.unsent += u64::from(self.link.send(&late.frame).is_err());
        }
    }

    fn keep_truth(&mut self, now: Duration) {
        if let Some(truth) = &mut self.truth
            && now >= self.next_row
        {
            truth.row(now, &self.far_ends.world.truth());
            self.next_row = now + Duration::from_secs(1) / truth::RATE_HZ;
        }
    }

    /// Does what was asked for; true if that is the end.
    fn obey(&mut self, asked: Asked, now: Duration) -> bool {
        let done = || Ok("done".to_owned());
        let result = match &asked.order {
            Order::Wire(fault) => {
                self.far_ends.line.inject(now, LineFault::from(*fault)).and_then(|()| done())
            }
            Order::World(fault) => {
                let scheduled = self.far_ends.world.schedule(now, Fault::from(*fault));
                scheduled.map_err(|error| error.to_string()).and_then(|()| done())
            }
            Order::Bring(case) => {
                self.far_ends.world.surroundings().bring(case);
                done()
            }
            Order::Status => Ok(self.status(now)),
            Order::Stop => Ok("the simulator ends".to_owned()),
        };
        let answer = result.map_or_else(Answer::Refused, Answer::Done);
        // A client that hung up needs no answer.
        let _ = asked.answer.send(answer);
        asked.order == Order::Stop
    }

    fn status(&mut self, now: Duration) -> String {
        let axes = self.far_ends.world.truth();
        let place = |axis: &sim_devices::rig::AxisTruth| {
            format!("{} {:.6} rad {:.6} rad/s", axis.name, axis.angle_rad, axis.rate_rad_per_s)
        };
        let places: Vec<String> = axes.iter().map(place).collect();
        let contacts = self.far_ends.world.surroundings().contacts().len();
        format!(
            "{:.3} s; {} frames answered, {} not; {}; {contacts} contacts with end stops",
            now.as_secs_f64(),
            self.report.frames,
            self.report.unanswered,
            places.join(", ")
        )
    }
}
