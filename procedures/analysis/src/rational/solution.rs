//! The weighted least-squares solution with the covariance of its parameters, in scaled frequency.
//!
//! θ are the nonlinear parameters (poles, delay), common to all responses. c are the linear ones (residues, polynomial
//! terms) of each response. The information is the inverse of the covariance that the weights imply.

use nalgebra::{DMatrix, DVector};

use super::super::frf::C64;
use super::RationalError;
use super::disturbance;
use super::lines::Data;
use super::normal::Normal;
use super::projection::Projection;
use super::shape::Shape;

/// Regularisation, added to the diagonal of the scaled information matrix where rounding leaves it without an inverse.
///
/// Two parameters that the data cannot tell apart then get a standard uncertainty a million times that of either alone.
const LEAST_INFORMATION: f64 = 1e-12;

/// A fitted rational function in scaled frequency.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Solution {
    pub(crate) shape: Shape,
    /// Nonlinear parameters.
    pub(crate) theta: Vec<f64>,
    /// Linear parameters of each response.
    pub(crate) c: Vec<Vec<f64>>,
    /// Weighted sum of squares of the residual.
    pub(crate) cost: f64,
    /// Degrees of freedom: real numbers observed minus parameters.
    pub(crate) dof: usize,
    /// Covariance of (θ, c) of each response.
    pub(crate) covariance: Vec<DMatrix<f64>>,
    /// Inverse information of c at fixed θ, for each response. It is not scaled by the noise of the residual.
    pub(crate) held: Vec<DMatrix<f64>>,
}

/// Inverse of a symmetric, positive definite matrix whose parameters may differ by orders of magnitude.
fn inverse(information: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = information.nrows();
    let diagonal = information.diagonal();
    // A parameter that has no influence would divide by zero: its information is taken as this least value.
    let least = LEAST_INFORMATION * diagonal.amax();
    let scale: Vec<f64> = diagonal.iter().map(|d| d.max(least).sqrt()).collect();
    let mut scaled = DMatrix::from_fn(n, n, |k, l| information[(k, l)] / (scale[k] * scale[l]));
    if scaled.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let well_conditioned = |factor: &nalgebra::Cholesky<f64, nalgebra::Dyn>| {
        factor.l_dirty().diagonal().iter().all(|entry| entry * entry > LEAST_INFORMATION)
    };
    let factor = scaled.clone().cholesky().filter(well_conditioned).or_else(|| {
        (0..n).for_each(|k| scaled[(k, k)] += LEAST_INFORMATION);
        scaled.cholesky()
    })?;
    let inverse = factor.inverse();
    Some(DMatrix::from_fn(n, n, |k, l| inverse[(k, l)] / (scale[k] * scale[l])))
}

/// Inverse of an upper triangular matrix, whose columns are scaled to norm 1 before the inversion.
fn inverse_triangle(r: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = r.nrows();
    let norms: Vec<f64> = r.column_iter().map(|c| c.norm()).collect();
    let scaled = DMatrix::from_fn(n, n, |k, l| r[(k, l)] / norms[l]);
    let mut inverse = scaled.solve_upper_triangular(&DMatrix::identity(n, n))?;
    for (k, norm) in norms.iter().enumerate() {
        inverse.row_mut(k).unscale_mut(*norm);
    }
    inverse.iter().all(|v| v.is_finite()).then_some(inverse)
}

/// One response after its linear parameters are eliminated (variable projection). They follow θ.
pub(super) struct Follower {
    /// Linear parameters.
    pub(super) c: Vec<f64>,
    /// K = −∂c/∂θ, with a row per linear parameter and a column per nonlinear one.
    pub(super) follow: DMatrix<f64>,
    /// Inverse information of the linear parameters at fixed θ.
    pub(super) held: DMatrix<f64>,
}

/// All responses after elimination, at some θ.
pub(super) struct Eliminated {
    /// Information of θ from all responses together.
    pub(super) information: DMatrix<f64>,
    pub(super) followers: Vec<Follower>,
    pub(super) cost: f64,
}

impl Eliminated {
    /// From the QR decomposition of each response: the first rows of the rotated slopes belong to the linear parameters.
    /// The other rows hold what no linear parameter can explain: they give the information of θ.
    pub(super) fn new(
        data: &Data,
        shape: &Shape,
        theta: &[f64],
        projection: &Projection,
    ) -> Result<Self, RationalError> {
        let n = shape.nonlinear_count();
        let linear = shape.linear_count();
        let mut information = DMatrix::zeros(n, n);
        let mut followers = Vec::with_capacity(data.responses.len());
        for (block, response) in projection.blocks.iter().zip(&data.responses) {
            let slopes = block.rotated_slopes(response, shape, theta);
            let rest = slopes.rows(linear, slopes.nrows() - linear);
            information += rest.tr_mul(&rest);
            let inverse = inverse_triangle(&block.triangle()).ok_or(RationalError::Dependent)?;
            followers.push(Follower {
                c: block.c.iter().copied().collect(),
                follow: &inverse * slopes.rows(0, linear),
                held: &inverse * inverse.transpose(),
            });
        }
        Ok(Self { information, followers, cost: projection.cost() })
    }
}

/// Linear parameters fitted at fixed θ.
pub(crate) struct Held {
    /// Linear parameters of each response, with their inverse information.
    linear: Vec<(Vec<f64>, DMatrix<f64>)>,
    /// Cost over degrees of freedom.
    misfit: f64,
}

