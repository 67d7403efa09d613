//! Frames that are lost on their way.

use std::time::Duration;

use crate::physics::noise::{Noise, SeedAddress};

/// Which frames are lost: some at random, some because a fault says so.
#[derive(Debug)]
pub(super) struct LostFrames {
    ratio: f64,
    draws: Noise,
    exchanges_count: u64,
    /// Until then no exchange is answered.
    pub(super) silent_until: Duration,
    /// Frames that are lost from now on, whatever the draws say.
    pub(super) next_count: u32,
}

impl LostFrames {
    /// This share of the frames, each by its own draw.
    pub(super) fn new(ratio: f64, address: &SeedAddress) -> Self {
        Self {
            ratio,
            draws: Noise::new(address, "bus.dropped", 1.0),
            exchanges_count: 0,
            silent_until: Duration::ZERO,
            next_count: 0,
        }
    }

    /// Whether the frame of the next exchange, at `now`, is lost.
    pub(super) fn takes_next(&mut self, now: Duration) -> bool {
        self.exchanges_count += 1;
        if self.next_count > 0 {
            self.next_count -= 1;
            return true;
        }
        if now < self.silent_until {
            return true;
        }
        self.ratio > 0.0 && self.draws.uniform_at(self.exchanges_count) < self.ratio
    }
}
