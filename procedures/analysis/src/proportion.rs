//! Shares of successes, e.g. of units that pass: exact intervals and tails by the binomial distribution.

use statrs::distribution::{Binomial, DiscreteCDF};
use statrs::function::beta::beta_reg;

/// Why counts have no proportion.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProportionError {
    /// More successes than trials.
    #[error("{successes} successes in {trials} trials: expected at most one success for each trial")]
    MoreThanTrials {
        /// Successes.
        successes: u64,
        /// Trials.
        trials: u64,
    },
    /// A level that leaves no interval.
    #[error("a level of {level}: expected one above 0 and below 1, e.g. 0.95")]
    Level {
        /// The level.
        level: f64,
    },
    /// A probability of success that is none.
    #[error("a probability of {probability}: expected one from 0 to 1")]
    Probability {
        /// The probability.
        probability: f64,
    },
}

/// Two-sided interval of the probability of success, by Clopper and Pearson (*Biometrika* 26, 404, 1934).
///
/// Its coverage is at least `level` whatever the probability is; each end is exceeded with at most half of the rest. Without
/// trials it is 0 to 1. Trials must be independent.
///
/// # Errors
/// More successes than trials, or a level that is not between 0 and 1.
pub fn clopper_pearson(successes: u64, trials: u64, level: f64) -> Result<[f64; 2], ProportionError> {
    if successes > trials {
        return Err(ProportionError::MoreThanTrials { successes, trials });
    }
    if !(level > 0.0 && level < 1.0) {
        return Err(ProportionError::Level { level });
    }
    let tail = 0.5 * (1.0 - level);
    let [k, n] = [successes, trials].map(|count| count as f64);
    // P(X ≥ k) = I_p(k, n − k + 1) rises with p, and so does 1 − P(X ≤ k) = I_p(k + 1, n − k).
    let low = if successes == 0 { 0.0 } else { rises_to(tail, |p| beta_reg(k, n - k + 1.0, p)) };
    let high = if successes == trials { 1.0 } else { rises_to(1.0 - tail, |p| beta_reg(k + 1.0, n - k, p)) };
    Ok([low, high])
}

/// Where a rising function of 0…1 reaches a value.
fn rises_to(value: f64, function: impl Fn(f64) -> f64) -> f64 {
    let mut low = 0.0;
    let mut high = 1.0;
    // Every step settles a binary digit: those of a double and the leading zeros of 1e-30.
    for _ in 0..160 {
        let middle = 0.5 * (low + high);
        if function(middle) < value {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Probability of at most so many successes, each with this probability.
///
/// # Errors
/// More successes than trials, or a probability that is not from 0 to 1.
pub fn probability_of_at_most(successes: u64, trials: u64, probability: f64) -> Result<f64, ProportionError> {
    Ok(law(successes, trials, probability)?.cdf(successes))
}

/// Probability of at least so many successes, each with this probability.
///
/// # Errors
/// As [`probability_of_at_most`].
pub fn probability_of_at_least(
    successes: u64,
    trials: u64,
    probability: f64,
) -> Result<f64, ProportionError> {
    let law = law(successes, trials, probability)?;
    Ok(successes.checked_sub(1).map_or(1.0, |fewer| law.sf(fewer)))
}

fn law(successes: u64, trials: u64, probability: f64) -> Result<Binomial, ProportionError> {
    if successes > trials {
        return Err(ProportionError::MoreThanTrials { successes, trials });
    }
    Binomial::new(probability, trials).map_err(|_| ProportionError::Probability { probability })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Successes, trials, level and both ends by scipy 1.17.1: `beta.ppf(a/2, k, n - k + 1)`, `beta.ppf(1 - a/2, k + 1, n - k)`
    /// with a = 1 - level, in full precision.
    const SCIPY: &[(u64, u64, f64, f64, f64)] = &[
        (0, 20, 0.95, 0.0, 0.1684334709830853),
        (1, 20, 0.95, 0.0012650894979498047, 0.24873276277202777),
        (20, 20, 0.95, 0.8315665290169147, 1.0),
        (10, 20, 0.9, 0.3019539112864935, 0.6980460887135065),
        (37, 40, 0.95, 0.796135251267101, 0.9842578201489585),
        (3, 1000, 0.99, 0.00033814452906649344, 0.01093377742040524),
        (999, 1000, 0.99, 0.992593713061647, 0.9999949874707392),
        (1, 1, 0.9, 0.04999999999999999, 1.0),
        (250, 100000, 0.95, 0.00219999949642787, 0.0028294100598733967),
    ];

    #[test]
    fn intervals_agree_with_the_quantiles_of_the_beta_distribution_of_scipy() {
        for &(successes, trials, level, low, high) in SCIPY {
            let found = clopper_pearson(successes, trials, level).expect("counts");
            let is_near = |found: f64, expected: f64| (found - expected).abs() <= 1e-10 * expected;
            assert!(is_near(found[0], low) && is_near(found[1], high), "{successes} of {trials}: {found:?}");
        }
    }

    #[test]
    fn the_interval_covers_at_least_its_level_for_every_probability() {
        for trials in [1, 4, 13, 40] {
            for p in [0.003, 0.02, 0.11, 0.35, 0.5, 0.72, 0.9, 0.99] {
                let law = |k: u64| {
                    let at_most = |k| probability_of_at_most(k, trials, p).expect("a probability");
                    at_most(k) - if k == 0 { 0.0 } else { at_most(k - 1) }
                };
                let covers = |k: &u64| {
                    let [low, high] = clopper_pearson(*k, trials, 0.9).expect("counts");
                    low <= p && p <= high
                };
                let coverage: f64 = (0..=trials).filter(covers).map(law).sum();
                assert!(coverage >= 0.9 - 1e-12, "{trials} trials, p = {p}: {coverage}");
                assert!(coverage <= 1.0 + 1e-12);
            }
        }
    }

    #[test]
    fn both_tails_hold_the_count_itself() {
        let at_most = probability_of_at_most(2, 3, 0.5).expect("a probability");
        let at_least = probability_of_at_least(2, 3, 0.5).expect("a probability");
        assert!((at_most - 7.0 / 8.0).abs() < 1e-14 && (at_least - 0.5).abs() < 1e-14);
        assert_eq!(probability_of_at_least(0, 3, 0.0), Ok(1.0));
        assert_eq!(probability_of_at_most(3, 3, 1.0), Ok(1.0));
    }

    #[test]
    fn impossible_counts_levels_and_probabilities_are_refused() {
        let refused = clopper_pearson(4, 3, 0.9).expect_err("more than trials");
        assert_eq!(
            refused.to_string(),
            "4 successes in 3 trials: expected at most one success for each trial"
        );
        assert_eq!(clopper_pearson(1, 3, 1.0), Err(ProportionError::Level { level: 1.0 }));
        assert!(clopper_pearson(1, 3, f64::NAN).is_err());
        assert_eq!(clopper_pearson(0, 0, 0.9), Ok([0.0, 1.0]), "nothing was tried");
        assert_eq!(probability_of_at_most(1, 3, 1.5), Err(ProportionError::Probability { probability: 1.5 }));
        assert!(probability_of_at_least(5, 3, 0.5).is_err());
    }
}
