//! How late the ticks of a loop come: a histogram of fixed size, so that a tick can count itself without allocating.

use serde::{Deserialize, Serialize};

/// Bins for each decade.
const STEPS: usize = 10;
/// Decades from 1 µs to 100 ms.
const DECADES: usize = 5;
/// Bins of a [`LatenessHistogram`]: one below 1 µs, one from 100 ms, and ten for each decade between them.
pub const LATENESS_BINS: usize = STEPS * DECADES + 2;
/// Number of the limits between bins.
const EDGES: usize = LATENESS_BINS - 1;

/// Limits between the bins, ns: preferred numbers R10 of ISO 3.
const EDGES_NS: [u64; EDGES] = edges_ns();

const fn edges_ns() -> [u64; EDGES] {
    const R10: [u64; STEPS] = [1000, 1250, 1600, 2000, 2500, 3150, 4000, 5000, 6300, 8000];
    let mut edges = [0; EDGES];
    let mut scale = 1;
    let mut k = 0;
    while k < EDGES {
        edges[k] = R10[k % STEPS] * scale;
        if k % STEPS == STEPS - 1 {
            scale *= 10;
        }
        k += 1;
    }
    edges
}

/// A stall: a tick that came so late that it missed periods of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stall {
    /// How much later the tick came than it was due.
    pub length_s: f64,
    /// Periods that were missed.
    pub missed_periods: u32,
}

/// How late the ticks of a loop came. A bin holds the ticks from its lower limit to just below its upper one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Counted", into = "Counted")]
pub struct LatenessHistogram {
    counts: [u32; LATENESS_BINS],
    missed: u64,
    longest_ns: u64,
    largest_ns: u64,
}

impl Default for LatenessHistogram {
    fn default() -> Self {
        Self { counts: [0; LATENESS_BINS], missed: 0, longest_ns: 0, largest_ns: 0 }
    }
}

impl LatenessHistogram {
    /// Counts a tick that came this late after as many missed periods. Needs neither memory nor a system call.
    pub fn count(&mut self, late: std::time::Duration, missed_periods: u32) {
        let late_ns = u64::try_from(late.as_nanos()).unwrap_or(u64::MAX);
        let bin = EDGES_NS.partition_point(|&edge_ns| edge_ns <= late_ns);
        self.counts[bin] = self.counts[bin].saturating_add(1);
        self.missed += u64::from(missed_periods);
        self.largest_ns = self.largest_ns.max(late_ns);
        if missed_periods > 0 {
            self.longest_ns = self.longest_ns.max(late_ns);
        }
    }

    /// Adds the ticks of another part of the same loop.
    pub fn add(&mut self, other: &Self) {
        for (own, more) in self.counts.iter_mut().zip(other.counts) {
            *own = own.saturating_add(more);
        }
        self.missed = self.missed.saturating_add(other.missed);
        self.longest_ns = self.longest_ns.max(other.longest_ns);
        self.largest_ns = self.largest_ns.max(other.largest_ns);
    }

    /// Ticks that came.
    pub fn ticks(&self) -> u64 {
        self.counts.iter().map(|&count| u64::from(count)).sum()
    }

    /// Periods that were missed.
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Share of all periods that were missed; 0 without a tick.
    pub fn missed_ratio(&self) -> f64 {
        let periods = self.ticks() + self.missed;
        if periods == 0 { 0.0 } else { self.missed as f64 / periods as f64 }
    }

    /// The longest stall, s; 0 where no period was missed.
    pub fn longest_stall_s(&self) -> f64 {
        self.longest_ns as f64 / 1e9
    }

    /// Largest lateness of a tick, s.
    pub fn largest_s(&self) -> f64 {
        self.largest_ns as f64 / 1e9
    }

    /// A lateness, s, that at least this share of the ticks did not exceed: the upper limit of the bin in which the quantile lies,
    /// or the largest lateness where that is less. `None` without a tick.
    pub fn quantile_s(&self, share: f64) -> Option<f64> {
        let needed = (share.clamp(0.0, 1.0) * self.ticks() as f64).ceil().max(1.0) as u64;
        let mut below = 0;
        let bin = self.counts.iter().position(|&count| {
            below += u64::from(count);
            below >= needed
        })?;
        let upper_ns = EDGES_NS.get(bin).copied().unwrap_or(u64::MAX);
        Some(upper_ns.min(self.largest_ns) as f64 / 1e9)
    }

    /// Each bin from the shortest lateness to the longest: its limits, s, and its ticks. The first begins at 0, the last has no end.
    pub fn bins(&self) -> impl Iterator<Item = ([f64; 2], u32)> + '_ {
        let edge_s = |k: Option<&u64>, none_s: f64| k.map_or(none_s, |&edge_ns| edge_ns as f64 / 1e9);
        self.counts.iter().enumerate().map(move |(bin, &count)| {
            let from_s = edge_s(bin.checked_sub(1).and_then(|k| EDGES_NS.get(k)), 0.0);
            ([from_s, edge_s(EDGES_NS.get(bin), f64::INFINITY)], count)
        })
    }
}

