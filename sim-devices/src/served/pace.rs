//! Bytes that leave at the pace of a line.

use std::collections::VecDeque;
use std::time::Duration;

/// Bits of a character on a serial line: start, eight data bits, stop.
const BITS_PER_BYTE: f64 = 10.0;
/// Bytes that may wait: whoever gives more has to wait.
pub(super) const MOST_WAITING_BYTES: usize = 64 << 10;

/// Bytes on their way. Each one is there when its stop bit is.
#[derive(Clone, Debug)]
pub(super) struct Paced {
    waiting: VecDeque<u8>,
    /// 0 for a line without a bit rate.
    ns_per_byte: f64,
    /// Start bit of the first byte that waits, or the end of the last one that left.
    begins_ns: f64,
}

impl Paced {
    /// A line with this bit rate, bit/s.
    pub(super) fn at_baud(baud: u32) -> Self {
        Self { ns_per_byte: BITS_PER_BYTE * 1e9 / f64::from(baud), ..Self::unpaced() }
    }

    /// A line whose bytes leave at once.
    pub(super) fn unpaced() -> Self {
        Self { waiting: VecDeque::new(), ns_per_byte: 0.0, begins_ns: 0.0 }
    }

    /// Puts bytes behind those that wait.
    pub(super) fn push(&mut self, now: Duration, bytes: &[u8]) {
        if self.waiting.is_empty() {
            self.begins_ns = self.begins_ns.max(now.as_nanos() as f64);
        }
        self.waiting.extend(bytes);
    }

    /// Bytes that may be put in.
    pub(super) fn room_bytes(&self) -> usize {
        MOST_WAITING_BYTES.saturating_sub(self.waiting.len())
    }

    /// Bytes that are there by now.
    pub(super) fn due_count(&self, now: Duration) -> usize {
        if self.ns_per_byte == 0.0 {
            return self.waiting.len();
        }
        // The guard keeps a byte that is due at this very nanosecond from being late by a rounding.
        let passed_ns = now.as_nanos() as f64 - self.begins_ns + 1e-3;
        ((passed_ns / self.ns_per_byte) as usize).min(self.waiting.len())
    }

    /// The first bytes that wait.
    pub(super) fn first(&mut self, count: usize) -> &[u8] {
        &self.waiting.make_contiguous()[..count]
    }

    /// Takes the first bytes away.
    pub(super) fn advance(&mut self, count: usize) {
        self.waiting.drain(..count);
        self.begins_ns += count as f64 * self.ns_per_byte;
    }

    /// Forgets what waits.
    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes what is due.
    fn taken(paced: &mut Paced, now_us: u64) -> usize {
        let count = paced.due_count(Duration::from_micros(now_us));
        paced.advance(count);
        count
    }

    #[test]
    fn bytes_leave_at_the_bit_rate_however_often_they_are_asked_for() {
        let mut line = Paced::at_baud(10_000);
        line.push(Duration::from_micros(500), &[0; 5]);
        assert_eq!([500, 1499, 1500, 1600, 3500].map(|us| taken(&mut line, us)), [0, 0, 1, 0, 2]);
        line.push(Duration::from_micros(4000), &[0; 2]);
        assert_eq!([5500, 6500, 7500, 99_000].map(|us| taken(&mut line, us)), [2, 1, 1, 0]);
        line.push(Duration::from_millis(100), &[0; 2]);
        assert_eq!([100_999, 101_000, 102_000].map(|us| taken(&mut line, us)), [0, 1, 1]);
    }

    #[test]
    fn a_line_without_a_bit_rate_holds_nothing_up() {
        let mut line = Paced::unpaced();
        line.push(Duration::from_secs(1), b"abc");
        assert_eq!((line.due_count(Duration::from_secs(1)), line.first(2)), (3, b"ab".as_slice()));
        assert_eq!(line.room_bytes(), MOST_WAITING_BYTES - 3);
    }
}
