//! How far a point is: the loop writes, whoever shows it reads, and neither waits for the other.

use std::sync::atomic::{AtomicU16, AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

use crate::cycle::sequence::State;

/// Number of the phase in which the rig is brought to its safe state, after those of [`State::number`].
pub const MAKE_SAFE: u16 = 7;

/// How far one point is.
#[derive(Debug, Default)]
pub struct Progress {
    loop_ms: AtomicU64,
    /// Index of the segment, plus one; 0 before the first.
    segment: AtomicU32,
    phase: AtomicU16,
}

/// What a reader sees of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Time in the loop since the point began, s.
    pub loop_s: f64,
    /// Index of the segment that runs, or ran last.
    pub segment: Option<usize>,
    /// What the axis does, as a person says it.
    pub doing: &'static str,
}

impl Progress {
    /// Notes where the loop is. Called in the tick: nothing is allocated, and nobody is waited for.
    pub fn note(&self, since_start: Duration, state: &State<'_>) {
        self.loop_ms.store(since_start.as_millis() as u64, Ordering::Relaxed);
        self.phase.store(state.number(), Ordering::Relaxed);
        if let State::Running(running) = state {
            self.segment.store(running.index as u32 + 1, Ordering::Relaxed);
        }
    }

    /// Notes that the point is over but for its safe state.
    pub fn note_make_safe(&self) {
        self.phase.store(MAKE_SAFE, Ordering::Relaxed);
    }

    /// Where the loop was last.
    pub fn seen(&self) -> Seen {
        Seen {
            loop_s: self.loop_ms.load(Ordering::Relaxed) as f64 / 1e3,
            segment: (self.segment.load(Ordering::Relaxed) as usize).checked_sub(1),
            doing: doing(self.phase.load(Ordering::Relaxed)),
        }
    }
}

/// What the axis does in the phase of this number.
fn doing(phase: u16) -> &'static str {
    match phase {
        0 | 1 | 2 | 8 => "powering up",
        3 => "running",
        4 => "coming to rest",
        5 => "stopping",
        9 => "waiting for an answer",
        10 => "moving to the start",
        11 => "parking",
        _ => "making safe",
    }
}
