//! Weighted linear least squares with covariance and variance inflation.

use nalgebra::{DMatrix, DVector};

#[cfg(test)]
mod tests;

/// Smallest diagonal of R (columns scaled to norm 1) that still counts as independent.
const LEAST_INDEPENDENCE: f64 = 1e-10;

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Fewer observations than coefficients, or as many.
    #[error("{observations} observations for {coefficients} coefficients")]
    TooFew {
        /// Observations given.
        observations: usize,
        /// Coefficients asked for.
        coefficients: usize,
    },
    /// Columns, observations and weights differ in length.
    #[error("expected {expected} rows, found {found}")]
    Length {
        /// Number of observations.
        expected: usize,
        /// Length of what does not fit them.
        found: usize,
    },
    /// A column is a combination of those before it.
    #[error("column {column} is not independent of those before it")]
    Dependent {
        /// Index of the column.
        column: usize,
    },
    /// A value is not finite, or a weight is negative.
    #[error("an observation, column or weight is not a finite number")]
    NotFinite,
}

/// A linear model `y = X·b` with its spread.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearFit {
    /// Coefficients b, in the order of the columns.
    pub coefficients: DVector<f64>,
    /// (XᵀWX)⁻¹: the covariance if the weights are 1/σ² of each observation.
    pub unscaled_covariance: DMatrix<f64>,
    /// Σ w·r² / dof: 1 on average if the weights are 1/σ², σ² of an observation if they are 1.
    pub residual_variance: f64,
    /// Observations minus coefficients.
    pub dof: usize,
    /// Residuals y − X·b.
    pub residuals: Vec<f64>,
    /// Variance inflation of each coefficient, 1/(1 − R²) of its column against all others
    /// (Belsley, Kuh & Welsch, *Regression Diagnostics*, 1980); 1 for a constant column. Centred where the model
    /// has a constant column, else about zero.
    pub variance_inflation: Vec<f64>,
}

impl LinearFit {
    /// Fits `y` by the columns `x` (one a coefficient, each as long as `y`) with weights `w` (1 each if `None`).
    ///
    /// By QR of the scaled, weighted columns.
    ///
    /// # Errors
    /// See [`FitError`].
    pub fn new(x: &[Vec<f64>], y: &[f64], w: Option<&[f64]>) -> Result<Self, FitError> {
        let root = check(x, y, w)?;
        let m = y.len();
        let n = x.len();
        let mut design = DMatrix::from_fn(m, n, |i, k| x[k][i] * root[i]);
        let scale: Vec<f64> = design.column_iter().map(|c| c.norm()).collect();
        for (k, &s) in scale.iter().enumerate() {
            if s <= 0.0 {
                return Err(FitError::Dependent { column: k });
            }
            design.column_mut(k).unscale_mut(s);
        }
        let qr = design.qr();
        let r = qr.r();
        if let Some(column) = (0..n).find(|&k| r[(k, k)].abs() < LEAST_INDEPENDENCE) {
            return Err(FitError::Dependent { column });
        }
        let mut qty = DVector::from_fn(m, |i, _| y[i] * root[i]);
        qr.q_tr_mul(&mut qty);
        let inverse = r
            .solve_upper_triangular(&DMatrix::identity(n, n))
            .ok_or(FitError::Dependent { column: n.saturating_sub(1) })?;
        let mut b = &inverse * qty.rows(0, n);
        let mut unscaled = &inverse * inverse.transpose();
        for k in 0..n {
            b[k] /= scale[k];
            for l in 0..n {
                unscaled[(k, l)] /= scale[k] * scale[l];
            }
        }
        let residuals: Vec<f64> =
            (0..m).map(|i| y[i] - (0..n).map(|k| x[k][i] * b[k]).sum::<f64>()).collect();
        let dof = m - n;
        let chi2: f64 = residuals.iter().zip(&root).map(|(e, q)| (e * q).powi(2)).sum();
        let variance_inflation = inflation(x, &root, &unscaled);
        Ok(Self {
            coefficients: b,
            unscaled_covariance: unscaled,
            residual_variance: chi2 / dof as f64,
            dof,
            residuals,
            variance_inflation,
        })
    }

    /// Covariance with the spread taken from the residuals (dof as in [`LinearFit::dof`]).
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.unscaled_covariance * self.residual_variance
    }

    /// Standard uncertainty of coefficient `k`, from the residuals.
    pub fn u(&self, k: usize) -> f64 {
        (self.unscaled_covariance[(k, k)] * self.residual_variance).sqrt()
    }

    /// Value of the model at one row of columns.
    pub fn at(&self, row: &[f64]) -> f64 {
        row.iter().zip(self.coefficients.iter()).map(|(x, b)| x * b).sum()
    }

    /// Standard uncertainty of the model at one row of columns, from the residuals.
    pub fn u_at(&self, row: &[f64]) -> f64 {
        let row = DVector::from_column_slice(row);
        (row.dot(&(&self.unscaled_covariance * &row)) * self.residual_variance).max(0.0).sqrt()
    }

    /// Largest variance inflation of all columns.
    pub fn worst_inflation(&self) -> f64 {
        self.variance_inflation.iter().copied().fold(1.0, f64::max)
    }
}

/// Checks shapes and numbers; returns the roots of the weights.
fn check(x: &[Vec<f64>], y: &[f64], w: Option<&[f64]>) -> Result<Vec<f64>, FitError> {
    let m = y.len();
    let lengths = x.iter().map(Vec::len).chain(w.map(<[f64]>::len));
    if let Some(found) = lengths.into_iter().find(|&found| found != m) {
        return Err(FitError::Length { expected: m, found });
    }
    if m <= x.len() || x.is_empty() {
        return Err(FitError::TooFew { observations: m, coefficients: x.len() });
    }
    let finite = x.iter().flatten().chain(y).all(|v| v.is_finite());
    let weighed = w.is_none_or(|w| w.iter().all(|v| v.is_finite() && *v >= 0.0));
    if !finite || !weighed {
        return Err(FitError::NotFinite);
    }
    Ok(w.map_or_else(|| vec![1.0; m], |w| w.iter().map(|v| v.sqrt()).collect()))
}

/// Variance inflation: covariance of each coefficient against what its column alone would give.
fn inflation(x: &[Vec<f64>], root: &[f64], unscaled: &DMatrix<f64>) -> Vec<f64> {
    let total: f64 = root.iter().map(|q| q * q).sum();
    let spread = |column: &[f64], centre: f64| -> f64 {
        column.iter().zip(root).map(|(v, q)| ((v - centre) * q).powi(2)).sum()
    };
    let constant: Vec<bool> = x.iter().map(|c| c.iter().all(|v| v.to_bits() == c[0].to_bits())).collect();
    let centred = constant.iter().any(|&c| c);
    x.iter()
        .enumerate()
        .map(|(k, column)| {
            let mean = column.iter().zip(root).map(|(v, q)| v * q * q).sum::<f64>() / total;
            let own = spread(column, if centred { mean } else { 0.0 });
            if constant[k] { 1.0 } else { (own * unscaled[(k, k)]).max(1.0) }
        })
        .collect()
}
