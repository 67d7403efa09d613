//! Keeps a loop in phase with a clock that is not its own, such as the SYNC0 pulses of an EtherCAT segment.

use std::time::Duration;

/// A controller that turns a measured lateness of each tick into small shifts of the loop's time
/// ([`Clock::nudge`](crate::clock::Clock::nudge)).
///
/// It is a proportional and an integral part, critically damped: a wrong phase is gone after some hundred ticks, and a clock
/// that runs faster or slower than the loop's leaves no offset. A shift is at most 1/256 of a period, 3900 ppm: clocks differ
/// by a hundredth of that, and a single tick that came late shifts little.
#[derive(Clone, Copy, Debug)]
pub struct PhaseLock {
    period_ns: f64,
    /// Shift for each tick that makes up for the difference of the clocks.
    drift_ns: f64,
    /// Part of a shift that is less than a nanosecond.
    rest_ns: f64,
}

/// Share of the offset that is taken away in a tick.
const PROPORTIONAL: f64 = 1.0 / 32.0;
/// Critical damping.
const INTEGRAL: f64 = PROPORTIONAL * PROPORTIONAL / 4.0;
/// Largest difference of two clocks that is believed, 200 ppm: quartz oscillators differ by less.
const MOST_DRIFT: f64 = 2e-4;
/// Largest shift in a tick, as a share of the period.
const MOST: f64 = 1.0 / 256.0;

impl PhaseLock {
    /// Of a loop with this period.
    pub fn new(period: Duration) -> Self {
        Self { period_ns: period.as_secs_f64() * 1e9, drift_ns: 0.0, rest_ns: 0.0 }
    }

    /// A tick took place so many nanoseconds after its instant by the other clock, or before it by a negative number: gives by
    /// how many nanoseconds later the ticks must come from the next one on. Lateness of more than half a period counts as
    /// earliness: it is the nearer instant that matters.
    pub fn step(&mut self, late_ns: i64) -> i64 {
        let half_ns = 0.5 * self.period_ns;
        let late_ns = (late_ns as f64 + half_ns).rem_euclid(self.period_ns) - half_ns;
        let most_ns = MOST * self.period_ns;
        let wanted_ns = -PROPORTIONAL * late_ns + self.drift_ns;
        let shift_ns = wanted_ns.clamp(-most_ns, most_ns);
        if shift_ns == wanted_ns {
            let most_drift_ns = MOST_DRIFT * self.period_ns;
            self.drift_ns = (self.drift_ns - INTEGRAL * late_ns).clamp(-most_drift_ns, most_drift_ns);
        }
        let exact_ns = shift_ns + self.rest_ns;
        self.rest_ns = exact_ns - exact_ns.round();
        exact_ns.round() as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(1);

    /// Offsets of ticks of 1 ms against a clock that differs by so many ppm, from this one on; every 100th is seen `jitter_ns` later.
    fn offsets(start_ns: f64, ppm: f64, jitter_ns: i64, ticks: u32) -> Vec<f64> {
        let mut lock = PhaseLock::new(PERIOD);
        let mut offset_ns = start_ns;
        let mut tick = |k: u32| {
            let seen_ns = offset_ns.round() as i64 + if k.is_multiple_of(100) { jitter_ns } else { 0 };
            offset_ns += ppm + lock.step(seen_ns) as f64; // 1 ppm of 1 ms is 1 ns
            offset_ns
        };
        (0..ticks).map(&mut tick).collect()
    }

    fn largest(offsets: &[f64]) -> f64 {
        offsets.iter().fold(0.0, |most: f64, offset| most.max(offset.abs()))
    }

    #[test]
    fn a_clock_that_drifts_by_100_ppm_is_followed_without_an_offset() {
        for ppm in [-100.0, 0.0, 100.0] {
            let settled = offsets(0.0, ppm, 0, 4000);
            let end = largest(&settled[2000..]);
            assert!(end < 2.0, "{ppm} ppm: {end} ns");
        }
    }

    #[test]
    fn the_wrong_half_of_a_period_is_gone_within_a_second() {
        for start_ns in [-400_000.0, 400_000.0, 499_000.0] {
            let offsets = offsets(start_ns, 20.0, 0, 1000);
            let end = largest(&offsets[900..]);
            assert!(end < 10.0, "from {start_ns} ns: {end} ns");
        }
    }

    #[test]
    fn the_nearer_instant_is_taken() {
        let mut lock = PhaseLock::new(PERIOD);
        assert!(lock.step(900_000) > 0, "0.9 periods late is 0.1 periods early");
        let mut lock = PhaseLock::new(PERIOD);
        assert!(lock.step(-900_000) < 0);
    }

    #[test]
    fn a_shift_is_small_and_single_late_ticks_change_little() {
        let mut lock = PhaseLock::new(PERIOD);
        assert_eq!(lock.step(500_000 - 1), -3906, "a 256th of a period");
        let disturbed = offsets(0.0, 50.0, 300_000, 6000);
        let end = largest(&disturbed[4000..]);
        assert!(end < 20_000.0, "{end} ns");
    }
}
