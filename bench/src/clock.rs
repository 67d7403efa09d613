//! The only file that reads a clock or sleeps.
//!
//! Everything else is handed the time since the start of the run as a [`Duration`].
#![allow(clippy::disallowed_methods)]

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{Duration, Instant, SystemTime};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rustix::io::Errno;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

/// Where the loop's time comes from.
#[derive(Clone, Debug)]
pub enum Clock {
    /// Time passes as fast as it is computed.
    Virtual,
    /// Virtual time in which some ticks come late, as on a busy computer: for trials and tests.
    Late(Lateness),
    /// Time passes by itself.
    Real(RealTime),
}

/// Time since the start of a run by the monotonic clock of the kernel, shifted by what a bus asks for. All copies of a clock
/// are shifted together.
#[derive(Clone, Debug)]
pub struct RealTime {
    /// The kernel's clock at the start of the run.
    start: Duration,
    /// So much later than by the kernel's clock alone every instant of the run comes.
    phase_ns: Arc<AtomicI64>,
}

impl RealTime {
    fn starts_now() -> Self {
        Self { start: read(ClockId::Monotonic), phase_ns: Arc::default() }
    }

    /// Start of the run on the kernel's clock, shifted by the phase.
    fn zero(&self) -> Duration {
        let phase_ns = self.phase_ns.load(Ordering::Relaxed);
        let phase = Duration::from_nanos(phase_ns.unsigned_abs());
        if phase_ns < 0 { self.start.saturating_sub(phase) } else { self.start + phase }
    }

    fn wait_until(&self, due: Duration) -> Duration {
        let zero = self.zero();
        let deadline = zero + due;
        while read(ClockId::Monotonic) < deadline {
            match clock_nanosleep_absolute(ClockId::Monotonic, &timespec(deadline)) {
                Ok(()) | Err(Errno::INTR) => {}
                // A kernel without absolute sleeping: a relative one comes later, but it comes.
                Err(_) => std::thread::sleep(deadline.saturating_sub(read(ClockId::Monotonic))),
            }
        }
        read(ClockId::Monotonic).saturating_sub(zero)
    }
}

fn read(clock: ClockId) -> Duration {
    let now = clock_gettime(clock);
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).unwrap_or(0))
}

fn timespec(at: Duration) -> Timespec {
    Timespec { tv_sec: i64::try_from(at.as_secs()).unwrap_or(i64::MAX), tv_nsec: at.subsec_nanos().into() }
}

/// Which ticks of a virtual clock come late, and by how much. It follows from the seed and the time at which a tick is
/// due: two runs with the same seed miss the same periods, whatever happens in them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lateness {
    /// Seed of the schedule.
    pub seed: u64,
    /// Period of the loop.
    pub period: Duration,
    /// Ticks that are due before this time are on time.
    pub from: Duration,
    /// Ticks that are due at this time or later are on time.
    pub until: Duration,
    /// One tick in so many comes late, on average; 1 makes every tick late, 0 none.
    pub one_in: u32,
    /// Fewest and most periods by which a late tick comes late; the number is drawn anew for each.
    pub periods: [u32; 2],
}

impl Lateness {
    /// How much later than `due` a tick comes.
    pub fn delay(&self, due: Duration) -> Duration {
        if due < self.from || due >= self.until || self.one_in == 0 || self.period.is_zero() {
            return Duration::ZERO;
        }
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_word_pos(2 * (due.as_nanos() / self.period.as_nanos()));
        let chance = random.next_u32();
        let size = random.next_u32();
        if !chance.is_multiple_of(self.one_in) {
            return Duration::ZERO;
        }
        let [fewest, most] = self.periods;
        let span = u64::from(most.saturating_sub(fewest)) + 1;
        let drawn = (u64::from(size) % span) as u32;
        self.period * fewest.saturating_add(drawn)
    }
}

impl Clock {
    /// A real clock that starts now.
    pub fn real() -> Self {
        Self::Real(RealTime::starts_now())
    }

    /// Whether time passes as fast as it is computed and every tick is on time.
    pub fn is_virtual(&self) -> bool {
        matches!(self, Self::Virtual)
    }

    /// Shifts the run's time, so that from the next wait on every tick comes later by so many nanoseconds, or earlier by a
    /// negative number. A bus with a clock of its own keeps the loop in phase with it by that. The shift of one tick must be small
    /// against a period: the time of the run would go back otherwise. Virtual time has no phase.
    pub fn nudge(&self, later_ns: i64) {
        if let Self::Real(real) = self {
            real.phase_ns.fetch_add(later_ns, Ordering::Relaxed);
        }
    }

    /// So many nanoseconds later than by the kernel's clock alone every tick comes: the sum of all shifts.
    pub fn phase_ns(&self) -> i64 {
        match self {
            Self::Real(real) => real.phase_ns.load(Ordering::Relaxed),
            Self::Virtual | Self::Late(_) => 0,
        }
    }

    /// Time since the start of the run; 0 on a virtual clock, whose time is the caller's.
    pub fn now(&self) -> Duration {
        match self {
            Self::Virtual | Self::Late(_) => Duration::ZERO,
            Self::Real(real) => read(ClockId::Monotonic).saturating_sub(real.zero()),
        }
    }

    /// How much later than `other` this clock was started; 0 on a virtual clock.
    pub fn started_after(&self, other: &Self) -> Duration {
        match (self, other) {
            (Self::Real(own), Self::Real(other)) => own.start.saturating_sub(other.start),
            _ => Duration::ZERO,
        }
    }

