//! The time that ethercrab's timers see: an argument of the pump, not a clock.
//!
//! Without its feature `std`, ethercrab takes time from the global driver of `embassy-time`. This one gives each thread the
//! time that its pump has set last, and keeps the earliest instant at which a timer wants to be asked again.

use std::cell::Cell;
use std::time::Duration;

use embassy_time_driver::{Driver, TICK_HZ, time_driver_impl};

const _: () = assert!(TICK_HZ == 1_000_000, "ticks are microseconds here");

thread_local! {
    static NOW_US: Cell<u64> = const { Cell::new(0) };
    static EARLIEST_US: Cell<u64> = const { Cell::new(u64::MAX) };
}

struct PumpTime;

impl Driver for PumpTime {
    fn now(&self) -> u64 {
        NOW_US.get()
    }

    fn schedule_wake(&self, at: u64, _waker: &std::task::Waker) {
        EARLIEST_US.set(EARLIEST_US.get().min(at));
    }
}

time_driver_impl!(static DRIVER: PumpTime = PumpTime);

/// Sets the time for the timers of this thread, and forgets when they wanted to be asked.
pub(super) fn set(now: Duration) {
    NOW_US.set(u64::try_from(now.as_micros()).unwrap_or(u64::MAX));
    EARLIEST_US.set(u64::MAX);
}

/// The earliest instant at which a timer that was polled since [`set`] wants to be asked again; `None` if none waits.
pub(super) fn earliest_timer() -> Option<Duration> {
    let at_us = EARLIEST_US.get();
    (at_us != u64::MAX).then(|| Duration::from_micros(at_us))
}

/// Time since the start of the run in nanoseconds, as ethercrab wants it for distributed clocks.
pub(super) fn now_ns() -> u64 {
    NOW_US.get().saturating_mul(1000)
}
