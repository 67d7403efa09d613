//! Frames that wait: for a time, or for the frame behind them.

use std::time::Duration;

use super::super::StoredFrame;

/// Frames that may wait at once, each way. Further ones are lost, as on a full queue.
pub(super) const MOST_HELD: usize = 64;

#[derive(Clone, Copy, Debug)]
struct Waiting {
    /// When it goes on; `None` behind the next frame that does.
    due: Option<Duration>,
    frame: StoredFrame,
}

/// Frames that wait, in the order in which they came.
#[derive(Debug)]
pub(super) struct Held {
    waiting: Vec<Waiting>,
}

impl Held {
    pub(super) fn new() -> Self {
        Self { waiting: Vec::with_capacity(MOST_HELD) }
    }

    /// Keeps a frame; `false` if there is no room.
    pub(super) fn push(&mut self, due: Option<Duration>, frame: &StoredFrame) -> bool {
        let has_room = self.waiting.len() < MOST_HELD;
        if has_room {
            self.waiting.push(Waiting { due, frame: *frame });
        }
        has_room
    }

    /// The place of the frame that goes on first; of those with the same time the one that came first.
    fn first(&self) -> Option<usize> {
        let timed = self.waiting.iter().enumerate().filter_map(|(k, waiting)| Some((waiting.due?, k)));
        timed.min().map(|(_, k)| k)
    }

    /// When the next frame goes on.
    pub(super) fn next_due(&self) -> Option<Duration> {
        self.waiting[self.first()?].due
    }

    /// The frame that goes on next.
    pub(super) fn first_due(&self) -> Option<&StoredFrame> {
        Some(&self.waiting[self.first()?].frame)
    }

    /// Lets go of that frame.
    pub(super) fn pop_due(&mut self) {
        if let Some(first) = self.first() {
            self.waiting.remove(first);
        }
    }

    /// A frame has gone on: those that waited behind it may follow.
    pub(super) fn release(&mut self) {
        for waiting in &mut self.waiting {
            waiting.due.get_or_insert(Duration::ZERO);
        }
    }

    /// Lets go of the second copies of a frame that was not taken: they have no waiting time.
    pub(super) fn forget_doubles(&mut self) {
        self.waiting.retain(|waiting| waiting.due != Some(Duration::ZERO));
    }
}
