//! What others know of the faults of an interface, and the switch that begins them.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::super::Way;

/// What has befallen the frames of one way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaultCounts {
    /// Frames since the faults began.
    pub frames: u64,
    /// Frames that were lost.
    pub dropped: u64,
    /// Frames that came late.
    pub delayed: u64,
    /// Frames that came twice.
    pub duplicated: u64,
    /// Frames with a wrong bit.
    pub corrupted: u64,
    /// Frames that were cut off.
    pub truncated: u64,
    /// Frames that came behind the next one.
    pub reordered: u64,
    /// Frames that were lost because too many were waiting.
    pub overflowed: u64,
}

/// One of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Counted {
    Frames,
    Dropped,
    Delayed,
    Duplicated,
    Corrupted,
    Truncated,
    Reordered,
    Overflowed,
}

const SORTS: usize = 8;

/// The switch and the counters of one or more interfaces with faults, for other threads.
#[derive(Debug, Default)]
pub struct FaultControl {
    is_active: AtomicBool,
    counts: [[AtomicU64; SORTS]; 2],
}

impl FaultControl {
    /// Faults begin. Until then every frame passes as it is.
    pub fn begin(&self) {
        self.is_active.store(true, Ordering::Release);
    }

    pub(super) fn is_active(&self) -> bool {
        self.is_active.load(Ordering::Acquire)
    }

    pub(super) fn count(&self, way: Way, what: Counted) {
        self.counts[way as usize][what as usize].fetch_add(1, Ordering::Relaxed);
    }

    /// What has befallen the frames of one way so far.
    pub fn counts(&self, way: Way) -> FaultCounts {
        let of = |what: Counted| self.counts[way as usize][what as usize].load(Ordering::Relaxed);
        FaultCounts {
            frames: of(Counted::Frames),
            dropped: of(Counted::Dropped),
            delayed: of(Counted::Delayed),
            duplicated: of(Counted::Duplicated),
            corrupted: of(Counted::Corrupted),
            truncated: of(Counted::Truncated),
            reordered: of(Counted::Reordered),
            overflowed: of(Counted::Overflowed),
        }
    }
}
