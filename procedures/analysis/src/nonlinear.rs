//! Nonlinear least squares by Levenberg–Marquardt, with covariance.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

/// Relative step of the central differences: cube root of the rounding unit, where truncation and rounding balance.
const STEP_RATIO: f64 = 6e-6;

/// A converged fit.
#[derive(Clone, Debug, PartialEq)]
pub struct NonlinearFit {
    /// Parameters in the order of the start values.
    pub parameters: Vec<f64>,
    /// (JᵀJ)⁻¹ at the solution.
    pub unscaled_covariance: DMatrix<f64>,
    /// Sum of squared residuals over dof.
    pub residual_variance: f64,
    /// Residuals minus parameters.
    pub dof: usize,
    /// Residuals at the solution.
    pub residuals: Vec<f64>,
}

/// Parameters are scaled by their start values' magnitude, so that steps and damping see numbers near 1.
struct Problem<'a, R> {
    residuals: &'a R,
    scale: &'a [f64],
    scaled: DVector<f64>,
}

impl<R: Fn(&[f64]) -> Vec<f64>> Problem<'_, R> {
    fn evaluate(&self, scaled: &DVector<f64>) -> DVector<f64> {
        let parameters: Vec<f64> = scaled.iter().zip(self.scale).map(|(p, s)| p * s).collect();
        DVector::from_vec((self.residuals)(&parameters))
    }
}

impl<R: Fn(&[f64]) -> Vec<f64>> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_, R> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.scaled.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.scaled.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let residuals = self.evaluate(&self.scaled);
        residuals.iter().all(|r| r.is_finite()).then_some(residuals)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns: Vec<DVector<f64>> = (0..self.scaled.len())
            .map(|k| {
                let step = STEP_RATIO * self.scaled[k].abs().max(1e-3);
                let mut low = self.scaled.clone();
                let mut high = self.scaled.clone();
                low[k] -= step;
                high[k] += step;
                (self.evaluate(&high) - self.evaluate(&low)) / (2.0 * step)
            })
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        jacobian.iter().all(|v| v.is_finite()).then_some(jacobian)
    }
}

impl NonlinearFit {
    /// Minimises Σ r² over the parameters, from `start`, where each parameter moves on the scale given.
    ///
    /// `None` if it does not converge, if residuals are not finite, or if the parameters cannot be told apart.
    pub fn new(residuals: impl Fn(&[f64]) -> Vec<f64>, start: &[f64], scale: &[f64]) -> Option<Self> {
        let scaled = DVector::from_iterator(start.len(), start.iter().zip(scale).map(|(p, s)| p / s));
        let problem = Problem { residuals: &residuals, scale, scaled };
        let (solved, report) = LevenbergMarquardt::new().with_tol(1e-12).with_patience(60).minimize(problem);
        // Residuals without noise end in rounding before any tolerance is met.
        let rounding = matches!(report.termination, TerminationReason::NoImprovementPossible(_));
        if !report.termination.was_successful() && !rounding {
            return None;
        }
        let jacobian = solved.jacobian()?;
        let residuals = solved.residuals()?;
        let dof = residuals.len().checked_sub(start.len()).filter(|&dof| dof > 0)?;
        let mut covariance = jacobian.tr_mul(&jacobian).try_inverse()?;
        for k in 0..start.len() {
            for l in 0..start.len() {
                covariance[(k, l)] *= scale[k] * scale[l];
            }
        }
        Some(Self {
            parameters: solved.scaled.iter().zip(scale).map(|(p, s)| p * s).collect(),
            unscaled_covariance: covariance,
            residual_variance: residuals.norm_squared() / dof as f64,
            dof,
            residuals: residuals.iter().copied().collect(),
        })
    }

    /// Standard uncertainty of parameter `k`, with the spread taken from the residuals.
    pub fn u(&self, k: usize) -> f64 {
        (self.unscaled_covariance[(k, k)] * self.residual_variance).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exact_exponential_is_found_and_noise_shows_in_u() {
        let t: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.1).collect();
        let y: Vec<f64> = t.iter().map(|t| 3.0 * (-t / 0.7).exp()).collect();
        let model =
            |p: &[f64]| -> Vec<f64> { t.iter().zip(&y).map(|(t, y)| p[0] * (-t / p[1]).exp() - y).collect() };
        let fit = NonlinearFit::new(model, &[1.0, 2.0], &[1.0, 1.0]).expect("a smooth problem converges");
        assert!((fit.parameters[0] - 3.0).abs() < 1e-9 && (fit.parameters[1] - 0.7).abs() < 1e-9);
        assert!(fit.u(0) < 1e-9);
    }

    #[test]
    fn parameters_that_act_alike_give_no_fit() {
        let fit = NonlinearFit::new(|p| vec![p[0] + p[1] - 1.0; 5], &[0.0, 0.0], &[1.0, 1.0]);
        assert_eq!(fit, None);
    }
}
