//! The clock of a camera, laid onto that of the loop by the arrivals of its messages.
//!
//! A camera stamps its frames with a clock of its own: it began at another time, and it runs a little faster or slower.
//! Arrival minus stamp is a constant, plus the drift, plus what a message waited on its way. The waiting is never
//! negative, so the line below all of these differences is that of the messages which did not wait (Moon, Skelly &
//! Towsley, Estimation and removal of clock skew from network delay measurements, INFOCOM 1999). The constant is the
//! difference of the clocks plus the delay from an exposure to its message: arrivals cannot tell these two apart, so
//! that the delay is declared, with its uncertainty.

use std::time::Duration;

/// Least differences that are kept, one a block.
const BLOCKS: usize = 32;
/// Length of a block on the camera's clock.
const BLOCK_NS: i64 = 1_000_000_000;
/// A drift is believed from this many blocks on; before, arrivals that are seen with ticks of 1 ms tell 100 ppm from
/// nothing at all.
const LEAST_BLOCKS: i64 = 10;
/// Blocks whose least difference counts while the drift is not known.
const RECENT_BLOCKS: usize = 2;
/// Drift of a crystal oscillator without compensation at the most.
const MOST_DRIFT_RATIO: f64 = 100e-6;
/// A stamp that is off by more is of a clock that was set anew, or of a camera that was started again: no network keeps a
/// message that long.
const LEAP_NS: i64 = 500_000_000;

/// Delay from the middle of an exposure to the arrival of its message, as declared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeclaredDelay {
    /// The shortest, s.
    pub delay_s: f64,
    /// Standard uncertainty of `delay_s`, s.
    pub u_s: f64,
}

/// Where a stamp lies on the loop's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placed {
    /// Middle of the exposure; 0 for one before the clock began.
    pub exposure: Duration,
    /// Standard uncertainty of `exposure`, s, as far as arrivals make it: of the polling, and of a drift that is not known yet. That of
    /// the declared delay comes on top, for all exposures alike.
    pub u_s: f64,
    /// Rate of the camera's clock over that of the loop, less 1; 0 while it is not known.
    pub drift_ratio: f64,
}

/// The least difference of a block.
#[derive(Clone, Copy, Debug, Default)]
struct Least {
    stamp_ns: i64,
    difference_ns: i64,
}

/// A straight line below the differences.
#[derive(Clone, Copy, Debug)]
struct Line {
    from: Least,
    slope: f64,
    is_drift_known: bool,
}

impl Line {
    fn at(&self, stamp_ns: i64) -> i64 {
        let ahead_ns = (stamp_ns - self.from.stamp_ns) as f64;
        self.from.difference_ns.saturating_add((self.slope * ahead_ns).round() as i64)
    }
}

/// The clock of one camera.
#[derive(Clone, Debug)]
pub struct CameraClock {
    declared_ns: i64,
    poll_period_ns: i64,
    /// A ring of blocks, in the order of their stamps from `first` on.
    blocks: [Least; BLOCKS],
    first: usize,
    count: usize,
    newest_ns: i64,
}

impl CameraClock {
    /// A clock of which nothing is known yet, behind a port that is polled once in this time.
    pub fn new(declared: DeclaredDelay, poll_period: Duration) -> Self {
        let declared_ns = (1e9 * declared.delay_s).round() as i64;
        let poll_period_ns = nanoseconds(poll_period);
        let blocks = [Least::default(); BLOCKS];
        Self { declared_ns, poll_period_ns, blocks, first: 0, count: 0, newest_ns: 0 }
    }

    /// Whether a stamp follows the newest one: later on the camera's clock, or so far off that the clock was set anew.
    pub fn follows(&self, stamp: Duration) -> bool {
        let stamp_ns = nanoseconds(stamp);
        self.count == 0 || stamp_ns > self.newest_ns || stamp_ns < self.newest_ns - LEAP_NS
    }

    /// Takes the stamp of a message that the poll of `now` has found, and lays it onto the clock of the loop.
    pub fn place(&mut self, stamp: Duration, now: Duration) -> Placed {
        let stamp_ns = nanoseconds(stamp);
        let seen_ns = nanoseconds(now);
        let found = Least { stamp_ns, difference_ns: seen_ns - stamp_ns };
        if stamp_ns <= self.newest_ns || self.is_set_anew(found) {
            self.count = 0;
        }
        self.newest_ns = stamp_ns;
        self.insert(found);
        let line = self.line();
        // The poll after its arrival sees a message, half a period late in the mean.
        let late_ns = self.poll_period_ns / 2 + self.declared_ns;
        let exposure_ns = line.at(stamp_ns).saturating_add(stamp_ns).saturating_sub(late_ns);
        let polling_u_s = 1e-9 * self.poll_period_ns as f64 / 12.0_f64.sqrt();
        let recent_s = 1e-9 * (RECENT_BLOCKS as i64 * BLOCK_NS) as f64;
        let drift_u_s = if line.is_drift_known { 0.0 } else { MOST_DRIFT_RATIO * recent_s / 3.0_f64.sqrt() };
        Placed {
            exposure: Duration::from_nanos(u64::try_from(exposure_ns).unwrap_or(0)),
            u_s: polling_u_s.hypot(drift_u_s),
            // A clock that runs fast gets ahead of the arrivals: the differences fall.
            drift_ratio: -line.slope,
        }
    }

