//! The host's ends of lines: rings, so that no call waits for the operating system.

use std::sync::Arc;
use std::time::Duration;

use super::super::{ByteLine, DatagramPort};
use super::ring::{Drain, Feed};
use super::shared::{Shared, failure};
use crate::device::DeviceError;

/// Longest datagram of UDP over IPv4.
pub(super) const LONGEST_DATAGRAM_BYTES: usize = 65_507;

/// What a line and a port have in common.
struct HostEnd {
    shared: Arc<Shared>,
    out: Feed,
    back: Drain,
    /// Capacity of the ring of received bytes, for errors.
    back_bytes: usize,
    is_heard: bool,
    /// Losses and refusals that were reported.
    told_lost_count: u64,
    told_refusals_count: u64,
}

/// The host's end of a serial port or a TCP connection.
///
/// A serial port throws away what arrives before the first call: a device that talks unasked would fill the ring while
/// others are opened. When this is dropped, bytes that were written still go out.
pub struct HostLine(HostEnd);

/// The host's end of a UDP port with one peer. It throws away what arrives before the first call.
pub struct HostPort(HostEnd);

impl HostEnd {
    fn new(shared: Arc<Shared>, out: Feed, back: Drain, back_bytes: usize) -> Self {
        Self { shared, out, back, back_bytes, is_heard: false, told_lost_count: 0, told_refusals_count: 0 }
    }

    /// Says what went wrong since the last call, once.
    fn check(&mut self) -> Result<(), DeviceError> {
        if !self.is_heard {
            self.is_heard = true;
            self.shared.hear();
        }
        let lost_count = self.shared.lost_count();
        if lost_count != self.told_lost_count {
            let new_count = lost_count - self.told_lost_count;
            self.told_lost_count = lost_count;
            let found = format!(
                "{new_count} lost because the ring of {} bytes was full, {lost_count} since the start",
                self.back_bytes
            );
            let help = "the device sends more than its driver reads: look for ticks that came late, or lower its rate";
            return Err(failure(
                self.shared.address(),
                "received",
                "everything to be read in time",
                found,
                help,
            ));
        }
        let refusals_count = self.shared.refusals_count();
        if refusals_count != self.told_refusals_count {
            self.told_refusals_count = refusals_count;
            let help = "check address and port of the device, and whether it has started";
            return Err(failure(
                self.shared.address(),
                "peer",
                "a device that listens at the port",
                "no listener (ICMP port unreachable)",
                help,
            ));
        }
        Ok(())
    }

    /// What `take` finds in the ring; a failure only once the ring is empty, so that what arrived before comes out before.
    fn take<T>(&mut self, take: impl FnOnce(&mut Drain) -> Option<T>) -> Result<Option<T>, DeviceError> {
        self.check()?;
        let has_failed = self.shared.failure().is_some();
        let taken = take(&mut self.back);
        match self.shared.failure() {
            Some(error) if taken.is_none() && has_failed && self.back.is_empty() => Err(error.clone()),
            _ => Ok(taken),
        }
    }

    fn put(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.check()?;
        if let Some(error) = self.shared.failure() {
            return Err(error.clone());
        }
        if !self.out.push(now, bytes) {
            let expected = format!("room for {} bytes", bytes.len());
            let found = format!(
                "{} of {} bytes; the rest waits to be sent",
                self.out.room_bytes(),
                self.out.capacity_bytes()
            );
            let help = "the far end takes less than is written: check it, raise the bit rate, or write less";
            return Err(failure(self.shared.address(), "to be sent", expected, found, help));
        }
        self.shared.ring();
        Ok(())
    }
}

impl Drop for HostEnd {
    fn drop(&mut self) {
        self.shared.close();
    }
}

impl HostLine {
    pub(super) fn new(shared: Arc<Shared>, out: Feed, back: Drain, back_bytes: usize) -> Self {
        Self(HostEnd::new(shared, out, back, back_bytes))
    }

    /// Received bytes that were lost so far because the ring was full. Each loss is also an error of the next call.
    pub fn lost_count(&self) -> u64 {
        self.0.shared.lost_count()
    }
}

impl HostPort {
    pub(super) fn new(shared: Arc<Shared>, out: Feed, back: Drain, back_bytes: usize) -> Self {
        Self(HostEnd::new(shared, out, back, back_bytes))
    }

    /// Received datagrams that were lost so far because the ring was full. Each loss is also an error of the next call.
    pub fn lost_count(&self) -> u64 {
        self.0.shared.lost_count()
    }
}

impl ByteLine for HostLine {
    fn name(&self) -> &str {
        self.0.shared.address()
    }

    /// Takes what the thread that moves bytes had received by `now`. Allocates nothing unless it fails.
    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let count = self.0.take(|back| Some(back.read(now, into)).filter(|&count| count > 0))?;
        Ok(count.unwrap_or(0))
    }

    /// Hands the bytes over, all of them or none. Allocates nothing unless it fails.
    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.0.put(now, bytes)
    }
}

impl DatagramPort for HostPort {
    fn name(&self) -> &str {
        self.0.shared.address()
    }

    /// Takes the oldest datagram that was received by `now`; what does not fit into `into` is cut off. Allocates nothing unless
    /// it fails.
    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError> {
        self.0.take(|back| back.next_chunk(now, into))
    }

    /// Hands a datagram over. Allocates nothing unless it fails.
    fn send(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        if bytes.len() > LONGEST_DATAGRAM_BYTES {
            let expected = format!("at most {LONGEST_DATAGRAM_BYTES} bytes in a datagram");
            let help = "send it in several";
            return Err(failure(
                self.0.shared.address(),
                "to be sent",
                expected,
                bytes.len().to_string(),
                help,
            ));
        }
        self.0.put(now, bytes)
    }
}
