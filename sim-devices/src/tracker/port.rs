//! Messages on their way from a tracker to the host.

use std::collections::VecDeque;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::tracker::LENGTH;
use drivers::wire::DatagramPort;

/// Messages that wait at most, as in the buffer of a socket: then the oldest is lost.
const CAPACITY: usize = 256;

/// Messages in order of their sending, each due at its time.
#[derive(Clone, Debug)]
pub struct TrackerPort {
    name: &'static str,
    waiting: VecDeque<(Duration, [u8; LENGTH])>,
}

impl TrackerPort {
    pub(super) fn new(name: &'static str) -> Self {
        Self { name, waiting: VecDeque::with_capacity(CAPACITY) }
    }

    /// Sends a message that arrives at `due`.
    pub(super) fn put(&mut self, due: Duration, message: [u8; LENGTH]) {
        if self.waiting.len() == CAPACITY {
            self.waiting.pop_front();
        }
        self.waiting.push_back((due, message));
    }
}

impl DatagramPort for TrackerPort {
    fn name(&self) -> &str {
        self.name
    }

    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError> {
        if self.waiting.front().is_none_or(|(due, _)| *due > now) {
            return Ok(None);
        }
        Ok(self.waiting.pop_front().map(|(_, message)| {
            let length = LENGTH.min(into.len());
            into[..length].copy_from_slice(&message[..length]);
            length
        }))
    }

    /// Trackers take no commands: what is sent is not heard.
    fn send(&mut self, _: Duration, _: &[u8]) -> Result<(), DeviceError> {
        Ok(())
    }
}
