//! Outputs on their way from the bus interface to the power stage.

use std::collections::VecDeque;

use crate::physics::noise::Noise;

/// Process data that arrived and do not act yet. Their order is kept, whatever the jitter.
#[derive(Clone, Debug)]
pub(super) struct Deferred {
    delay_steps: u64,
    jitter_steps: f64,
    jitter: Noise,
    waiting: VecDeque<(u64, Vec<u8>)>,
    /// Emptied buffers, so that a tick allocates nothing.
    spare: Vec<Vec<u8>>,
}

impl Deferred {
    /// A delay in steps, and the largest extra one.
    pub(super) fn new(delay_steps: u64, jitter_steps: f64, jitter: Noise) -> Self {
        Self { delay_steps, jitter_steps, jitter, waiting: VecDeque::new(), spare: Vec::new() }
    }

    /// Takes what arrived at a step.
    pub(super) fn push(&mut self, step: u64, outputs: &[u8]) {
        let extra =
            if self.jitter_steps > 0.0 { self.jitter_steps * self.jitter.uniform_at(step) } else { 0.0 };
        let latest = self.waiting.back().map_or(0, |(due, _)| *due);
        let due = (step + self.delay_steps + extra.round() as u64).max(latest);
        let mut buffer = self.spare.pop().unwrap_or_default();
        buffer.clear();
        buffer.extend_from_slice(outputs);
        self.waiting.push_back((due, buffer));
    }

    /// When the next ones act.
    pub(super) fn next_due(&self) -> Option<u64> {
        self.waiting.front().map(|(due, _)| *due)
    }

    /// Those that act at this step.
    pub(super) fn pop(&mut self, step: u64) -> Option<Vec<u8>> {
        (self.next_due()? <= step).then(|| self.waiting.pop_front().map(|(_, bytes)| bytes)).flatten()
    }

    /// Gives a buffer back.
    pub(super) fn recycle(&mut self, buffer: Vec<u8>) {
        self.spare.push(buffer);
    }

    /// Forgets what is under way.
    pub(super) fn clear(&mut self) {
        self.spare.extend(self.waiting.drain(..).map(|(_, bytes)| bytes));
    }
}
