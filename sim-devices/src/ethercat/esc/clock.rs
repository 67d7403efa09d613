//! Distributed clocks: local time, system time, its control, and the SYNC0 pulses (ETG.1000.4, 6.9).
//!
//! Local time is the time of the world, off by a rate error and a phase. A SubDevice behind the reference clock is slewed
//! towards the time that it receives.

use std::time::Duration;

use super::registers::{
    PORT_TIMES, RECEIVE_TIME, SPEED_START, SYNC_ACTIVATION, SYNC_START, SYNC0_CYCLE, SYSTEM_TIME, TIME_DELAY,
    TIME_DIFFERENCE, TIME_OFFSET,
};

/// Share of a measured difference that is taken out at once.
const GAIN: f64 = 0.25;
/// Most that a clock is slewed, against the time that has passed: a tick of 9 or 11 ns instead of 10.
const MAX_SLEW_RATIO: f64 = 0.1;
/// A larger difference is a time that was never set, and nothing to follow.
const LARGEST_DIFFERENCE_NS: u64 = 1_000_000_000;
/// Local copy smaller than the received time.
const SMALLER: u32 = 1 << 31;
/// SYNC outputs active, SYNC0 generated.
const SYNC0_ACTIVE: u8 = 0b11;

/// How far a clock is off when nobody corrects it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ClockError {
    /// Rate error, parts per million.
    pub(crate) rate_ppm: f64,
    /// Time that it shows at the start.
    pub(crate) phase_ns: i64,
}

/// Local time of a SubDevice and what is derived from it.
#[derive(Clone, Debug)]
pub(crate) struct Clock {
    error: ClockError,
    slewed_ns: f64,
    compared_at: Option<Duration>,
    /// Start time of SYNC0 where it was still to come when SYNC0 was activated.
    sync0: Option<Pulses>,
    /// SYNC0 fails from now on.
    sync0_is_lost: bool,
}

/// A pulse of SYNC0. Its instant is reckoned back by a clock that is not the world's and may be corrected meanwhile, so that only
/// the number says whether two pulses are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sync0Pulse {
    /// Start of the pulses in system time, ns.
    pub(crate) start_ns: u64,
    /// Cycles since the start time.
    pub(crate) number: u64,
    /// Instant of the world.
    pub(crate) at: Duration,
}

/// A train of pulses in system time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pulses {
    start_ns: u64,
    cycle_ns: u32,
}

impl Clock {
    /// A clock with this error.
    pub(crate) fn new(error: ClockError) -> Self {
        Self { error, slewed_ns: 0.0, compared_at: None, sync0: None, sync0_is_lost: false }
    }

    /// Local time.
    pub(crate) fn local_ns(&self, now: Duration) -> u64 {
        let true_ns = now.as_nanos() as u64;
        let gained_ns = true_ns as f64 * self.error.rate_ppm * 1e-6 + self.slewed_ns;
        true_ns.wrapping_add_signed(self.error.phase_ns).wrapping_add_signed(gained_ns.round() as i64)
    }

    /// System time: local time plus the offset that the MainDevice wrote.
    pub(crate) fn system_ns(&self, memory: &[u8], now: Duration) -> u64 {
        self.local_ns(now).wrapping_add(read_u64(memory, TIME_OFFSET))
    }

    /// Puts the system time and that of the next SYNC0 into their registers.
    pub(crate) fn show(&self, memory: &mut [u8], now: Duration) {
        let system = self.system_ns(memory, now);
        put(memory, SYSTEM_TIME, &system.to_le_bytes());
        if let Some(Pulses { start_ns, cycle_ns }) = self.sync0 {
            let passed = system.checked_sub(start_ns).map_or(0, |since| since / u64::from(cycle_ns) + 1);
            let next = start_ns.saturating_add(passed.saturating_mul(u64::from(cycle_ns)));
            put(memory, SYNC_START, &next.to_le_bytes());
        }
    }

    /// A write to 0900h: receive times at the ports. The frame came in at port 0 at `now`, and comes back to port 1 after
    /// `behind_ns`; a SubDevice with nothing behind it has no time at port 1.
    pub(crate) fn latch(&mut self, memory: &mut [u8], now: Duration, behind_ns: u32) {
        let local = self.local_ns(now);
        let there = local as u32;
        let back = if behind_ns > 0 { there.wrapping_add(behind_ns) } else { 0 };
        put(memory, PORT_TIMES, &there.to_le_bytes());
        put(memory, PORT_TIMES + 4, &back.to_le_bytes());
        put(memory, PORT_TIMES + 8, &[0; 8]);
        put(memory, RECEIVE_TIME, &local.to_le_bytes());
    }