/// A histogram as it stands in files.
#[derive(Serialize, Deserialize)]
struct Counted {
    ticks: u64,
    missed_periods: u64,
    longest_stall_s: f64,
    largest_s: f64,
    /// Ticks of each bin.
    counts: Vec<u32>,
}

impl From<LatenessHistogram> for Counted {
    fn from(histogram: LatenessHistogram) -> Self {
        Self {
            ticks: histogram.ticks(),
            missed_periods: histogram.missed,
            longest_stall_s: histogram.longest_stall_s(),
            largest_s: histogram.largest_s(),
            counts: histogram.counts.to_vec(),
        }
    }
}

impl TryFrom<Counted> for LatenessHistogram {
    type Error = String;

    fn try_from(counted: Counted) -> Result<Self, String> {
        let found = counted.counts.len();
        let counts = counted
            .counts
            .try_into()
            .map_err(|_| format!("a lateness histogram has {LATENESS_BINS} bins, found {found}"))?;
        let ns = |time_s: f64| (1e9 * time_s).round().max(0.0) as u64;
        Ok(Self {
            counts,
            missed: counted.missed_periods,
            longest_ns: ns(counted.longest_stall_s),
            largest_ns: ns(counted.largest_s),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn of_microseconds(late_us: &[u64]) -> LatenessHistogram {
        let mut histogram = LatenessHistogram::default();
        late_us.iter().for_each(|&late_us| histogram.count(Duration::from_micros(late_us), 0));
        histogram
    }

    #[test]
    fn a_tick_falls_into_the_bin_whose_lower_limit_it_reaches() {
        let limits = |late: Duration| {
            let mut histogram = LatenessHistogram::default();
            histogram.count(late, 0);
            histogram.bins().find(|(_, count)| *count == 1).map(|(limits, _)| limits).expect("it is counted")
        };
        assert_eq!(limits(Duration::ZERO), [0.0, 1e-6]);
        assert_eq!(limits(Duration::from_nanos(999)), [0.0, 1e-6]);
        assert_eq!(limits(Duration::from_micros(1))[0], 1e-6);
        let [from_s, to_s] = limits(Duration::from_micros(70));
        assert!((from_s - 63e-6).abs() < 1e-12 && (to_s - 80e-6).abs() < 1e-12, "{from_s} .. {to_s}");
        let [from_s, to_s] = limits(Duration::from_millis(500));
        assert!((from_s - 0.1).abs() < 1e-12 && to_s == f64::INFINITY, "{from_s} .. {to_s}");
    }

    #[test]
    fn quantiles_are_limits_of_bins_and_never_above_the_largest_lateness() {
        let mut late_us = vec![3; 990];
        late_us.extend([70; 9]);
        late_us.push(900);
        let histogram = of_microseconds(&late_us);
        let quantile_us = |share: f64| (1e6 * histogram.quantile_s(share).expect("ticks")).round();
        assert_eq!([0.5, 0.99, 0.999, 1.0].map(quantile_us), [3.0, 3.0, 80.0, 900.0]);
        assert_eq!(LatenessHistogram::default().quantile_s(0.5), None);
    }

    #[test]
    fn missed_periods_count_by_their_share_and_the_longest_stall_is_exact() {
        let mut histogram = of_microseconds(&[5; 90]);
        histogram.count(Duration::from_micros(2600), 10);
        assert_eq!((histogram.ticks(), histogram.missed()), (91, 10));
        assert!((histogram.missed_ratio() - 10.0 / 101.0).abs() < 1e-15);
        assert!((histogram.longest_stall_s() - 2.6e-3).abs() < 1e-12);
        assert_eq!(LatenessHistogram::default().missed_ratio(), 0.0);
    }

    #[test]
    fn parts_of_a_loop_add_up() {
        let mut both = of_microseconds(&[5, 50]);
        both.count(Duration::from_micros(700), 2);
        let mut sum = of_microseconds(&[5]);
        let mut rest = of_microseconds(&[50]);
        rest.count(Duration::from_micros(700), 2);
        sum.add(&rest);
        assert_eq!(sum, both);
    }

    #[test]
    fn a_histogram_survives_its_file_and_one_with_other_bins_is_refused() {
        let mut histogram = of_microseconds(&[5, 50]);
        histogram.count(Duration::from_millis(321), 1284);
        let text = serde_json::to_string(&histogram).expect("numbers have a JSON form");
        assert_eq!(serde_json::from_str::<LatenessHistogram>(&text).expect("its own form"), histogram);
        let short = text.replace("\"counts\":[0,", "\"counts\":[");
        let error = serde_json::from_str::<LatenessHistogram>(&short).expect_err("a bin is missing");
        assert!(error.to_string().contains("52 bins, found 51"), "{error}");
    }
}
