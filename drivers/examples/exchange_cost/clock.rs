//! The monotonic clock: reading it, resting until it says so, and measuring calls of the system with it.

use std::cell::Cell;
use std::time::Duration;

use rustix::thread::{ClockId, clock_nanosleep_absolute};
use rustix::time::Timespec;

/// Time of the monotonic clock.
pub(crate) fn now() -> Duration {
    let time = rustix::time::clock_gettime(ClockId::Monotonic);
    Duration::new(u64::try_from(time.tv_sec).unwrap_or(0), u32::try_from(time.tv_nsec).unwrap_or(0))
}

/// Time of the monotonic clock in nanoseconds, as ethercrab wants it.
pub(crate) fn now_ns() -> u64 {
    u64::try_from(now().as_nanos()).unwrap_or(u64::MAX)
}

/// Rests until `instant`, whatever signals come.
pub(crate) fn rest_until(instant: Duration) {
    let request = Timespec {
        tv_sec: i64::try_from(instant.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: instant.subsec_nanos().into(),
    };
    while clock_nanosleep_absolute(ClockId::Monotonic, &request).is_err() && now() < instant {}
}

/// How long an exchange spent in calls of the system.
#[derive(Default)]
pub(crate) struct Meter {
    /// In those that wait for the interface.
    pub(crate) waited: Cell<Duration>,
    /// In those that send and receive without waiting.
    pub(crate) called: Cell<Duration>,
}

impl Meter {
    /// Forgets what was measured.
    pub(crate) fn reset(&self) {
        self.waited.set(Duration::ZERO);
        self.called.set(Duration::ZERO);
    }
}

/// Adds the time of a call to `sum`.
pub(crate) fn measured<T>(sum: &Cell<Duration>, call: impl FnOnce() -> T) -> T {
    let begun = now();
    let done = call();
    sum.set(sum.get() + now().saturating_sub(begun));
    done
}
