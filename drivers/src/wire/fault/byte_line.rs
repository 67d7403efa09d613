//! Faults of a byte line, on purpose: bytes are lost, damaged or made up, and the line falls silent.
//!
//! Which bytes these are depends on seed, way and byte number alone, however the stream is cut into reads and writes. Only
//! how long a silence lasts is a matter of time. Bytes are counted from 1, each way for itself, from
//! [`ByteFaultControl::begin`] on; before that nothing is touched. Half a frame is the loss of as many bytes in a row
//! ([`Occurrence::At`]).

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use super::super::{ByteLine, Way};
use super::plan::{Drawn, Occurrence, draw, mixed};
use crate::device::DeviceError;

/// Bytes that are taken from the line at once.
const PIECE_BYTES: usize = 256;

/// What goes wrong with a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteFaultKind {
    /// It is lost.
    Drop,
    /// One of its bits is wrong.
    Corrupt,
    /// So many bytes that nobody sent come before it.
    Insert {
        /// How many.
        bytes: usize,
    },
    /// It is lost, and so is everything behind it for a time.
    Silence {
        /// For how long.
        lasts: Duration,
    },
}

/// A fault of a byte line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByteLineFault {
    /// Which way the bytes go that have it.
    pub way: Way,
    /// What goes wrong.
    pub kind: ByteFaultKind,
    /// Which bytes.
    pub when: Occurrence,
}

/// All faults of a byte line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ByteLineFaultPlan {
    /// Seed of everything random.
    pub seed: u64,
    /// The faults. Several may befall the same byte; a lost one is lost whatever else there is.
    pub faults: Vec<ByteLineFault>,
}

/// What has befallen the bytes of one way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ByteFaultCounts {
    /// Bytes since the faults began.
    pub bytes: u64,
    /// Bytes that were lost.
    pub dropped: u64,
    /// Bytes that arrived with a wrong bit.
    pub corrupted: u64,
    /// Bytes that nobody sent.
    pub inserted: u64,
}

/// The switch and the counters of a byte line with faults, for other threads.
#[derive(Debug, Default)]
pub struct ByteFaultControl {
    is_active: AtomicBool,
    tallies: [Tally; 2],
}

#[derive(Debug, Default)]
struct Tally {
    bytes: AtomicU64,
    dropped: AtomicU64,
    corrupted: AtomicU64,
    inserted: AtomicU64,
}

impl ByteFaultControl {
    /// Faults begin. Until then every byte passes as it is.
    pub fn begin(&self) {
        self.is_active.store(true, Ordering::Release);
    }

    /// What has befallen the bytes of one way so far.
    pub fn counts(&self, way: Way) -> ByteFaultCounts {
        let tally = &self.tallies[way as usize];
        ByteFaultCounts {
            bytes: tally.bytes.load(Ordering::Relaxed),
            dropped: tally.dropped.load(Ordering::Relaxed),
            corrupted: tally.corrupted.load(Ordering::Relaxed),
            inserted: tally.inserted.load(Ordering::Relaxed),
        }
    }

    fn keep(&self, way: Way, counts: ByteFaultCounts) {
        let tally = &self.tallies[way as usize];
        tally.bytes.store(counts.bytes, Ordering::Relaxed);
        tally.dropped.store(counts.dropped, Ordering::Relaxed);
        tally.corrupted.store(counts.corrupted, Ordering::Relaxed);
        tally.inserted.store(counts.inserted, Ordering::Relaxed);
    }
}

/// A byte line with faults.
pub struct FaultyByteLine<L> {
    line: L,
    plan: ByteLineFaultPlan,
    control: Arc<ByteFaultControl>,
    out: Lane,
    back: Lane,
    /// Bytes on their way back that found no room yet.
    waiting: VecDeque<u8>,
    /// An error of the line that came behind bytes.
    failure: Option<DeviceError>,
    /// Bytes as they are sent on.
    sending: VecDeque<u8>,
}

/// One way.
#[derive(Default)]
struct Lane {
    counts: ByteFaultCounts,
    silent_until: Duration,
}

