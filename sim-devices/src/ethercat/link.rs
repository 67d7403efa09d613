//! A line of SubDevices in the process of the MainDevice, in simulated time: no socket, no rights, no other process.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use drivers::wire::{EthernetLink, MAX_FRAME_BYTES};

use super::line::EtherCatLine;

/// From the last byte that goes out to the first that comes back, in simulated time.
const ROUND_TRIP: Duration = Duration::from_micros(20);

/// An answer on its way.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Answer {
    due: Duration,
    frame: Vec<u8>,
}

/// The wire to a line in the same process. Time passes only while somebody waits.
pub struct InProcessLink {
    line: Box<dyn EtherCatLine>,
    now: Duration,
    /// In the order in which they arrive.
    answers: VecDeque<Answer>,
}

impl InProcessLink {
    /// A wire whose time begins at 0.
    pub fn new(line: Box<dyn EtherCatLine>) -> Self {
        Self { line, now: Duration::ZERO, answers: VecDeque::new() }
    }

    /// The line at the far end, for faults.
    pub fn line(&mut self) -> &mut dyn EtherCatLine {
        &mut *self.line
    }
}

impl EthernetLink for InProcessLink {
    fn name(&self) -> &str {
        "simulated Ethernet"
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let mut answer = frame.to_vec();
        let passage = self.line.pass(self.now, &mut answer);
        answer.truncate(passage.bytes);
        let due = self.now.saturating_add(ROUND_TRIP).saturating_add(passage.after);
        for _ in 0..passage.answers {
            let place = self.answers.partition_point(|earlier| earlier.due <= due);
            self.answers.insert(place, Answer { due, frame: answer.clone() });
        }
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        if self.answers.front().is_none_or(|answer| answer.due > self.now) {
            return Ok(None);
        }
        let Some(Answer { frame, .. }) = self.answers.pop_front() else { return Ok(None) };
        let count = frame.len().min(into.len()).min(MAX_FRAME_BYTES);
        into[..count].copy_from_slice(&frame[..count]);
        Ok(Some(count))
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        let next = self.answers.front().map_or(until, |answer| answer.due.min(until));
        if next > self.now {
            self.now = next;
        }
        self.line.advance(self.now);
        Ok(())
    }
}
