//! The only file that reads a clock or sleeps.
//!
//! Everything else is handed the time since the start of the run as a [`Duration`].
#![allow(clippy::disallowed_methods)]

use std::time::{Duration, Instant, SystemTime};

/// Where the loop's time comes from.
#[derive(Clone, Copy, Debug)]
pub enum Clock {
    /// Time passes as fast as it is computed.
    Virtual,
    /// Time passes by itself; `Instant` is the start of the run.
    Real(Instant),
}

impl Clock {
    /// A real clock that starts now.
    pub fn real() -> Self {
        Self::Real(Instant::now())
    }

    /// Waits until `due` and returns the time then; a virtual clock is there at once and on time.
    pub fn wait_until(&self, due: Duration) -> Duration {
        match self {
            Self::Virtual => due,
            Self::Real(start) => {
                if let Some(left) = due.checked_sub(start.elapsed()) {
                    std::thread::sleep(left);
                }
                start.elapsed()
            }
        }
    }
}

/// Measures how long something takes, for the record (never for the findings).
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the start.
    pub fn elapsed_s(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// A short rest for a thread that waits on a ring.
pub fn nap() {
    std::thread::sleep(Duration::from_micros(200));
}

/// Wall clock in UTC, RFC 3339 with seconds, for titles and journals.
pub fn utc_now() -> String {
    rfc3339(SystemTime::now())
}

/// The end of the year 9999, in seconds since 1970: no later time has a name.
const LAST_S: u64 = 253_402_300_799;

/// A time that has no name, because somebody set the clock before 1970 or after 9999, is the nearest one that has.
fn rfc3339(at: SystemTime) -> String {
    let since_1970 = at.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let named = SystemTime::UNIX_EPOCH + since_1970.min(Duration::from_secs(LAST_S));
    humantime::format_rfc3339_seconds(named).to_string()
}

/// Today in UTC, `2026-11-22`: what calibrations are held against.
pub fn today() -> String {
    utc_now().chars().take(10).collect()
}

/// CPU time of this process so far (user and system), where the operating system tells.
pub fn cpu_s() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // Fields 14 and 15 in clock ticks; the name in field 2 may hold spaces, so count from its closing bracket.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    const TICKS_PER_S: f64 = 100.0; // USER_HZ, fixed in the Linux ABI
    Some((user + system) / TICKS_PER_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_before_1970_or_after_9999_has_a_name_and_panics_nobody() {
        let epoch = SystemTime::UNIX_EPOCH;
        for (at, name) in [
            (epoch - Duration::from_secs(86_400), "1970-01-01T00:00:00Z"),
            (epoch + Duration::from_secs(86_400), "1970-01-02T00:00:00Z"),
            (epoch + Duration::from_secs(2 * LAST_S), "9999-12-31T23:59:59Z"),
        ] {
            assert_eq!(rfc3339(at), name);
        }
    }
}
