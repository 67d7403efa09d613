//! Correlated random numbers by a Gaussian copula: each keeps its own distribution, their ranks are correlated.
//!
//! Independent numbers of (0, 1) become normal ones, a Cholesky factor of the correlation matrix couples those, and the
//! cumulative distribution takes them back to (0, 1). The coefficient ρ is that of the normal numbers; the rank correlation
//! (Spearman) of the results is 6/π·asin(ρ/2). R. B. Nelsen, *An Introduction to Copulas*, 2nd ed., 2006, 2.3.6 and 5.1.2.

use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF, Normal};

/// Eigenvalue of a correlation matrix below which it counts as singular: the rounding of a hundred coefficients.
const LEAST_EIGENVALUE: f64 = 1e-9;

/// Why a matrix is no correlation matrix of a copula.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CopulaError {
    /// The matrix is not square.
    #[error(
        "a correlation matrix of {rows} rows with a row of {columns} columns; expected as many columns as rows"
    )]
    NotSquare {
        /// Rows.
        rows: usize,
        /// Columns of the first row that has another number of them.
        columns: usize,
    },
    /// No random numbers have such correlations.
    #[error("the correlation matrix is not positive definite: its smallest eigenvalue is {least:.3}")]
    NotPositiveDefinite {
        /// Smallest eigenvalue.
        least: f64,
    },
}

/// Couples independent uniform random numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianCopula {
    /// Lower Cholesky factor of the correlation matrix.
    factor: DMatrix<f64>,
}

impl GaussianCopula {
    /// A copula with the correlation matrix of these rows: symmetric, ones on its diagonal.
    ///
    /// # Errors
    /// The matrix is not square or not positive definite.
    pub fn new(correlation: &[Vec<f64>]) -> Result<Self, CopulaError> {
        let rows = correlation.len();
        if let Some(columns) = correlation.iter().map(Vec::len).find(|columns| *columns != rows) {
            return Err(CopulaError::NotSquare { rows, columns });
        }
        let matrix = DMatrix::from_fn(rows, rows, |row, column| correlation[row][column]);
        let least = matrix.symmetric_eigenvalues().iter().copied().fold(f64::INFINITY, f64::min);
        let refused = CopulaError::NotPositiveDefinite { least };
        if least < LEAST_EIGENVALUE {
            return Err(refused);
        }
        matrix.cholesky().map(|found| Self { factor: found.l() }).ok_or(refused)
    }

    /// Coupled numbers of 0 to 1 from independent ones, as many as the matrix has rows.
    pub fn couple(&self, independent: &[f64]) -> Vec<f64> {
        // The ends themselves would be infinite.
        const END: f64 = 1e-16;
        let normal = Normal::standard();
        let score = |p: &f64| normal.inverse_cdf(p.clamp(END, 1.0 - END));
        let scores: Vec<f64> = independent.iter().map(score).collect();
        let rows = self.factor.row_iter();
        rows.map(|row| normal.cdf(row.iter().zip(&scores).map(|(factor, score)| factor * score).sum()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{RngCore, SeedableRng};

    use super::*;
    use crate::rank::spearman;

    fn matrix(rho: f64) -> Vec<Vec<f64>> {
        vec![vec![1.0, rho], vec![rho, 1.0]]
    }

    #[test]
    fn coupled_numbers_stay_uniform_and_have_the_rank_correlation_of_theory() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut uniform = || ((random.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
        for rho in [-0.9, -0.3, 0.6, 0.95] {
            let copula = GaussianCopula::new(&matrix(rho)).expect("positive definite");
            let pairs: Vec<Vec<f64>> = (0..20_000).map(|_| copula.couple(&[uniform(), uniform()])).collect();
            let [first, second] = [0, 1].map(|k| pairs.iter().map(|pair| pair[k]).collect::<Vec<f64>>());
            let expected = 6.0 / std::f64::consts::PI * (0.5 * rho).asin();
            let found = spearman(&first, &second).expect("numbers that differ");
            assert!((found - expected).abs() < 0.02, "{rho}: {found}, not {expected}");
            let mean = second.iter().sum::<f64>() / 20_000.0;
            let low_decile = second.iter().filter(|p| **p < 0.1).count();
            assert!((mean - 0.5).abs() < 0.01 && (1800..2200).contains(&low_decile), "{mean}, {low_decile}");
        }
    }

    #[test]
    fn without_correlation_numbers_stay_what_they_are() {
        let copula = GaussianCopula::new(&matrix(0.0)).expect("positive definite");
        let coupled = copula.couple(&[0.123, 0.9]);
        // The inverse of the normal distribution in `statrs` is a rational approximation, good to nine digits and more.
        assert!((coupled[0] - 0.123).abs() < 1e-9 && (coupled[1] - 0.9).abs() < 1e-9, "{coupled:?}");
    }

    #[test]
    fn correlations_that_contradict_each_other_are_refused() {
        let matrix = [vec![1.0, 0.9, -0.9], vec![0.9, 1.0, 0.9], vec![-0.9, 0.9, 1.0]];
        let refused = GaussianCopula::new(&matrix).expect_err("no such numbers");
        assert_eq!(
            refused.to_string(),
            "the correlation matrix is not positive definite: its smallest eigenvalue is -0.800"
        );
        assert!(GaussianCopula::new(&[vec![1.0; 3], vec![1.0; 3]]).is_err());
    }
}
