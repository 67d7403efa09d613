//! Linear parameters eliminated: the cost and its slopes over the nonlinear parameters alone
//! (variable projection: Golub & Pereyra, *SIAM J. Numer. Anal.* 10, 413, 1973; slopes after Kaufman, *BIT* 15, 49, 1975).

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::linalg::QR;
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

use super::super::frf::C64;
use super::RationalError;
use super::lines::{Data, Weighed};
use super::normal::Normal;
use super::search::{self, End, search};
use super::shape::Shape;
use super::solution::{Eliminated, Held, Solution, dof};

/// Rows added for each linear parameter, over the norm of its column: two sections that meet on the way stay solvable.
const RIDGE: f64 = 1e-10;
/// Relative change of cost and parameters that ends the search: far below what noise moves them.
pub(super) const TOLERANCE: f64 = 1e-9;
/// Tolerance of the search by QR, which ends at the first step below it: at rounding, so that the end does not show the
/// way.
const QR_TOLERANCE: f64 = 1e-14;
/// Evaluations per parameter before the search is given up.
pub(super) const PATIENCE: usize = 60;

/// One response with its linear parameters solved for.
pub(super) struct Block {
    qr: QR<f64, Dyn, Dyn>,
    /// Qᵀ times the weighted values: the rows past the linear parameters are the residual.
    rotated: DVector<f64>,
    /// Linear parameters.
    pub(super) c: DVector<f64>,
}

/// Writes weighted complex numbers of one line into the columns of a matrix: real parts above imaginary ones.
fn put(matrix: &mut DMatrix<f64>, line: usize, count: usize, root: f64, values: &[C64]) {
    for (k, value) in values.iter().enumerate() {
        matrix[(line, k)] = root * value.re;
        matrix[(count + line, k)] = root * value.im;
    }
}

impl Block {
    fn new(response: &Weighed, shape: &Shape, theta: &[f64]) -> Option<Self> {
        let count = response.s.len();
        let n = shape.linear_count();
        let mut design = DMatrix::zeros(2 * count + n, n);
        let mut columns = vec![C64::default(); n];
        let mut rotated = DVector::zeros(2 * count + n);
        for (line, (s, root)) in response.s.iter().zip(&response.root).enumerate() {
            shape.columns(theta, *s, &mut columns);
            put(&mut design, line, count, *root, &columns);
            rotated[line] = root * response.value[line].re;
            rotated[count + line] = root * response.value[line].im;
        }
        for k in 0..n {
            design[(2 * count + k, k)] = RIDGE * design.column(k).norm();
        }
        let qr = design.qr();
        qr.q_tr_mul(&mut rotated);
        let c = qr.r().solve_upper_triangular(&rotated.rows(0, n).into_owned())?;
        c.iter().all(|v| v.is_finite()).then_some(Self { qr, rotated, c })
    }

    /// Qᵀ times the weighted slopes over the nonlinear parameters.
    pub(super) fn rotated_slopes(&self, response: &Weighed, shape: &Shape, theta: &[f64]) -> DMatrix<f64> {
        let count = response.s.len();
        let n = shape.nonlinear_count();
        let mut slopes = DMatrix::zeros(2 * count + shape.linear_count(), n);
        let mut row = vec![C64::default(); n];
        for (line, (s, root)) in response.s.iter().zip(&response.root).enumerate() {
            shape.slopes(theta, self.c.as_slice(), *s, &mut row);
            put(&mut slopes, line, count, *root, &row);
        }
        self.qr.q_tr_mul(&mut slopes);
        slopes
    }

    /// The triangle R of the linear parameters.
    pub(super) fn triangle(&self) -> DMatrix<f64> {
        self.qr.r()
    }

    /// The residual, rotated.
    fn residual(&self) -> &[f64] {
        &self.rotated.as_slice()[self.c.len()..]
    }
}

/// All responses with their linear parameters solved for, at some nonlinear ones.
pub(super) struct Projection {
    pub(super) blocks: Vec<Block>,
}

impl Projection {
    /// `None` where a pole stands on a line or a number overflows.
    pub(super) fn new(data: &Data, shape: &Shape, theta: &[f64]) -> Option<Self> {
        let blocks = data.responses.iter().map(|r| Block::new(r, shape, theta)).collect::<Option<_>>()?;
        Some(Self { blocks })
    }

    /// Sum of weighted squares of the residual.
    pub(super) fn cost(&self) -> f64 {
        self.blocks.iter().flat_map(Block::residual).map(|r| r * r).sum()
    }
}

