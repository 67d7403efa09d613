//! The sample rate of a record that carries its times.

use thiserror::Error;

/// Largest distance of a sample from its place on the uniform grid, in periods.
const MOST_JITTER_RATIO: f64 = 0.01;
/// A step above this many periods is a gap, not jitter.
const GAP_PERIODS: f64 = 1.5;

/// Why times are no uniform sampling; samples count from 0.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RateError {
    /// No rate follows from so few.
    #[error("expected at least 2 sample times, found {found}")]
    TooFew {
        /// Times there are.
        found: usize,
    },
    /// A time that is no number.
    #[error("sample {index}: expected a finite time, found {found}")]
    NotFinite {
        /// Sample.
        index: usize,
        /// Time of the sample, s.
        found: f64,
    },
    /// Time stands still or runs backward.
    #[error(
        "sample {index}: expected a time after {before_s} s, found {found_s} s: sort the record or cut it"
    )]
    Backward {
        /// Sample.
        index: usize,
        /// Time of the sample before, s.
        before_s: f64,
        /// Time of this one, s.
        found_s: f64,
    },
    /// Samples are missing.
    #[error(
        "sample {index}: expected {expected_s} s after the one before, found {found_s} s: take the stretches on \
         either side of the gap as segments"
    )]
    Gap {
        /// First sample after the gap.
        index: usize,
        /// Usual period, s.
        expected_s: f64,
        /// Step found, s.
        found_s: f64,
    },
    /// Steps differ.
    #[error(
        "sample {index}: expected within 1 % of a period of {period_s} s from the uniform grid, found {found_ratio} \
         periods: resample first"
    )]
    Jitter {
        /// First such sample.
        index: usize,
        /// Period, s.
        period_s: f64,
        /// Distance from the grid or of the step from a period, periods.
        found_ratio: f64,
    },
}

/// Sample rate, Hz, of times that are uniform within 1 % of a period, step by step and over the whole record.
///
/// # Errors
/// Fewer than two times, one that is not finite, steps backward, gaps, jitter: [`RateError`].
pub fn uniform_rate_hz(time_s: &[f64]) -> Result<f64, RateError> {
    if time_s.len() < 2 {
        return Err(RateError::TooFew { found: time_s.len() });
    }
    if let Some(index) = time_s.iter().position(|t| !t.is_finite()) {
        return Err(RateError::NotFinite { index, found: time_s[index] });
    }
    let mut steps: Vec<f64> = time_s.windows(2).map(|t| t[1] - t[0]).collect();
    if let Some(at) = steps.iter().position(|s| *s <= 0.0) {
        return Err(RateError::Backward { index: at + 1, before_s: time_s[at], found_s: time_s[at + 1] });
    }
    let middle = steps.len() / 2;
    // The median: a gap does not move it.
    let usual_s = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    first_odd_step(time_s, usual_s).map_or(Ok(()), Err)?;
    let period_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
    first_off_grid(time_s, period_s).map_or(Ok(1.0 / period_s), Err)
}

fn first_odd_step(time_s: &[f64], usual_s: f64) -> Option<RateError> {
    time_s.windows(2).enumerate().find_map(|(k, t)| {
        let index = k + 1;
        let found_s = t[1] - t[0];
        let off = (found_s / usual_s - 1.0).abs();
        if found_s > GAP_PERIODS * usual_s {
            Some(RateError::Gap { index, expected_s: usual_s, found_s })
        } else {
            (off > MOST_JITTER_RATIO).then_some(RateError::Jitter {
                index,
                period_s: usual_s,
                found_ratio: off,
            })
        }
    })
}

fn first_off_grid(time_s: &[f64], period_s: f64) -> Option<RateError> {
    time_s.iter().enumerate().find_map(|(index, t)| {
        let found_ratio = ((t - time_s[0]) / period_s - index as f64).abs();
        (found_ratio > MOST_JITTER_RATIO).then_some(RateError::Jitter { index, period_s, found_ratio })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform(count: usize) -> Vec<f64> {
        (0..count).map(|k| 17.0 + k as f64 / 4000.0).collect()
    }

    #[test]
    fn times_of_a_4_khz_record_give_4_khz() {
        let rate = uniform_rate_hz(&uniform(10_001)).expect("uniform");
        assert!((rate - 4000.0).abs() < 1e-6, "{rate}");
    }

    #[test]
    fn jitter_of_half_a_percent_passes_and_of_two_percent_does_not() {
        let mut times = uniform(1000);
        times[500] += 0.005 / 4000.0;
        assert!(uniform_rate_hz(&times).is_ok());
        times[500] += 0.015 / 4000.0;
        assert!(matches!(uniform_rate_hz(&times), Err(RateError::Jitter { index: 500, .. })));
    }

    #[test]
    fn a_lost_sample_is_a_gap_at_its_place() {
        let mut times = uniform(1000);
        times.remove(300);
        assert!(matches!(uniform_rate_hz(&times), Err(RateError::Gap { index: 300, .. })));
    }

    #[test]
    fn time_that_stands_or_turns_back_is_refused() {
        let mut times = uniform(10);
        times[4] = times[3];
        assert!(matches!(uniform_rate_hz(&times), Err(RateError::Backward { index: 4, .. })));
        times[4] = f64::NAN;
        assert!(matches!(uniform_rate_hz(&times), Err(RateError::NotFinite { index: 4, .. })));
        assert_eq!(uniform_rate_hz(&[1.0]), Err(RateError::TooFew { found: 1 }));
    }

    /// Each step is within 1 %, yet half of the record runs 0.4 % slower: no single rate holds.
    #[test]
    fn a_rate_that_changes_slowly_is_refused() {
        let mut t = 0.0;
        let times: Vec<f64> = (0..2000)
            .map(|k| {
                t += if k < 1000 { 1.0 } else { 1.004 };
                t
            })
            .collect();
        assert!(matches!(uniform_rate_hz(&times), Err(RateError::Jitter { .. })));
    }
}
