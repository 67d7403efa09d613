//! Quantiles of samples, and intervals for them without an assumption about the distribution.

use statrs::distribution::{Binomial, DiscreteCDF};

/// The value below which this share of a population lies, estimated from a sample in ascending order; `None` for an empty one.
///
/// Median-unbiased whatever the distribution: definition 8 of R. J. Hyndman and Y. Fan, *Am. Statist.* 50, 361 (1996). Beyond the
/// first and last value it is that value.
pub fn quantile(ascending: &[f64], share: f64) -> Option<f64> {
    let count = ascending.len();
    let place = (count as f64 + 1.0 / 3.0) * share + 1.0 / 3.0;
    let below = (place.floor().max(1.0) as usize).min(count);
    let above = (below + 1).min(count);
    let part = (place - below as f64).clamp(0.0, 1.0);
    let [low, high] = [below, above].map(|rank| rank.checked_sub(1).and_then(|k| ascending.get(k)));
    Some(low? + part * (high? - low?))
}

/// Two-sided interval for the quantile of this share from a sample of independent values in ascending order.
///
/// Its ends are values of the sample, so it holds for every continuous distribution with at least `level`, and each end fails
/// with at most half of the rest (H. A. David, H. N. Nagaraja, *Order Statistics*, 3rd ed., 2003, 7.1). `None` for an end that
/// would lie beyond the sample.
pub fn quantile_interval(ascending: &[f64], share: f64, level: f64) -> [Option<f64>; 2] {
    let count = ascending.len();
    let Ok(below) = Binomial::new(share.clamp(0.0, 1.0), count as u64) else { return [None, None] };
    let tail = 0.5 * (1.0 - level);
    // The k-th value lies above the quantile where fewer than k values lie below it, and below the quantile where at least k do.
    let lies_above = |rank: usize| below.cdf(rank as u64 - 1);
    let low = (1..=count).rev().find(|&rank| lies_above(rank) <= tail);
    let high = (1..=count).find(|&rank| 1.0 - lies_above(rank) <= tail);
    [low, high].map(|rank| rank.map(|rank| ascending[rank - 1]))
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{RngCore, SeedableRng};

    use super::*;

    #[test]
    fn quantiles_interpolate_between_values_and_end_with_them() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(quantile(&values, 0.5), Some(3.0));
        let found = quantile(&values, 0.3).expect("values");
        assert!((found - (1.0 + (16.0 / 3.0 * 0.3 + 1.0 / 3.0 - 1.0))).abs() < 1e-12, "{found}");
        assert_eq!([quantile(&values, 0.001), quantile(&values, 0.999)], [Some(1.0), Some(5.0)]);
        assert_eq!([quantile(&[], 0.5), quantile(&[7.0], 0.9)], [None, Some(7.0)]);
    }

    /// Ranks by the tables of the binomial distribution: of 20 values the median lies between the 6th and the 15th.
    #[test]
    fn the_median_of_twenty_lies_between_the_sixth_and_the_fifteenth() {
        let values: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(quantile_interval(&values, 0.5, 0.95), [Some(6.0), Some(15.0)]);
        assert_eq!(quantile_interval(&values, 0.95, 0.95), [Some(17.0), None]);
        assert_eq!(quantile_interval(&values, 0.05, 0.95), [None, Some(4.0)]);
        assert_eq!(quantile_interval(&[], 0.5, 0.95), [None, None]);
    }

    #[test]
    fn intervals_cover_the_quantile_of_a_skew_distribution_at_least_as_often_as_they_say() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut exponential = || -(1.0 - (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64).ln();
        let truth = -(0.1_f64).ln();
        let mut covered = 0;
        for _ in 0..2000 {
            let mut values: Vec<f64> = (0..60).map(|_| exponential()).collect();
            values.sort_by(f64::total_cmp);
            let [low, high] = quantile_interval(&values, 0.9, 0.9);
            covered +=
                usize::from(low.is_none_or(|low| low <= truth) && high.is_none_or(|high| truth <= high));
        }
        // 90 % less three standard deviations.
        assert!(covered >= 1760, "{covered} of 2000");
    }
}
