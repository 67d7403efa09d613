//! What both ends of a line know: the host's end in the tick, and the thread that moves its bytes.

use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use rustix::event::{EventfdFlags, eventfd};
use rustix::io::Errno;

use crate::device::DeviceError;

/// Flags, counters and the bell of a line.
pub(super) struct Shared {
    address: String,
    /// Why the line is gone.
    failure: OnceLock<DeviceError>,
    /// Whether the host has called yet: before that, nothing is kept of what arrives.
    is_heard: AtomicBool,
    /// Whether the host is done with the line.
    is_closed: AtomicBool,
    /// Received bytes of a line, or datagrams, that found the ring full.
    lost_count: AtomicU64,
    /// Datagrams whose peer said that nobody listens.
    refusals_count: AtomicU64,
    /// Wakes the thread that moves bytes.
    bell: Arc<OwnedFd>,
    /// Whether the bell was rung and not yet heard.
    is_rung: AtomicBool,
}

impl Shared {
    /// What a line starts with.
    ///
    /// # Errors
    /// When the operating system has no bell left.
    pub(super) fn new(address: String) -> rustix::io::Result<Self> {
        let bell = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        Ok(Self {
            address,
            failure: OnceLock::new(),
            is_heard: AtomicBool::new(false),
            is_closed: AtomicBool::new(false),
            lost_count: AtomicU64::new(0),
            refusals_count: AtomicU64::new(0),
            bell: Arc::new(bell),
            is_rung: AtomicBool::new(false),
        })
    }

    pub(super) fn address(&self) -> &str {
        &self.address
    }

    pub(super) fn failure(&self) -> Option<&DeviceError> {
        self.failure.get()
    }

    /// The line is gone; the first reason counts.
    pub(super) fn fail(&self, error: DeviceError) {
        let _ = self.failure.set(error);
    }

    pub(super) fn is_heard(&self) -> bool {
        self.is_heard.load(Ordering::Relaxed)
    }

    pub(super) fn hear(&self) {
        self.is_heard.store(true, Ordering::Relaxed);
    }

    pub(super) fn is_closed(&self) -> bool {
        self.is_closed.load(Ordering::Acquire)
    }

    /// The host is done: what it has sent still goes out.
    pub(super) fn close(&self) {
        self.is_closed.store(true, Ordering::Release);
        self.ring();
    }

    pub(super) fn lost_count(&self) -> u64 {
        self.lost_count.load(Ordering::Relaxed)
    }

    pub(super) fn count_lost(&self, lost_count: usize) {
        self.lost_count.fetch_add(lost_count as u64, Ordering::Relaxed);
    }

    pub(super) fn refusals_count(&self) -> u64 {
        self.refusals_count.load(Ordering::Relaxed)
    }

    pub(super) fn count_refusal(&self) {
        self.refusals_count.fetch_add(1, Ordering::Relaxed);
    }

    /// The bell, for whoever waits for it.
    pub(super) fn bell(&self) -> Arc<OwnedFd> {
        Arc::clone(&self.bell)
    }

    /// Wakes the thread that moves bytes, with a call of the system that never waits; with none if it was woken already.
    pub(super) fn ring(&self) {
        if !self.is_rung.swap(true, Ordering::AcqRel) {
            // The counter behind the bell cannot overflow: it is at most 1.
            let _ = rustix::io::write(&*self.bell, &1_u64.to_ne_bytes());
        }
    }

    /// Silences the bell. Whatever was put into the ring before it was rung can be taken after this call.
    pub(super) fn silence(&self) -> rustix::io::Result<()> {
        match rustix::io::read(&*self.bell, &mut [0; 8]) {
            Ok(_) | Err(Errno::WOULDBLOCK) => {}
            Err(error) => return Err(error),
        }
        self.is_rung.swap(false, Ordering::AcqRel);
        Ok(())
    }
}

/// An error of the line at this address.
pub(super) fn failure(
    address: &str,
    field: &'static str,
    expected: impl Into<String>,
    found: impl Into<String>,
    help: &'static str,
) -> DeviceError {
    DeviceError::Field {
        device: address.to_owned(),
        field,
        expected: expected.into(),
        found: found.into(),
        help,
    }
}
