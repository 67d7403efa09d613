//! The periods of a response: those at the end of its segment that have all of their rows.

use std::ops::Range;

use super::point::whole;
use crate::measurement::Exclusion;
use crate::reason::{MirrorReason, Reason};

/// Rows by which a median over periods may be beside a whole number of them: the jitter of a tick at 4 kHz.
const JITTER_ROWS: f64 = 0.05;

/// Periods that count.
#[derive(Clone, Debug)]
pub(super) struct Periods {
    /// Time from row to row.
    pub(super) row_s: f64,
    /// Rows of each period.
    pub(super) rows: Vec<Range<usize>>,
    /// Periods in which rows are missing.
    left_out_count: usize,
}

impl Periods {
    /// The last `count` periods of a segment with these rows. Where a tick was missed, the periods around it are left out; the
    /// others begin whole periods from it, so that their phases agree.
    ///
    /// # Errors
    /// Fewer rows than periods need; half of the periods, or more, without all of their rows.
    pub(super) fn last(
        time_s: &[f64],
        range: Range<usize>,
        period_s: f64,
        count: usize,
    ) -> Result<Self, Reason> {
        let times = &time_s[range.clone()];
        let [first, .., last] = times else { return Err(MirrorReason::TooFewRows.into()) };
        let mean_s = (last - first) / (times.len() - 1) as f64;
        let Some(gap) = times.windows(2).find(|pair| is_gap(pair, mean_s)) else {
            let length = whole(period_s / mean_s)?;
            if times.len() < count * length {
                let expected = count * length;
                return Err(MirrorReason::FewerRows { expected, found: times.len() }.into());
            }
            let start = range.end - count * length;
            let rows = (0..count).map(|k| start + k * length..start + (k + 1) * length).collect();
            return Ok(Self { row_s: mean_s, rows, left_out_count: 0 });
        };
        let row_s = step_s(times, period_s);
        let length = whole(period_s / row_s)?;
        let row_before = |time: f64| range.start + times.partition_point(|&t| t < time);
        let period = |k: usize| {
            let end_s = last - k as f64 * period_s + 0.5 * row_s;
            row_before(end_s - period_s)..row_before(end_s)
        };
        let has_all = |rows: &Range<usize>| {
            rows.len() == length && !time_s[rows.clone()].windows(2).any(|pair| is_gap(pair, row_s))
        };
        let rows: Vec<Range<usize>> = (0..count).rev().map(period).filter(has_all).collect();
        if 2 * rows.len() <= count {
            return Err(MirrorReason::RowsMissing { at_s: gap[0] }.into());
        }
        let left_out_count = count - rows.len();
        Ok(Self { row_s, rows, left_out_count })
    }

    /// Values of a channel in all periods, one after another.
    pub(super) fn values(&self, channel: &[f64]) -> Vec<f64> {
        self.rows.iter().flat_map(|rows| &channel[rows.clone()]).copied().collect()
    }

    /// What is left out, and why.
    pub(super) fn excluded(&self) -> Option<Exclusion> {
        let reason = "rows are missing".to_owned();
        let of = "periods".to_owned();
        (self.left_out_count > 0).then_some(Exclusion { count: self.left_out_count, of, reason })
    }
}

/// Whether the rows of a pair are not next to each other.
fn is_gap(pair: &[f64], row_s: f64) -> bool {
    (pair[1] - pair[0] - row_s).abs() > 0.5 * row_s
}

/// Time from row to row over a record with gaps. Real ticks come early and late, so that over a long period the error of a median
/// step can add up to rows: the median of the times that as many rows take as a period has is then nearer.
fn step_s(times: &[f64], period_s: f64) -> f64 {
    let step_s = median(times.windows(2).map(|pair| pair[1] - pair[0]).collect());
    let rows = (period_s / step_s).round().clamp(1.0, (times.len() - 1) as f64);
    let spans = times.iter().zip(&times[rows as usize..]).map(|(begin, end)| end - begin);
    let span_s = median(spans.collect());
    let nearly_whole = |rows: f64| (rows - rows.round()).abs() < JITTER_ROWS;
    // Rows of a period are whole ones: what is left is jitter.
    let counted = [period_s / step_s, period_s * rows / span_s].into_iter().find(|&rows| nearly_whole(rows));
    counted.map_or(step_s, |rows| period_s / rows.round())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows every millisecond, without those named.
    fn times(missing: &[usize]) -> Vec<f64> {
        (0..100).filter(|k| !missing.contains(k)).map(|k| 1e-3 * k as f64).collect()
    }

    #[test]
    fn a_period_with_a_missing_row_is_left_out_and_the_others_keep_their_phase() {
        let time_s = times(&[57]);
        let periods = Periods::last(&time_s, 0..time_s.len(), 0.01, 8).expect("seven are left");
        assert_eq!(periods.excluded().map(|left| left.count), Some(1));
        let starts: Vec<u32> =
            periods.rows.iter().map(|rows| (1e3 * time_s[rows.start]).round() as u32).collect();
        assert_eq!(starts, [20, 30, 40, 60, 70, 80, 90]);
        assert!(periods.rows.iter().all(|rows| rows.len() == 10));
    }

    #[test]
    fn ticks_that_come_early_and_late_do_not_change_the_time_from_row_to_row() {
        let early = |k: usize| if k.is_multiple_of(3) { 2e-5 } else { -1e-5 };
        let time_s: Vec<f64> = (0..100).filter(|k| *k != 57).map(|k| 1e-3 * k as f64 + early(k)).collect();
        let periods = Periods::last(&time_s, 0..time_s.len(), 0.01, 8).expect("seven are left");
        assert!((periods.row_s - 1e-3).abs() < 1e-6, "{}", periods.row_s);
        assert_eq!(periods.rows.len(), 7);
    }

    #[test]
    fn late_ticks_and_a_gap_leave_a_long_period_whole() {
        // 4 kHz: every third tick is 60 us late, every fifth 40 us early, and 25 rows are missing.
        let late_s = |k: usize| {
            f64::from(u8::from(k.is_multiple_of(3))) * 60e-6
                - f64::from(u8::from(k.is_multiple_of(5))) * 40e-6
        };
        let time_s: Vec<f64> = (0..10_000)
            .filter(|k| !(6_200..6_225).contains(k))
            .map(|k| 250e-6 * k as f64 + late_s(k))
            .collect();
        let periods = Periods::last(&time_s, 0..time_s.len(), 0.25, 8).expect("seven are left");
        assert!((periods.row_s / 250e-6 - 1.0).abs() < 1e-9, "{}", periods.row_s);
        assert!(periods.rows.len() == 7 && periods.rows.iter().all(|rows| rows.len() == 1000));
        let broken = Periods::last(&time_s, 0..time_s.len(), 0.250_1, 8).expect_err("1000.4 rows");
        assert!(broken.to_string().contains("expected a whole number"), "{broken}");
    }

    #[test]
    fn without_a_gap_the_last_rows_count_and_with_too_many_none_does() {
        let sound = times(&[]);
        let periods = Periods::last(&sound, 5..98, 0.01, 9).expect("sound");
        assert_eq!((periods.rows[0].clone(), periods.rows[8].clone()), (8..18, 88..98));
        assert_eq!(periods.excluded(), None);
        assert!(Periods::last(&sound, 0..85, 0.01, 9).is_err(), "too few rows");
        let torn = times(&[15, 25, 35, 45, 55]);
        let error = Periods::last(&torn, 0..torn.len(), 0.01, 10).expect_err("half of them are torn");
        assert_eq!(error.to_string(), "rows of the mirror are missing at 0.0140 s");
    }
}
