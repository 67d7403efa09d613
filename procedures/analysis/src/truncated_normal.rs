//! Normal distribution within limits: what lies outside of them is not drawn, and the rest is scaled up.

use statrs::distribution::{ContinuousCDF, Normal};

/// Smallest share of a normal distribution between its limits that is drawn from. Below it the tail has few digits.
const LEAST_SHARE: f64 = 1e-6;

/// Why there is no such distribution.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TruncatedNormalError {
    /// A standard deviation that is none.
    #[error("a standard deviation of {standard_deviation}; expected one above zero")]
    Deviation {
        /// The standard deviation.
        standard_deviation: f64,
    },
    /// Limits that leave next to nothing.
    #[error(
        "the limits leave a share of {share:.1e} of the distribution; expected at least {LEAST_SHARE:.0e}"
    )]
    Limits {
        /// What they leave.
        share: f64,
    },
}

/// A normal distribution within limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruncatedNormal {
    normal: Normal,
    limits: [f64; 2],
    /// Probabilities of the whole distribution below each limit.
    below: [f64; 2],
}

impl TruncatedNormal {
    /// A normal distribution of this mean and standard deviation, within `limits`.
    ///
    /// # Errors
    /// The standard deviation is not above zero, or the limits leave next to nothing.
    pub fn new(mean: f64, standard_deviation: f64, limits: [f64; 2]) -> Result<Self, TruncatedNormalError> {
        let refused = TruncatedNormalError::Deviation { standard_deviation };
        let normal = Normal::new(mean, standard_deviation).map_err(|_| refused)?;
        let below = limits.map(|limit| normal.cdf(limit));
        let share = (below[1] - below[0]).max(0.0);
        if share < LEAST_SHARE {
            return Err(TruncatedNormalError::Limits { share });
        }
        Ok(Self { normal, limits, below })
    }

    /// The value below which this share of the distribution lies.
    pub fn quantile(&self, share: f64) -> f64 {
        let p = self.below[0] + share * (self.below[1] - self.below[0]);
        self.normal.inverse_cdf(p).clamp(self.limits[0], self.limits[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of mean 10, deviation 3 within 7 … 16, by `statistics.NormalDist` of Python 3.11.
    const PYTHON: [(f64, f64); 3] =
        [(0.1, 7.886_056_536_715_765), (0.5, 10.513_491_754_053_474), (0.9, 13.767_146_092_450_645)];

    #[test]
    fn quantiles_agree_with_those_of_python() {
        let found = TruncatedNormal::new(10.0, 3.0, [7.0, 16.0]).expect("limits about the mean");
        for (share, expected) in PYTHON {
            let value = found.quantile(share);
            assert!((value - expected).abs() < 1e-9, "{share}: {value}, not {expected}");
        }
    }

    #[test]
    fn impossible_deviations_and_limits_that_leave_nothing_are_refused() {
        let refused = TruncatedNormal::new(0.0, 1.0, [8.0, 9.0]).expect_err("far away");
        assert!(matches!(refused, TruncatedNormalError::Limits { .. }), "{refused}");
        assert!(TruncatedNormal::new(0.0, 1.0, [1.0, -1.0]).is_err());
        assert!(TruncatedNormal::new(0.0, 0.0, [-1.0, 1.0]).is_err());
        assert!(TruncatedNormal::new(0.0, f64::NAN, [-1.0, 1.0]).is_err());
    }
}
