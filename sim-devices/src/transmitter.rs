//! The serial transmitter of a simulated device, and the receive buffer of the host.
//!
//! Bytes leave one after another at the bit rate. A byte has arrived when its stop bit has.

use std::collections::VecDeque;
use std::time::Duration;

/// Start bit, eight data bits, stop bit.
const BITS_PER_BYTE: f64 = 10.0;
/// Largest backlog on the line for which a message is still sent. A larger one means that the bit rate is too low for the
/// message rate.
const BACKLOG_BYTES: usize = 64;
/// Size of the host's receive buffer. A message that does not fit any more is lost.
const RECEIVER_BYTES: usize = 4096;

/// Bytes that were sent together, without a gap. `taken_count` of them have been read by the host.
#[derive(Clone, Copy, Debug)]
struct Burst {
    start_ns: u64,
    bytes_count: usize,
    taken_count: usize,
    ns_per_byte: f64,
}

/// Bytes that were sent and not yet read. `free_ns` is the time at which the line becomes idle.
#[derive(Clone, Debug)]
pub(crate) struct Transmitter {
    ns_per_byte: f64,
    bytes: VecDeque<u8>,
    bursts: VecDeque<Burst>,
    free_ns: u64,
}

impl Burst {
    /// Time at which the first `count` bytes have arrived.
    fn arrival_ns(&self, count: usize) -> u64 {
        self.start_ns + (count as f64 * self.ns_per_byte).ceil() as u64
    }

    /// Number of bytes that have arrived and are not yet read.
    fn arrived_count(&self, now_ns: u64) -> usize {
        if now_ns >= self.arrival_ns(self.bytes_count) {
            return self.bytes_count - self.taken_count;
        }
        let elapsed_ns = now_ns.saturating_sub(self.start_ns) as f64;
        let arrived = (elapsed_ns / self.ns_per_byte) as usize;
        arrived.min(self.bytes_count).saturating_sub(self.taken_count)
    }
}

impl Transmitter {
    /// An idle line with this bit rate, bit/s.
    pub(crate) fn new(baud: f64) -> Self {
        Self {
            ns_per_byte: BITS_PER_BYTE * 1e9 / baud,
            bytes: VecDeque::with_capacity(RECEIVER_BYTES),
            bursts: VecDeque::with_capacity(RECEIVER_BYTES / 8),
            free_ns: 0,
        }
    }

    /// Sets the bit rate, bit/s, for what is sent from now on. Bytes already on the line keep theirs.
    pub(crate) fn set_baud(&mut self, baud: f64) {
        self.ns_per_byte = BITS_PER_BYTE * 1e9 / baud;
    }

    /// Whether the line carries nothing at a time.
    pub(crate) fn is_free(&self, at_ns: u64) -> bool {
        self.free_ns <= at_ns
    }

    /// Sends a message unless the backlog is too large; tells whether it was sent.
    pub(crate) fn send(&mut self, now_ns: u64, message: &[u8]) -> bool {
        let backlog_ns = self.free_ns.saturating_sub(now_ns) as f64;
        if backlog_ns > BACKLOG_BYTES as f64 * self.ns_per_byte {
            return false;
        }
        self.append(now_ns, message);
        true
    }

    /// Queues bytes behind the backlog, however large it is. They are lost if the host's receive buffer cannot take them.
    pub(crate) fn append(&mut self, now_ns: u64, bytes: &[u8]) {
        let start_ns = now_ns.max(self.free_ns);
        let burst =
            Burst { start_ns, bytes_count: bytes.len(), taken_count: 0, ns_per_byte: self.ns_per_byte };
        self.free_ns = burst.arrival_ns(bytes.len());
        if self.bytes.len() + bytes.len() <= RECEIVER_BYTES {
            self.bytes.extend(bytes);
            self.bursts.push_back(burst);
        }
    }

    /// Reads bytes that have arrived into `into`, oldest first; gives their number.
    pub(crate) fn take(&mut self, now_ns: u64, into: &mut [u8]) -> usize {
        let mut filled = 0;
        while let Some(burst) = self.bursts.front_mut() {
            let count = burst.arrived_count(now_ns).min(into.len() - filled);
            let (front, back) = self.bytes.as_slices();
            let target = &mut into[filled..filled + count];
            let from_front = count.min(front.len());
            target[..from_front].copy_from_slice(&front[..from_front]);
            target[from_front..].copy_from_slice(&back[..count - from_front]);
            self.bytes.drain(..count);
            filled += count;
            burst.taken_count += count;
            if burst.taken_count < burst.bytes_count {
                break;
            }
            self.bursts.pop_front();
        }
        filled
    }
}

/// A time since the start of the point in whole nanoseconds.
pub(crate) fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

/// A time of the host since the start of the point in whole nanoseconds.
pub(crate) fn whole_nanoseconds(now: Duration) -> u64 {
    u64::try_from(now.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 36 bytes at 921600 baud take 390.6 µs (ICD 56-0298: 10 bits a character).
    #[test]
    fn bytes_arrive_one_by_one_at_the_bit_rate() {
        let mut line = Transmitter::new(921_600.0);
        line.append(1000, &[7; 36]);
        let mut buffer = [0; 64];
        assert_eq!(line.take(1000, &mut buffer), 0);
        assert_eq!(line.take(1000 + 10_850, &mut buffer), 0);
        assert_eq!(line.take(1000 + 10_851, &mut buffer), 1);
        assert_eq!(line.take(1000 + 390_624, &mut buffer), 34);
        assert_eq!(line.take(1000 + 390_625, &mut buffer), 1);
        assert_eq!(line.take(u64::MAX, &mut buffer), 0);
    }

    #[test]
    fn bursts_follow_each_other_and_small_reads_lose_nothing() {
        let mut line = Transmitter::new(1e6);
        line.append(0, &[1, 2, 3]);
        line.append(0, &[4, 5]);
        let mut all: Vec<u8> = Vec::new();
        for now_ns in (0..60_000).step_by(5_000) {
            let mut two = [0; 2];
            let count = line.take(now_ns, &mut two);
            all.extend(&two[..count]);
            assert_eq!(all.len() as u64, now_ns.min(50_000) / 10_000, "at {now_ns} ns");
        }
        assert_eq!(all, [1, 2, 3, 4, 5]);
    }

    #[test]
    fn a_line_that_is_too_slow_loses_whole_messages() {
        let mut line = Transmitter::new(921_600.0);
        let sent = (0..400).filter(|tick| line.send(tick * 250_000, &[0; 36])).count();
        let possible = 400.0 * 250.0 / 390.625;
        assert!((sent as f64 - possible).abs() < 4.0, "{sent} of 400 at 4 kHz");
    }
}
