//! The elimination of [projection](super::projection) by normal equations: one product of matrices in place of a QR.
//!
//! Squares the condition of the columns. What that costs is bounded by the pivots: where one falls below
//! [`LEAST_PIVOT`] there is no answer, and the caller takes the QR. The linear parameters are corrected once from the
//! residual of the lines themselves (Björck, *Numerical Methods for Least Squares Problems*, 1996, §6.6.5), so that
//! the residual, the cost and its gradient are those of the QR to rounding.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::super::frf::C64;
use super::lines::{Data, Weighed};
use super::shape::Shape;
use super::solution::{Eliminated, Follower};

/// Least squared sine between a column and those before it: keeps half of the digits in the steps and covariances.
const LEAST_PIVOT: f64 = 1e-8;

/// Weighted complex numbers of all lines, a column a line: real parts first, then imaginary ones.
fn rows(response: &Weighed, n: usize, mut of: impl FnMut(C64, &mut [C64])) -> DMatrix<f64> {
    let count = response.s.len();
    let mut matrix = DMatrix::zeros(n, 2 * count);
    let (re, im) = matrix.as_mut_slice().split_at_mut(n * count);
    let mut values = vec![C64::default(); n];
    for (line, (s, root)) in response.s.iter().zip(&response.root).enumerate() {
        of(*s, &mut values);
        let at = line * n..(line + 1) * n;
        for ((value, re), im) in values.iter().zip(&mut re[at.clone()]).zip(&mut im[at]) {
            (*re, *im) = (root * value.re, root * value.im);
        }
    }
    matrix
}

/// Root of a symmetric matrix scaled to a diagonal of 1 by `norms`, if all its pivots stand clear of rounding.
fn firm_root(matrix: &DMatrix<f64>, norms: &[f64]) -> Option<Cholesky<f64, Dyn>> {
    let n = matrix.nrows();
    let scaled = DMatrix::from_fn(n, n, |k, l| matrix[(k, l)] / (norms[k] * norms[l]));
    let root = scaled.cholesky()?;
    root.l_dirty().diagonal().iter().all(|d| d * d > LEAST_PIVOT).then_some(root)
}

fn norms(matrix: &DMatrix<f64>) -> Option<Vec<f64>> {
    let norms: Vec<f64> = matrix.diagonal().iter().map(|d| d.sqrt()).collect();
    norms.iter().all(|d| d.is_finite() && *d > 0.0).then_some(norms)
}

/// One response with its linear parameters solved for.
struct Block {
    columns: DMatrix<f64>,
    norms: Vec<f64>,
    root: Cholesky<f64, Dyn>,
    c: DVector<f64>,
    /// Weighted values less the model.
    residual: DVector<f64>,
}

impl Block {
    fn new(response: &Weighed, shape: &Shape, theta: &[f64]) -> Option<Self> {
        let columns = rows(response, shape.linear_count(), |s, out| shape.columns(theta, s, out));
        let gram = &columns * columns.transpose();
        let norms = norms(&gram)?;
        let root = firm_root(&gram, &norms)?;
        let weighted = |part: fn(&C64) -> f64| {
            response.value.iter().zip(&response.root).map(move |(v, root)| root * part(v))
        };
        let values: Vec<f64> = weighted(|v| v.re).chain(weighted(|v| v.im)).collect();
        let mut residual = DVector::from_vec(values);
        let mut c = DVector::zeros(norms.len());
        // The second turn takes out what the squared condition left.
        for _ in 0..2 {
            let mut step = &columns * &residual;
            scale_rows(&mut step, &norms);
            root.solve_mut(&mut step);
            scale_rows(&mut step, &norms);
            residual -= columns.tr_mul(&step);
            c += step;
        }
        c.iter().all(|v| v.is_finite()).then_some(Self { columns, norms, root, c, residual })
    }