    /// The system time of the reference clock passes by: the local one moves towards it.
    pub(crate) fn compare(&mut self, memory: &mut [u8], now: Duration, received_ns: u64, is_whole: bool) {
        let delay = read_u32(memory, TIME_DELAY);
        let own = self.system_ns(memory, now);
        let received = received_ns.wrapping_add(u64::from(delay));
        let difference = if is_whole {
            received.wrapping_sub(own) as i64
        } else {
            i64::from((received as u32).wrapping_sub(own as u32) as i32)
        };
        let size = difference.unsigned_abs().min(u64::from(SMALLER - 1)) as u32;
        let shown = if difference > 0 { size | SMALLER } else { size };
        put(memory, TIME_DIFFERENCE, &shown.to_le_bytes());
        let passed_s = self.compared_at.map(|before| now.saturating_sub(before).as_secs_f64());
        self.compared_at = Some(now);
        if difference.unsigned_abs() < LARGEST_DIFFERENCE_NS
            && let Some(passed_s) = passed_s
        {
            let most_ns = passed_s * 1e9 * MAX_SLEW_RATIO;
            self.slewed_ns += (difference as f64 * GAIN).clamp(-most_ns, most_ns);
        }
    }

    /// Registers of the clock were written.
    pub(crate) fn written(&mut self, memory: &mut [u8], first: u16, count: usize, now: Duration) {
        let touches = |register: u16| {
            usize::from(first) <= usize::from(register) && usize::from(register) < usize::from(first) + count
        };
        if touches(SPEED_START) {
            put(memory, TIME_DIFFERENCE, &[0; 4]);
        }
        if touches(SYNC_ACTIVATION) {
            let is_active = memory[usize::from(SYNC_ACTIVATION)] & SYNC0_ACTIVE == SYNC0_ACTIVE;
            let cycle_ns = read_u32(memory, SYNC0_CYCLE);
            let start_ns = self.start_ns(memory, now);
            let is_to_come = start_ns > self.system_ns(memory, now);
            self.sync0 = (is_active && is_to_come && cycle_ns > 0).then_some(Pulses { start_ns, cycle_ns });
        }
    }

    /// The start time; where only its low word was written, the next time at which the low word of the system time has it.
    fn start_ns(&self, memory: &[u8], now: Duration) -> u64 {
        let start = read_u64(memory, SYNC_START);
        let system = self.system_ns(memory, now);
        if start >> 32 != 0 || start > system {
            return start;
        }
        let ahead = (start as u32).wrapping_sub(system as u32) as i32;
        system.saturating_add_signed(i64::from(ahead))
    }

    /// The last pulse of SYNC0 at or before `now`.
    pub(crate) fn last_sync0(&self, memory: &[u8], now: Duration) -> Option<Sync0Pulse> {
        let pulses = self.sync0.filter(|_| !self.sync0_is_lost)?;
        let since_start = self.system_ns(memory, now).checked_sub(pulses.start_ns)?;
        let cycle_ns = u64::from(pulses.cycle_ns);
        let since_pulse = Duration::from_nanos(since_start % cycle_ns);
        let number = since_start / cycle_ns;
        Some(Sync0Pulse { start_ns: pulses.start_ns, number, at: now.saturating_sub(since_pulse) })
    }

    /// From one pulse to the next, as the MainDevice set it.
    pub(crate) fn sync0_cycle(&self) -> Duration {
        Duration::from_nanos(self.sync0.map_or(0, |pulses| u64::from(pulses.cycle_ns)))
    }

    /// Whether SYNC0 was activated and its start had not passed.
    pub(crate) fn gives_sync0(&self) -> bool {
        self.sync0.is_some() && !self.sync0_is_lost
    }

    /// From now on SYNC0 fails, or works again.
    pub(crate) fn lose_sync0(&mut self, lost: bool) {
        self.sync0_is_lost = lost;
    }

    /// The clock jumps.
    pub(crate) fn step(&mut self, by_ns: i64) {
        self.error.phase_ns = self.error.phase_ns.wrapping_add(by_ns);
    }

