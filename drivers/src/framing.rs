//! Bytes of a serial line on their way into frames.
//!
//! A parser looks at the bytes that wait. It takes a frame whose checksum is right; otherwise it gives up one byte and looks
//! again, so that a frame inside a false one is not lost.

use std::time::Duration;

use crate::device::DeviceError;
use crate::wire::ByteLine;

/// Bytes read from a line at once: room for two frames of most protocols.
const READ_BYTES: usize = 128;
/// Bytes that can wait; more than are pushed between two searches.
const BUFFER_BYTES: usize = 1024;
/// Longest frame of any protocol here. Two fit, so that a frame behind a false one is whole before bytes are given up.
pub(crate) const LONGEST_FRAME: usize = BUFFER_BYTES / 2;

/// A serial device is stale when nothing has come for this many periods of its messages (docs/safety.md).
pub const STALE_PERIODS: f64 = 10.0;

/// Reads everything that has arrived up to `now` and hands it on, in pieces.
///
/// # Errors
/// When the line is gone; what `take` says.
pub(crate) fn read_waiting(
    line: &mut dyn ByteLine,
    now: Duration,
    mut take: impl FnMut(&[u8]) -> Result<(), DeviceError>,
) -> Result<(), DeviceError> {
    let mut bytes = [0; READ_BYTES];
    loop {
        let count = line.read(now, &mut bytes)?.min(READ_BYTES);
        take(&bytes[..count])?;
        // A buffer that was not filled means that nothing more is waiting.
        if count < READ_BYTES {
            return Ok(());
        }
    }
}

/// When frames came last, and how many, for a device that is polled once per tick.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Freshness {
    /// Poll that found the newest frame.
    found_at: Duration,
    /// Ticks since the newest frame arrived.
    pub(crate) age_ticks: u16,
    /// Frames that came with the last poll.
    pub(crate) new_count: u32,
}

impl Freshness {
    /// A poll has found so many frames.
    pub(crate) fn polled(&mut self, now: Duration, count: u32) {
        self.new_count = count;
        self.age_ticks = if count > 0 { 0 } else { self.age_ticks.saturating_add(1) };
        if count > 0 {
            self.found_at = now;
        }
    }

    /// How long no poll has found a frame.
    pub(crate) fn silent_s(&self, now: Duration) -> f64 {
        now.saturating_sub(self.found_at).as_secs_f64()
    }
}

/// What a parser threw away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Frames with a header and a wrong checksum.
    pub bad_checksums_count: u64,
    /// Bytes that belong to no frame.
    pub skipped_bytes_count: u64,
}

/// Bytes that have arrived and belong to no frame yet; allocates nothing.
#[derive(Clone, Debug)]
pub(crate) struct Stream {
    buffer: [u8; BUFFER_BYTES],
    start: usize,
    end: usize,
    tally: Tally,
}

impl Default for Stream {
    fn default() -> Self {
        Self { buffer: [0; BUFFER_BYTES], start: 0, end: 0, tally: Tally::default() }
    }
}

impl Stream {
    /// Appends bytes. If they do not fit, the oldest are given up (and counted as skipped).
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        let kept = bytes.len().min(BUFFER_BYTES);
        self.tally.skipped_bytes_count += (bytes.len() - kept) as u64;
        if self.end + kept > BUFFER_BYTES {
            self.make_room(kept);
        }
        self.buffer[self.end..self.end + kept].copy_from_slice(&bytes[bytes.len() - kept..]);
        self.end += kept;
    }

    fn make_room(&mut self, wanted: usize) {
        let waiting = self.end - self.start;
        let lost = (waiting + wanted).saturating_sub(BUFFER_BYTES);
        self.skip(lost);
        self.buffer.copy_within(self.start..self.end, 0);
        (self.start, self.end) = (0, self.end - self.start);
    }

    /// Bytes that wait, oldest first.
    pub(crate) fn waiting(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// Gives up the oldest `count` bytes: they belong to no frame.
    pub(crate) fn skip(&mut self, count: usize) {
        self.tally.skipped_bytes_count += count as u64;
        self.take(count);
    }

    /// The checksum is wrong of the frame that seemed to begin with the oldest byte.
    pub(crate) fn reject(&mut self) {
        self.tally.bad_checksums_count += 1;
        self.skip(1);
    }

    /// Takes the oldest `count` bytes, at most those that wait: they belong to a frame.
    pub(crate) fn take(&mut self, count: usize) {
        self.start = (self.start + count).min(self.end);
    }

    /// What was thrown away so far.
    pub(crate) fn tally(&self) -> Tally {
        self.tally
    }
}