impl Lane {
    /// Does to bytes what is due to them.
    fn pass(
        &mut self,
        plan: &ByteLineFaultPlan,
        way: Way,
        now: Duration,
        bytes: &[u8],
        into: &mut VecDeque<u8>,
    ) {
        for &byte in bytes {
            self.pass_one(plan, way, now, byte, into);
        }
    }

    fn pass_one(
        &mut self,
        plan: &ByteLineFaultPlan,
        way: Way,
        now: Duration,
        byte: u8,
        into: &mut VecDeque<u8>,
    ) {
        self.counts.bytes += 1;
        let number = self.counts.bytes;
        let mut is_lost = false;
        let mut flipped = 0_u8;
        let mut inserted_count = 0;
        let mut garbage = 0;
        for (k, fault) in plan.faults.iter().enumerate().filter(|(_, fault)| fault.way == way) {
            if !fault.when.includes(number, || draw(plan.seed, k, way, number, Drawn::Whether)) {
                continue;
            }
            match fault.kind {
                ByteFaultKind::Drop => is_lost = true,
                ByteFaultKind::Corrupt => flipped |= 1 << (draw(plan.seed, k, way, number, Drawn::Bit) % 8),
                ByteFaultKind::Insert { bytes } => {
                    inserted_count += bytes;
                    garbage = draw(plan.seed, k, way, number, Drawn::Garbage);
                }
                ByteFaultKind::Silence { lasts } => self.silent_until = self.silent_until.max(now + lasts),
            }
        }
        let is_silent = now < self.silent_until;
        if !is_silent {
            into.extend((0..inserted_count as u64).map(|k| mixed(garbage ^ k) as u8));
            self.counts.inserted += inserted_count as u64;
        }
        if is_lost || is_silent {
            self.counts.dropped += 1;
        } else {
            self.counts.corrupted += u64::from(flipped != 0);
            into.push_back(byte ^ flipped);
        }
    }
}

impl<L: ByteLine> FaultyByteLine<L> {
    /// A line that has these faults from the moment when `control` begins them.
    pub fn new(line: L, plan: ByteLineFaultPlan, control: Arc<ByteFaultControl>) -> Self {
        Self {
            line,
            plan,
            control,
            out: Lane::default(),
            back: Lane::default(),
            waiting: VecDeque::with_capacity(2 * PIECE_BYTES),
            failure: None,
            sending: VecDeque::with_capacity(2 * PIECE_BYTES),
        }
    }

    fn is_active(&self) -> bool {
        self.control.is_active.load(Ordering::Acquire)
    }
}

impl<L: ByteLine> ByteLine for FaultyByteLine<L> {
    fn name(&self) -> &str {
        self.line.name()
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        if !self.is_active() {
            return self.line.read(now, into);
        }
        let mut filled_count = 0;
        loop {
            let count = self.waiting.len().min(into.len() - filled_count);
            let places = &mut into[filled_count..filled_count + count];
            places.iter_mut().zip(self.waiting.drain(..count)).for_each(|(place, byte)| *place = byte);
            filled_count += count;
            if filled_count == into.len() {
                return Ok(filled_count);
            }
            if let Some(error) = self.failure.take_if(|_| filled_count == 0) {
                return Err(error);
            }
            let mut piece = [0; PIECE_BYTES];
            match self.line.read(now, &mut piece) {
                Ok(0) => return Ok(filled_count),
                Ok(count) => {
                    self.back.pass(&self.plan, Way::Back, now, &piece[..count], &mut self.waiting);
                    self.control.keep(Way::Back, self.back.counts);
                }
                Err(error) if filled_count == 0 => return Err(error),
                Err(error) => {
                    self.failure = Some(error);
                    return Ok(filled_count);
                }
            }
        }
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        if !self.is_active() {
            return self.line.write(now, bytes);
        }
        self.sending.clear();
        self.out.pass(&self.plan, Way::Out, now, bytes, &mut self.sending);
        self.control.keep(Way::Out, self.out.counts);
        self.line.write(now, self.sending.make_contiguous())
    }
}

#[cfg(test)]
mod tests;
