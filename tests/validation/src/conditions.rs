//! Conditions under which a test runs a single point.

use std::sync::atomic::AtomicU16;

use bench::clock::Clock;
use bench::cycle::run::Conditions;
use procedures::case::Case;

/// Loop rate of most tests.
const LOOP_RATE_HZ: f64 = 4000.0;

/// A point in virtual time that moves the first axis, without gates, questions or parking.
pub fn of_point<'a>(case: &'a Case, stop: &'a AtomicU16) -> Conditions<'a> {
    Conditions {
        point: 0,
        case,
        moving: 0,
        log_start_ns: 1_000_000_000,
        loop_rate_hz: LOOP_RATE_HZ,
        log_every: 1,
        log_payload_every: 8,
        max_missed_periods: 20,
        gates: &[],
        questions: [].into(),
        parks: false,
        stop,
        clock: Clock::Virtual,
        progress: std::sync::Arc::default(),
    }
}