    /// What the linear parameters leave of the slopes: information of θ and gradient, with the norms of the slopes
    /// before, and how c follows θ.
    fn slopes(&self, response: &Weighed, shape: &Shape, theta: &[f64]) -> Slopes {
        let c = self.c.as_slice();
        let slopes = rows(response, shape.nonlinear_count(), |s, out| shape.slopes(theta, c, s, out));
        let turned = slopes.transpose();
        let mut cross = &self.columns * &turned;
        for (mut row, norm) in cross.row_iter_mut().zip(&self.norms) {
            row.unscale_mut(*norm);
        }
        self.root.l_dirty().solve_lower_triangular_mut(&mut cross);
        let whole = &slopes * &turned;
        let information = &whole - cross.transpose() * &cross;
        Slopes { gradient: &slopes * &self.residual, whole: whole.diagonal(), information, cross }
    }
}

fn scale_rows(vector: &mut DVector<f64>, norms: &[f64]) {
    vector.iter_mut().zip(norms).for_each(|(v, norm)| *v /= norm);
}

struct Slopes {
    information: DMatrix<f64>,
    gradient: DVector<f64>,
    whole: DVector<f64>,
    /// L⁻¹ times the products of columns (of norm 1) and slopes.
    cross: DMatrix<f64>,
}

/// All responses with their linear parameters solved for.
pub(super) struct Normal {
    blocks: Vec<Block>,
    pub(super) cost: f64,
}

/// Second-order model of the cost around some θ.
pub(super) struct Model {
    pub(super) information: DMatrix<f64>,
    /// Half of the cost's fall over θ.
    pub(super) gradient: DVector<f64>,
    /// What a step without damping should lower the cost by.
    pub(super) decrement: f64,
    parts: Vec<DMatrix<f64>>,
}

impl Normal {
    /// `None` where the columns are too close to each other for normal equations, or a number overflows.
    pub(super) fn new(data: &Data, shape: &Shape, theta: &[f64]) -> Option<Self> {
        let block = |r| Block::new(r, shape, theta);
        let blocks = data.responses.iter().map(block).collect::<Option<Vec<_>>>()?;
        let cost = blocks.iter().map(|b| b.residual.norm_squared()).sum();
        Some(Self { blocks, cost })
    }

    /// `None` where a slope is too close to the columns and the other slopes.
    pub(super) fn model(&self, data: &Data, shape: &Shape, theta: &[f64]) -> Option<Model> {
        let n = shape.nonlinear_count();
        let mut information = DMatrix::zeros(n, n);
        let mut gradient = DVector::zeros(n);
        let mut whole = DVector::zeros(n);
        let mut parts = Vec::with_capacity(self.blocks.len());
        for (block, response) in self.blocks.iter().zip(&data.responses) {
            let slopes = block.slopes(response, shape, theta);
            information += slopes.information;
            gradient += slopes.gradient;
            whole += slopes.whole;
            parts.push(slopes.cross);
        }
        let norms = norms(&DMatrix::from_diagonal(&whole))?;
        let root = firm_root(&information, &norms)?;
        let mut scaled = gradient.clone();
        scale_rows(&mut scaled, &norms);
        let decrement = root.l_dirty().solve_lower_triangular(&scaled)?.norm_squared();
        decrement.is_finite().then_some(Model { information, gradient, decrement, parts })
    }

    /// What a solution is made of.
    pub(super) fn eliminated(&self, model: Model) -> Eliminated {
        let follower = |(block, mut follow): (&Block, DMatrix<f64>)| {
            block.root.l_dirty().tr_solve_lower_triangular_mut(&mut follow);
            for (mut row, norm) in follow.row_iter_mut().zip(&block.norms) {
                row.unscale_mut(*norm);
            }
            Follower { c: block.c.iter().copied().collect(), follow, held: block.held() }
        };
        let followers = self.blocks.iter().zip(model.parts).map(follower).collect();
        Eliminated { information: model.information, followers, cost: self.cost }
    }

    /// Linear parameters of each response with their inverse information at the θ given.
    pub(super) fn linear(&self) -> Vec<(Vec<f64>, DMatrix<f64>)> {
        self.blocks.iter().map(|b| (b.c.iter().copied().collect(), b.held())).collect()
    }
}

impl Block {
    fn held(&self) -> DMatrix<f64> {
        let inverse = self.root.inverse();
        let n = inverse.nrows();
        DMatrix::from_fn(n, n, |k, l| inverse[(k, l)] / (self.norms[k] * self.norms[l]))
    }
}