    fn is_set_anew(&self, found: Least) -> bool {
        let off_ns = found.difference_ns.saturating_sub(self.line().at(found.stamp_ns));
        self.count > 0 && off_ns.unsigned_abs() > LEAP_NS.unsigned_abs()
    }

    fn insert(&mut self, found: Least) {
        let block = found.stamp_ns.div_euclid(BLOCK_NS);
        let newest = self.count.checked_sub(1).map(|last| (self.first + last) % BLOCKS);
        if let Some(place) = newest
            && self.blocks[place].stamp_ns.div_euclid(BLOCK_NS) == block
        {
            if found.difference_ns < self.blocks[place].difference_ns {
                self.blocks[place] = found;
            }
            return;
        }
        if self.count == BLOCKS {
            (self.first, self.count) = ((self.first + 1) % BLOCKS, BLOCKS - 1);
        }
        self.blocks[(self.first + self.count) % BLOCKS] = found;
        self.count += 1;
    }

    fn block(&self, place: usize) -> Least {
        self.blocks[(self.first + place) % BLOCKS]
    }

    /// The line below all blocks that lies nearest to them in the mean: the edge of their lower hull above the mean of
    /// their stamps. A level one through the least of the recent blocks, while they span too little to tell a drift.
    fn line(&self) -> Line {
        let last = self.count.saturating_sub(1);
        let span_ns = self.block(last).stamp_ns - self.block(0).stamp_ns;
        if span_ns < LEAST_BLOCKS * BLOCK_NS {
            let recent = (self.count.saturating_sub(RECENT_BLOCKS)..self.count).map(|k| self.block(k));
            let from = recent.min_by_key(|least| least.difference_ns).unwrap_or_default();
            return Line { from, slope: 0.0, is_drift_known: false };
        }
        let first_ns = self.block(0).stamp_ns;
        let ahead = |k: usize| (self.block(k).stamp_ns - first_ns) as f64;
        let mean_ns = (0..self.count).map(ahead).sum::<f64>() / self.count as f64;
        let mut from = 0;
        loop {
            let (to, slope) = self.next_corner(from);
            if to == last || ahead(to) >= mean_ns {
                return Line { from: self.block(from), slope, is_drift_known: true };
            }
            from = to;
        }
    }

    /// The corner of the lower hull after one of them, and the slope of the edge that leads to it.
    fn next_corner(&self, from: usize) -> (usize, f64) {
        let here = self.block(from);
        let slope = |k: usize| {
            let there = self.block(k);
            (there.difference_ns - here.difference_ns) as f64 / (there.stamp_ns - here.stamp_ns) as f64
        };
        // Of corners on one line the last.
        (from + 2..self.count).map(|k| (k, slope(k))).fold((from + 1, slope(from + 1)), |least, corner| {
            if corner.1 <= least.1 { corner } else { least }
        })
    }
}

