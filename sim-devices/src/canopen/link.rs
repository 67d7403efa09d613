//! The wire to the nodes: in the process of the main device and in simulated time, or over any other CAN interface.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use super::line::CanOpenLine;
use drivers::wire::can::{CanEvent, CanFrame, CanLink, most_frame_bits};

/// A CAN bus in the process of the main device. Time passes only while somebody waits; a frame occupies the bus for as many
/// bits as it has with all stuff bits. Frames go in the order in which they were sent, whatever their priority.
pub struct InProcessCan {
    line: Box<dyn CanOpenLine>,
    bit_rate_hz: f64,
    now: Duration,
    busy_until: Duration,
    /// To the nodes, with the instants at which the frames arrive.
    going: VecDeque<(Duration, CanFrame)>,
    /// To the host, likewise.
    coming: VecDeque<(Duration, CanEvent)>,
}

impl InProcessCan {
    /// A bus whose time begins at 0.
    pub fn new(line: Box<dyn CanOpenLine>, bit_rate_hz: f64) -> Self {
        let (now, busy_until) = Default::default();
        Self { line, bit_rate_hz, now, busy_until, going: VecDeque::new(), coming: VecDeque::new() }
    }

    /// The nodes at the far end, for faults.
    pub fn line(&mut self) -> &mut dyn CanOpenLine {
        &mut *self.line
    }

    /// When a frame that is sent now has arrived.
    fn arrival(&mut self, sent: Duration, data_bytes: usize) -> Duration {
        let takes_s = f64::from(most_frame_bits(data_bytes)) / self.bit_rate_hz;
        self.busy_until = self.busy_until.max(sent) + Duration::from_secs_f64(takes_s);
        self.busy_until
    }

    fn collect(&mut self, sent: Duration) {
        while let Some(event) = self.line.give() {
            let due = match &event {
                CanEvent::Frame(frame) => self.arrival(sent, frame.data().len()),
                // It was never on the bus.
                CanEvent::Error(_) => self.busy_until.max(sent),
            };
            self.coming.push_back((due, event));
        }
    }

    fn has_arrived(&self) -> bool {
        self.coming.front().is_some_and(|(due, _)| *due <= self.now)
    }
}

impl CanLink for InProcessCan {
    fn name(&self) -> &str {
        "simulated CAN"
    }

    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        let due = self.arrival(self.now, frame.data().len());
        self.going.push_back((due, *frame));
        Ok(())
    }

    fn receive(&mut self) -> io::Result<Option<CanEvent>> {
        self.collect(self.now);
        Ok(if self.has_arrived() { self.coming.pop_front().map(|(_, event)| event) } else { None })
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        loop {
            self.collect(self.now);
            if self.has_arrived() || self.now >= until {
                return Ok(());
            }
            let going = self.going.front().map(|(due, _)| *due);
            let coming = self.coming.front().map(|(due, _)| *due);
            let next = [going, coming, self.line.next_due()].into_iter().flatten().min();
            self.now = next.map_or(until, |next| next.clamp(self.now, until));
            while self.going.front().is_some_and(|(due, _)| *due <= self.now)
                && let Some((_, frame)) = self.going.pop_front()
            {
                self.line.take(self.now, &frame);
            }
            self.line.advance(self.now);
        }
    }
}

/// Serves the nodes on an interface until `until`, by the time of the interface.
///
/// # Errors
/// When the interface is down or gone. A frame that finds the queue full is lost.
pub fn serve(link: &mut dyn CanLink, line: &mut dyn CanOpenLine, until: Duration) -> io::Result<()> {
    loop {
        while let Some(event) = link.receive()? {
            if let CanEvent::Frame(frame) = event {
                line.take(link.now(), &frame);
                answer(link, line)?;
            }
        }
        line.advance(link.now());
        answer(link, line)?;
        let now = link.now();
        if now >= until {
            return Ok(());
        }
        link.wait(line.next_due().map_or(until, |due| due.clamp(now, until)))?;
    }
}

fn answer(link: &mut dyn CanLink, line: &mut dyn CanOpenLine) -> io::Result<()> {
    while let Some(event) = line.give() {
        let CanEvent::Frame(frame) = event else { continue };
        match link.send(&frame) {
            Err(error) if error.kind() == io::ErrorKind::NetworkDown => return Err(error),
            Ok(()) | Err(_) => {}
        }
    }
    Ok(())
}
