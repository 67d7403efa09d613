//! The monotonic clock: reading it, and resting until it says so.

use std::time::Duration;

use rustix::thread::{ClockId, clock_nanosleep_absolute};
use rustix::time::Timespec;

/// Time of the monotonic clock.
pub(crate) fn now() -> Duration {
    let time = rustix::time::clock_gettime(ClockId::Monotonic);
    Duration::new(u64::try_from(time.tv_sec).unwrap_or(0), u32::try_from(time.tv_nsec).unwrap_or(0))
}

/// Rests until `instant`, whatever signals come.
pub(crate) fn rest_until(instant: Duration) {
    let request = Timespec {
        tv_sec: i64::try_from(instant.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: instant.subsec_nanos().into(),
    };
    while clock_nanosleep_absolute(ClockId::Monotonic, &request).is_err() && now() < instant {}
}