fn nanoseconds(time: Duration) -> i64 {
    i64::try_from(time.as_nanos()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Messages of a camera with this drift, whose clock began 5000 s before the loop's: true exposure and what the clock is
    /// asked to make of it, at 200 frames/s with a delay of 7.5 ms, polled with 4 kHz. `waits` says what a message waits.
    fn played(
        drift_ratio: f64,
        seconds: u64,
        declared_s: f64,
        waits_ns: impl Fn(u64) -> u64,
    ) -> Vec<(f64, Placed)> {
        let declared = DeclaredDelay { delay_s: declared_s, u_s: 0.2e-3 };
        let poll_ns = 250_000;
        let frame_ns = 5_000_130;
        let mut clock = CameraClock::new(declared, Duration::from_nanos(poll_ns));
        (0..200 * seconds)
            .map(|frame| {
                let exposure_ns = frame * frame_ns;
                let stamp_ns = 5_000_000_000_000 + exposure_ns + (exposure_ns as f64 * drift_ratio) as u64;
                let arrival_ns = exposure_ns + 7_500_000 + waits_ns(frame);
                let now = Duration::from_nanos(arrival_ns.div_ceil(poll_ns) * poll_ns);
                let stamp = Duration::from_nanos(stamp_ns);
                assert!(clock.follows(stamp));
                (1e-9 * exposure_ns as f64, clock.place(stamp, now))
            })
            .collect()
    }

    /// Largest error of the exposures from a time on.
    fn largest_error_s(played: &[(f64, Placed)], from_s: f64) -> f64 {
        let errors = played.iter().filter(|(true_s, _)| *true_s >= from_s);
        errors.map(|(true_s, placed)| (placed.exposure.as_secs_f64() - true_s).abs()).fold(0.0, f64::max)
    }

    /// Half a period of the polling, and what a drift of 100 ppm makes within two seconds while it is not known.
    #[test]
    fn exposures_stand_on_the_loop_s_clock_within_the_time_between_two_polls_whatever_the_drift() {
        for drift_ratio in [0.0, 12e-6, -8e-6, 100e-6] {
            let played = played(drift_ratio, 60, 7.5e-3, |_| 0);
            assert!(largest_error_s(&played, 0.0) < 125e-6 + 205e-6, "{drift_ratio}");
            assert!(
                largest_error_s(&played, 15.0) < 150e-6,
                "{drift_ratio}: {}",
                largest_error_s(&played, 15.0)
            );
            let found = played.last().expect("frames").1.drift_ratio;
            assert!((found - drift_ratio).abs() < 8e-6, "{drift_ratio}: {found}");
        }
    }

    /// Of a thousand messages one waits for nothing; the others up to 30 ms, and for three seconds all of them at least 5 ms.
    #[test]
    fn messages_that_wait_on_their_way_change_neither_exposures_nor_drift() {
        let waits = |frame: u64| match frame.wrapping_mul(2_654_435_761) % 1000 {
            _ if (4000..4600).contains(&frame) => 5_000_000,
            0..20 => 0,
            part => 30_000 * part,
        };
        let played = played(20e-6, 60, 7.5e-3, waits);
        assert!(largest_error_s(&played, 15.0) < 300e-6, "{}", largest_error_s(&played, 15.0));
        let found = played.last().expect("frames").1.drift_ratio;
        assert!((found - 20e-6).abs() < 10e-6, "{found}");
    }

    #[test]
    fn a_delay_that_is_declared_wrongly_shifts_every_exposure_by_what_it_is_wrong_and_no_arrival_tells() {
        let right = played(12e-6, 20, 7.5e-3, |_| 0);
        let wrong = played(12e-6, 20, 5.5e-3, |_| 0);
        for ((_, right), (_, wrong)) in right.iter().zip(&wrong) {
            let later_s = wrong.exposure.as_secs_f64() - right.exposure.as_secs_f64();
            assert!((later_s - 2e-3).abs() < 2e-9 || right.exposure.is_zero(), "{later_s}");
            assert_eq!(right.u_s, wrong.u_s);
        }
    }

    #[test]
    fn the_uncertainty_holds_the_polling_and_a_drift_that_is_not_known_yet() {
        let played = played(0.0, 20, 7.5e-3, |_| 0);
        let polling_s = 250e-6 / 12.0_f64.sqrt();
        let first = played[0].1;
        let last = played.last().expect("frames").1;
        assert!((last.u_s - polling_s).abs() < 1e-9, "{}", last.u_s);
        assert!((first.u_s - polling_s.hypot(200e-6 / 3.0_f64.sqrt())).abs() < 1e-9, "{}", first.u_s);
    }

    #[test]
    fn a_clock_that_was_set_anew_is_followed_at_once() {
        let mut clock = CameraClock::new(DeclaredDelay { delay_s: 0.0, u_s: 0.0 }, Duration::ZERO);
        let at = Duration::from_millis;
        for frame in 0..100 {
            clock.place(at(90_000 + 20 * frame), at(20 * frame));
        }
        assert!(!clock.follows(at(91_900)), "a message that came twice");
        assert!(clock.follows(at(5)), "the camera was started again");
        assert_eq!(clock.place(at(5), at(3000)).exposure, at(3000));
        assert_eq!(clock.place(at(3_600_000), at(3020)).exposure, at(3020));
    }

    proptest! {
        /// What stands in a message is not ours: any stamp gives a time, and no panic.
        #[test]
        fn any_stamps_are_placed(
            stamps_ns in prop::collection::vec(prop_oneof![any::<u64>(), 0..100_000_000_000_u64], 1..200),
            polls_ms in prop::collection::vec(0..2000_u64, 200),
        ) {
            let declared = DeclaredDelay { delay_s: 7.5e-3, u_s: 0.0 };
            let mut clock = CameraClock::new(declared, Duration::from_micros(250));
            let mut now = Duration::ZERO;
            for (stamp_ns, poll_ms) in stamps_ns.into_iter().zip(polls_ms) {
                now += Duration::from_millis(poll_ms);
                let stamp = Duration::from_nanos(stamp_ns);
                if clock.follows(stamp) {
                    let placed = clock.place(stamp, now);
                    prop_assert!(placed.drift_ratio.is_finite() && placed.u_s.is_finite());
                }
            }
        }
    }
}