struct Problem<'a> {
    data: &'a Data,
    shape: &'a Shape,
    theta: DVector<f64>,
    projection: Option<Projection>,
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.theta.copy_from(x);
        self.projection = Projection::new(self.data, self.shape, x.as_slice());
    }

    fn params(&self) -> DVector<f64> {
        self.theta.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let residuals = self.projection.as_ref()?.blocks.iter().flat_map(Block::residual).copied();
        Some(DVector::from_vec(residuals.collect()))
    }

    /// In the turned coordinates of each response, where projecting is leaving rows out.
    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let projection = self.projection.as_ref()?;
        let n = self.shape.linear_count();
        let rows = projection.blocks.iter().map(|b| b.rotated.len() - n).sum();
        let mut jacobian = DMatrix::zeros(rows, self.theta.len());
        let mut first = 0;
        for (block, response) in projection.blocks.iter().zip(&self.data.responses) {
            let slopes = block.rotated_slopes(response, self.shape, self.theta.as_slice());
            let count = slopes.nrows() - n;
            jacobian.rows_mut(first, count).copy_from(&(-slopes.rows(n, count)));
            first += count;
        }
        jacobian.iter().all(|v| v.is_finite()).then_some(jacobian)
    }
}

/// Cost at nonlinear parameters that are held.
pub(super) fn cost_at(data: &Data, shape: &Shape, theta: &[f64]) -> Option<f64> {
    let quick = Normal::new(data, shape, theta).map(|n| n.cost);
    quick.or_else(|| Projection::new(data, shape, theta).map(|p| p.cost()))
}

/// Minimises the cost from `start`: by normal equations, and from where those lose their footing or their way by QR.
///
/// # Errors
/// [`RationalError::TooFew`], [`RationalError::NotConverged`] or [`RationalError::Dependent`].
pub(crate) fn solve(data: &Data, shape: &Shape, start: &[f64]) -> Result<Solution, RationalError> {
    check_count(data, shape)?;
    if start.is_empty() {
        return by_qr(data, shape, &[]);
    }
    match search(data, shape, start) {
        End::Found(theta, eliminated) => Solution::new(data, shape, &theta, *eliminated),
        End::Ill(theta) => solve_by_qr(data, shape, &theta),
        End::Lost => solve_by_qr(data, shape, start),
    }
}

/// The minimum of `solution` to rounding; as it is where it was found by QR.
///
/// # Errors
/// [`RationalError::Dependent`].
pub(crate) fn settle(data: &Data, solution: Solution) -> Result<Solution, RationalError> {
    match search::settled(data, &solution.shape, &solution.theta) {
        Some((theta, eliminated)) if !theta.is_empty() => {
            Solution::new(data, &solution.shape, &theta, eliminated)
        }
        _ => Ok(solution),
    }
}

/// The search by QR alone.
pub(super) fn solve_by_qr(data: &Data, shape: &Shape, start: &[f64]) -> Result<Solution, RationalError> {
    let mut problem = Problem { data, shape, theta: DVector::from_column_slice(start), projection: None };
    let theta = problem.theta.clone();
    problem.set_params(&theta);
    let search = LevenbergMarquardt::new()
        .with_ftol(QR_TOLERANCE)
        .with_xtol(QR_TOLERANCE)
        .with_gtol(QR_TOLERANCE)
        .with_patience(PATIENCE);
    let (solved, report) = search.minimize(problem);
    // At an exact fit rounding ends the search before any tolerance does.
    let rounding = matches!(report.termination, TerminationReason::NoImprovementPossible(_));
    if !report.termination.was_successful() && !rounding {
        return Err(RationalError::NotConverged);
    }
    let theta = solved.theta.as_slice();
    let projection = solved.projection.as_ref().ok_or(RationalError::NotConverged)?;
    Solution::new(data, shape, theta, Eliminated::new(data, shape, theta, projection)?)
}

/// At nonlinear parameters that are held, by QR.
pub(super) fn by_qr(data: &Data, shape: &Shape, theta: &[f64]) -> Result<Solution, RationalError> {
    let projection = Projection::new(data, shape, theta).ok_or(RationalError::Dependent)?;
    Solution::new(data, shape, theta, Eliminated::new(data, shape, theta, &projection)?)
}

/// The linear parameters, with their inverse information, for nonlinear ones that are held as they are given.
///
/// # Errors
/// [`RationalError::Dependent`].
pub(crate) fn evaluate(data: &Data, shape: &Shape, theta: &[f64]) -> Result<Held, RationalError> {
    let quick = Normal::new(data, shape, theta).map(|n| Held::new(&n, dof(data, shape)));
    quick.map_or_else(|| by_qr(data, shape, theta).map(Held::from), Ok)
}

/// Three lines per unknown: what is asked for before an uncertainty is believed.
pub(super) fn check_count(data: &Data, shape: &Shape) -> Result<(), RationalError> {
    let unknowns = shape.nonlinear_count() + data.responses.len() * shape.linear_count();
    let lines = data.line_count();
    let needed = super::LINES_PER_UNKNOWN * unknowns;
    if lines < needed { Err(RationalError::TooFew { lines, unknowns, needed }) } else { Ok(()) }
}