    /// The clock runs at another rate from now on, with no jump.
    pub(crate) fn drift(&mut self, rate_ppm: f64, now: Duration) {
        self.slewed_ns += now.as_nanos() as f64 * (self.error.rate_ppm - rate_ppm) * 1e-6;
        self.error.rate_ppm = rate_ppm;
    }
}

fn put(memory: &mut [u8], register: u16, bytes: &[u8]) {
    let at = usize::from(register);
    memory[at..at + bytes.len()].copy_from_slice(bytes);
}

fn read_u32(memory: &[u8], register: u16) -> u32 {
    let at = usize::from(register);
    u32::from_le_bytes(memory[at..at + 4].try_into().expect("four bytes"))
}

fn read_u64(memory: &[u8], register: u16) -> u64 {
    let at = usize::from(register);
    u64::from_le_bytes(memory[at..at + 8].try_into().expect("eight bytes"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    fn difference_ns(memory: &[u8]) -> u32 {
        read_u32(memory, TIME_DIFFERENCE) & !SMALLER
    }

    #[test]
    fn a_clock_that_is_off_by_50_ppm_follows_the_reference_to_within_a_microsecond() {
        let mut memory = vec![0; 0x1000];
        let mut clock = Clock::new(ClockError { rate_ppm: 50.0, phase_ns: 3000 });
        for k in 1..500 {
            let now = MS * k;
            clock.compare(&mut memory, now, now.as_nanos() as u64, true);
        }
        assert!(difference_ns(&memory) < 1000, "{} ns", difference_ns(&memory));
        clock.step(40_000);
        clock.compare(&mut memory, MS * 500, 500_000_000, true);
        assert!(difference_ns(&memory) > 39_000, "a jump is seen");
        assert_eq!(read_u32(&memory, TIME_DIFFERENCE) & SMALLER, 0, "the local clock is ahead");
    }

    #[test]
    fn a_clock_that_was_never_set_is_not_followed() {
        let mut memory = vec![0; 0x1000];
        let mut clock = Clock::new(ClockError::default());
        clock.compare(&mut memory, MS, 5_000_000_000, true);
        clock.compare(&mut memory, MS * 2, 5_001_000_000, true);
        assert_eq!(clock.local_ns(MS * 2), 2_000_000);
    }

    #[test]
    fn sync0_comes_at_its_start_and_then_every_cycle() {
        let mut memory = vec![0; 0x1000];
        let mut clock = Clock::new(ClockError::default());
        put(&mut memory, SYNC_START, &10_000_000_u64.to_le_bytes());
        put(&mut memory, SYNC0_CYCLE, &1_000_000_u32.to_le_bytes());
        memory[usize::from(SYNC_ACTIVATION)] = 3;
        clock.written(&mut memory, SYNC_ACTIVATION, 1, MS);
        assert_eq!(clock.last_sync0(&memory, MS * 9), None);
        let start_ns = 10_000_000;
        let pulse = |number: u64| Some(Sync0Pulse { start_ns, number, at: MS * (10 + number as u32) });
        assert_eq!(clock.last_sync0(&memory, MS * 10), pulse(0));
        assert_eq!(clock.last_sync0(&memory, Duration::from_micros(12_700)), pulse(2));
        clock.lose_sync0(true);
        assert_eq!(clock.last_sync0(&memory, MS * 20), None);
    }

    #[test]
    fn a_start_that_has_passed_gives_no_pulse() {
        let mut memory = vec![0; 0x1000];
        let mut clock = Clock::new(ClockError::default());
        put(&mut memory, SYNC_START, &10_000_000_u64.to_le_bytes());
        put(&mut memory, SYNC0_CYCLE, &1_000_000_u32.to_le_bytes());
        memory[usize::from(SYNC_ACTIVATION)] = 3;
        clock.written(&mut memory, SYNC_ACTIVATION, 1, MS * 11);
        assert!(!clock.gives_sync0());
    }

    #[test]
    fn a_change_of_rate_does_not_move_the_hands() {
        let mut clock = Clock::new(ClockError { rate_ppm: 10.0, phase_ns: 0 });
        let before = clock.local_ns(MS * 1000);
        clock.drift(-30.0, MS * 1000);
        assert_eq!(clock.local_ns(MS * 1000), before);
        assert_eq!(clock.local_ns(MS * 2000), 2_000_000_000 + 10_000 - 30_000);
    }
}