impl Held {
    pub(super) fn new(normal: &Normal, dof: usize) -> Self {
        Self { linear: normal.linear(), misfit: normal.cost / dof.max(1) as f64 }
    }

    /// Cost over degrees of freedom: the reduced χ² where variances are known.
    pub(crate) fn misfit(&self) -> f64 {
        self.misfit
    }

    /// As [`Solution::weight_of_pair`].
    pub(crate) fn weight_of_pair(&self, k: usize) -> f64 {
        self.linear.iter().map(|(c, held)| weight(c, held, k)).sum()
    }
}

impl From<Solution> for Held {
    fn from(solution: Solution) -> Self {
        let misfit = solution.misfit();
        Self { linear: solution.c.into_iter().zip(solution.held).collect(), misfit }
    }
}

/// Degrees of freedom: two real numbers per line minus all parameters.
pub(super) fn dof(data: &Data, shape: &Shape) -> usize {
    let unknowns = shape.nonlinear_count() + shape.linear_count() * data.responses.len();
    (2 * data.line_count()).saturating_sub(unknowns)
}

impl Solution {
    /// Computes the covariance blockwise: that of θ from all responses together, then that of (θ, c) of each response.
    pub(super) fn new(
        data: &Data,
        shape: &Shape,
        theta: &[f64],
        eliminated: Eliminated,
    ) -> Result<Self, RationalError> {
        let Eliminated { information, followers, cost } = eliminated;
        let dof = dof(data, shape);
        // Weights from given variances need only the allowance for variances that are estimates. Otherwise the residual is
        // the only measure of the noise.
        let factor = if data.known { data.widening } else { cost / dof as f64 };
        let of_theta = inverse(&information).ok_or(RationalError::Dependent)?;
        let by_shared = disturbance::covariance(data, shape, theta, &followers, &of_theta);
        let of_theta = (of_theta + by_shared) * factor;
        let covariance = followers.iter().map(|f| joint(&of_theta, &f.follow, &(&f.held * factor))).collect();
        let (c, held) = followers.into_iter().map(|f| (f.c, f.held)).unzip();
        Ok(Self { shape: shape.clone(), theta: theta.to_vec(), c, cost, dof, covariance, held })
    }

    /// The response at a scaled frequency.
    pub(crate) fn at(&self, response: usize, s: C64) -> C64 {
        self.shape.at(&self.theta, &self.c[response], s)
    }

    /// Variance of the fitted response at a scaled frequency, real and imaginary part together: E|Ĝ − G|².
    pub(crate) fn variance_at(&self, response: usize, s: C64) -> f64 {
        let n = self.shape.nonlinear_count();
        let linear = self.shape.linear_count();
        let mut slopes = vec![C64::default(); n + linear];
        self.shape.slopes(&self.theta, &self.c[response], s, &mut slopes[..n]);
        self.shape.columns(&self.theta, s, &mut slopes[n..]);
        self.variance_along(response, &slopes)
    }

    /// Variance of a complex function of (θ, c) of a response, from its slopes: real and imaginary part together.
    pub(crate) fn variance_along(&self, response: usize, slopes: &[C64]) -> f64 {
        let covariance = &self.covariance[response];
        let variance = |part: fn(&C64) -> f64| {
            let row = DVector::from_iterator(slopes.len(), slopes.iter().map(part));
            row.dot(&(covariance * &row))
        };
        (variance(|v| v.re) + variance(|v| v.im)).max(0.0)
    }

    /// Cost over degrees of freedom: the reduced χ² where variances are known.
    pub(crate) fn misfit(&self) -> f64 {
        self.cost / self.dof.max(1) as f64
    }

    /// Increase of the cost if the second-order section `k` were left out and all poles stayed fixed.
    ///
    /// Σ cᵀ·C⁻¹·c over the responses, with c the two linear parameters of the section and C their block of `held`.
    pub(crate) fn weight_of_pair(&self, k: usize) -> f64 {
        self.c.iter().zip(&self.held).map(|(c, held)| weight(c, held, k)).sum()
    }
}

/// cᵀ·C⁻¹·c of the second-order section `k` of one response; see [`Solution::weight_of_pair`].
fn weight(c: &[f64], held: &DMatrix<f64>, k: usize) -> f64 {
    let [first, second] = [2 * k, 2 * k + 1];
    let [first_sd, second_sd] = [held[(first, first)].sqrt(), held[(second, second)].sqrt()];
    // Divided by the standard deviations first: the determinant of C itself could underflow or overflow.
    let x = c[first] / first_sd;
    let y = c[second] / second_sd;
    let correlation = held[(first, second)] / first_sd / second_sd;
    let determinant = 1.0 - correlation * correlation;
    if determinant > 0.0 { (x * x - 2.0 * x * y * correlation + y * y) / determinant } else { 0.0 }
}

/// Joint covariance of (θ, c) of one response, from that of θ and that of c at fixed θ (`held`). K = −∂c/∂θ.
fn joint(of_theta: &DMatrix<f64>, k: &DMatrix<f64>, held: &DMatrix<f64>) -> DMatrix<f64> {
    let n = of_theta.nrows();
    let linear = held.nrows();
    let cross = -(k * of_theta);
    let mut all = DMatrix::zeros(n + linear, n + linear);
    all.view_mut((0, 0), (n, n)).copy_from(of_theta);
    all.view_mut((n, 0), (linear, n)).copy_from(&cross);
    all.view_mut((0, n), (n, linear)).copy_from(&cross.transpose());
    all.view_mut((n, n), (linear, linear)).copy_from(&(held - &cross * k.transpose()));
    all
}