    /// Waits until `due` and returns the time then; a virtual clock is there at once, and on time unless it is told to be
    /// late.
    pub fn wait_until(&self, due: Duration) -> Duration {
        match self {
            Self::Virtual => due,
            Self::Late(lateness) => due + lateness.delay(due),
            Self::Real(real) => real.wait_until(due),
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

/// This thread gives way to every other one from now on, as far as the operating system lets it.
pub fn give_way() {
    const LOWEST: i32 = 19;
    // On Linux no process means the calling thread. Where that is refused it only runs on as before.
    let _ = rustix::process::setpriority_process(None, LOWEST);
}

/// This process gives way to threads that tick, and still comes before those of [`give_way`].
pub fn give_way_a_little() {
    const BELOW_ORDINARY: i32 = 5;
    let _ = rustix::process::setpriority_process(None, BELOW_ORDINARY);
}

/// How long ago something was, the time that the computer slept counted: whoever secured an area and closed the lid has
/// not secured it for the next morning.
#[derive(Clone, Copy, Debug)]
pub struct Age(Duration);

impl Age {
    /// Starts now.
    pub fn start() -> Self {
        Self(since_boot())
    }

    /// Seconds since the start.
    pub fn elapsed_s(&self) -> f64 {
        since_boot().saturating_sub(self.0).as_secs_f64()
    }
}

/// Time since the computer was started, suspend counted where the operating system tells.
fn since_boot() -> Duration {
    #[cfg(target_os = "linux")]
    const CLOCK: ClockId = ClockId::Boottime;
    #[cfg(not(target_os = "linux"))]
    const CLOCK: ClockId = ClockId::Monotonic;
    read(CLOCK)
}

/// Computes for so long without giving way: the work of a tick, where a loop is measured without one.
pub fn work(time: Duration) {
    let end = read(ClockId::Monotonic) + time;
    while read(ClockId::Monotonic) < end {
        std::hint::spin_loop();
    }
}

/// A rest for a thread that waits for orders.
pub fn rest(time: Duration) {
    std::thread::sleep(time);
}

/// A short rest for a thread that waits on a ring.
pub fn nap() {
    std::thread::sleep(Duration::from_micros(200));
}

/// Wall clock in nanoseconds since 1970 (UTC), for the times of frames in files of other programs.
pub fn unix_ns() -> u64 {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since_1970.as_nanos()).unwrap_or(u64::MAX)
}

/// The same in words, RFC 3339 with nanoseconds.
pub fn utc_of(unix_ns: u64) -> String {
    humantime::format_rfc3339_nanos(SystemTime::UNIX_EPOCH + Duration::from_nanos(unix_ns)).to_string()
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

/// Today in UTC, `2026-11-22`: what calibrations are compared with.
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

    const PERIOD: Duration = Duration::from_micros(250);

    fn lateness(seed: u64) -> Lateness {
        let from = Duration::from_secs(1);
        let until = Duration::from_secs(3);
        Lateness { seed, period: PERIOD, from, until, one_in: 20, periods: [1, 8] }
    }

    fn delays(seed: u64) -> Vec<u32> {
        let clock = Clock::Late(lateness(seed));
        let late = |due: Duration| (clock.wait_until(due) - due).as_nanos() / PERIOD.as_nanos();
        (0..16_000_u32).map(|tick| late(tick * PERIOD) as u32).collect()
    }

    #[test]
    fn a_late_clock_misses_as_many_periods_as_it_is_told_to_and_none_outside_its_time() {
        let delays = delays(7);
        assert!(delays[..4000].iter().chain(&delays[12_000..]).all(|&periods| periods == 0));
        let late: Vec<u32> = delays[4000..12_000].iter().copied().filter(|&periods| periods > 0).collect();
        assert!((300..500).contains(&late.len()), "one in 20 of 8000 ticks: {}", late.len());
        assert_eq!((late.iter().min(), late.iter().max()), (Some(&1), Some(&8)));
    }

    #[test]
    fn a_seed_stands_for_one_schedule() {
        assert_eq!(delays(7), delays(7));
        assert_ne!(delays(7), delays(8));
    }

    #[test]
    fn a_single_tick_can_be_made_late_by_an_exact_number_of_periods() {
        let from = Duration::from_secs(2);
        let clock =
            Clock::Late(Lateness { from, until: from + PERIOD, one_in: 1, periods: [32; 2], ..lateness(0) });
        assert_eq!(clock.wait_until(from - PERIOD), from - PERIOD);
        assert_eq!(clock.wait_until(from), from + 32 * PERIOD);
        assert_eq!(clock.wait_until(from + 33 * PERIOD), from + 33 * PERIOD);
    }

    #[test]
    fn a_real_clock_wakes_nobody_before_a_tick_is_due_and_never_goes_back() {
        let clock = Clock::real();
        let mut before = Duration::ZERO;
        for tick in 1..20 {
            let due = tick * Duration::from_micros(500);
            let now = clock.wait_until(due);
            assert!(now >= due && now >= before, "{now:?} for {due:?} after {before:?}");
            before = now;
        }
    }

    #[test]
    fn a_nudged_clock_is_late_by_the_sum_of_its_shifts_for_all_who_share_it() {
        let clock = Clock::real();
        let shared = clock.clone();
        let unshifted = Clock::Real(RealTime {
            phase_ns: Arc::default(),
            ..match &clock {
                Clock::Real(real) => real.clone(),
                _ => unreachable!("it was made as a real clock"),
            }
        });
        clock.nudge(3_000_000);
        clock.nudge(-1_000_000);
        assert_eq!(shared.phase_ns(), 2_000_000);
        shared.wait_until(Duration::from_millis(5));
        let now = unshifted.wait_until(Duration::ZERO);
        assert!(now >= Duration::from_millis(7), "{now:?}");
        Clock::Virtual.nudge(5);
        assert_eq!(Clock::Virtual.phase_ns(), 0);
    }

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
