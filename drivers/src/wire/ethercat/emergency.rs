//! Emergency messages (CoE service 1) of stations.

use std::collections::VecDeque;
use std::time::Duration;

/// Emergencies that are kept; when there are more, the oldest goes.
pub(super) const MOST: usize = 64;

/// An emergency message that a station has sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emergency {
    /// Station.
    pub station: u16,
    /// Error code, as in 603Fh: see [`error_code_meaning`](crate::cia402::error_code_meaning). 0 says that an error is gone.
    pub code: u16,
    /// Error register (1001h).
    pub register: u8,
    /// The maker's bytes.
    pub vendor: [u8; 5],
    /// When it was read, since the start of the run.
    pub at: Duration,
}

/// The emergencies that nobody has asked for yet.
#[derive(Debug)]
pub(super) struct Emergencies {
    queue: VecDeque<Emergency>,
    lost_count: u64,
}

impl Emergencies {
    pub(super) fn new() -> Self {
        Self { queue: VecDeque::with_capacity(MOST), lost_count: 0 }
    }

    pub(super) fn push(&mut self, emergency: Emergency) {
        if self.queue.len() == MOST {
            self.queue.pop_front();
            self.lost_count += 1;
        }
        self.queue.push_back(emergency);
    }

    pub(super) fn pop(&mut self) -> Option<Emergency> {
        self.queue.pop_front()
    }

    pub(super) fn lost_count(&self) -> u64 {
        self.lost_count
    }
}