/// Place of the newest frame among the bytes that have arrived: it tells how long ago the frame began on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Arrival {
    frame_bytes: usize,
    /// Bytes that have arrived after it.
    behind_bytes: usize,
}

impl Arrival {
    /// More bytes have arrived.
    pub(crate) fn bytes_came(&mut self, count: usize) {
        self.behind_bytes = self.behind_bytes.saturating_add(count);
    }

    /// A frame has been found, and `waiting_bytes` have arrived after it.
    pub(crate) fn frame_found(&mut self, frame_bytes: usize, waiting_bytes: usize) {
        *self = Self { frame_bytes, behind_bytes: waiting_bytes };
    }

    /// The latest time at which the first bit of the frame can have left the device, if everything had arrived by `now` at
    /// `byte_s` a byte. The bytes need not have come without pauses: the frame may have begun earlier, by the time between two
    /// polls at the most.
    pub(crate) fn began(&self, now: Duration, byte_s: f64) -> Duration {
        let wire_s = (self.frame_bytes + self.behind_bytes) as f64 * byte_s;
        now.saturating_sub(Duration::try_from_secs_f64(wire_s).unwrap_or(Duration::MAX))
    }
}

/// A line on which these bytes have arrived.
#[cfg(test)]
pub(crate) struct WaitingBytes(pub(crate) Vec<u8>);

#[cfg(test)]
impl ByteLine for WaitingBytes {
    fn name(&self) -> &str {
        "line"
    }

    fn read(&mut self, _: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let count = into.len().min(self.0.len());
        into[..count].copy_from_slice(&self.0[..count]);
        self.0.drain(..count);
        Ok(count)
    }

    fn write(&mut self, _: Duration, _: &[u8]) -> Result<(), DeviceError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_that_do_not_fit_push_out_the_oldest() {
        let mut stream = Stream::default();
        stream.push(&[1; 1000]);
        stream.take(10);
        stream.push(&[2; 100]);
        assert_eq!(stream.waiting().len(), BUFFER_BYTES);
        assert_eq!(stream.tally().skipped_bytes_count, 990 + 100 - 1024);
        stream.push(&[3; 3000]);
        assert_eq!(stream.waiting(), [3; BUFFER_BYTES]);
        assert_eq!(stream.tally().skipped_bytes_count, 990 + 100 + 3000 - 1024);
    }

    /// 36 bytes at 921600 bit/s take 390.625 µs (KVH ICD 56-0298); ten bytes of the next frame came behind them.
    #[test]
    fn a_frame_began_its_own_bytes_and_those_behind_it_before_now() {
        let mut arrival = Arrival::default();
        arrival.frame_found(36, 4);
        arrival.bytes_came(6);
        let byte_s = 10.0 / 921_600.0;
        let began = arrival.began(Duration::from_millis(5), byte_s);
        let expected_s = 5e-3 - 390.625e-6 - 10.0 * byte_s;
        assert!((began.as_secs_f64() - expected_s).abs() < 2e-9, "{began:?}");
        assert_eq!(arrival.began(Duration::ZERO, byte_s), Duration::ZERO);
        assert_eq!(arrival.began(Duration::from_secs(1), f64::INFINITY), Duration::ZERO);
    }
}
