//! Poles of all orders by a common denominator in z = e^(sT): least squares complex frequency domain
//! (Guillaume et al., *Proc. IMAC 21*, 2003; Cauberghe, thesis, Vrije Universiteit Brussel, 2004).

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::super::frf::C64;
use super::super::rational::lines::{Data, Weighed};

/// Ridge on the normal equations over their mean diagonal, at rounding.
const RIDGE: f64 = 1e-14;

/// Reduced normal equations of the denominator, for every order up to the largest at once.
///
/// The equation error `w·(A(z)·H − B(z))` gives for each response Toeplitz matrices R (of B), S (mixed) and T (of A).
/// With R = L·Lᵀ and Y = L⁻¹·S the equations of order n are the leading (n+1) square of T − YₙᵀYₙ, Yₙ the leading
/// square of Y: factored once, read at every order.
pub(super) struct Lscf {
    parts: Vec<(DMatrix<f64>, DMatrix<f64>)>,
    step: f64,
}

/// Σ value·cos and Σ value·sin of k·ωT for k = 0…n.
fn moments(response: &Weighed, step: f64, values: &[C64], n: usize) -> Vec<C64> {
    let mut sums = vec![C64::default(); n + 1];
    for (s, value) in response.s.iter().zip(values) {
        let turn = C64::from_polar(1.0, s.im * step);
        let mut z = *value;
        for sum in &mut sums {
            *sum += z;
            z *= turn;
        }
    }
    sums
}

impl Lscf {
    /// Sums up to `order`; `None` if the lines do not determine that many numerator coefficients.
    pub(super) fn new(data: &Data, order: usize) -> Option<Self> {
        // The highest line stands at z = −1; scaled frequencies end at 1.
        let step = PI;
        let parts = data.responses.iter().map(|r| part(r, step, order)).collect::<Option<_>>()?;
        Some(Self { parts, step })
    }

    /// Poles of one order in scaled frequency: those in the upper half plane, stable and unstable alike.
    ///
    /// The lowest coefficient is held at 1: poles that the order has to spare come out unstable.
    pub(super) fn poles(&self, order: usize) -> Option<Vec<C64>> {
        let n = order + 1;
        let mut normal = DMatrix::zeros(n, n);
        for (t, y) in &self.parts {
            let y = y.view((0, 0), (n, n));
            normal += t.view((0, 0), (n, n)) - y.tr_mul(&y);
        }
        let ridge = RIDGE * normal.trace() / n as f64;
        let mut inner = normal.view((1, 1), (order, order)).into_owned();
        (0..order).for_each(|k| inner[(k, k)] += ridge);
        let rhs: DVector<f64> = -normal.view((1, 0), (order, 1)).column(0).into_owned();
        let a = inner.lu().solve(&rhs)?;
        let lead = a[order - 1];
        let mut companion = DMatrix::zeros(order, order);
        (1..order).for_each(|k| companion[(k, k - 1)] = 1.0);
        companion[(0, order - 1)] = -1.0 / lead;
        (1..order).for_each(|k| companion[(k, order - 1)] = -a[k - 1] / lead);
        if companion.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let roots = companion.complex_eigenvalues();
        let poles = roots.iter().filter(|z| z.im > 0.0).map(|z| z.ln() / self.step);
        Some(poles.filter(|p| p.re.is_finite()).collect())
    }
}

fn part(response: &Weighed, step: f64, order: usize) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let weighted = |f: &dyn Fn(C64) -> C64| -> Vec<C64> {
        response.value.iter().zip(&response.root).map(|(h, w)| f(*h) * (w * w)).collect()
    };
    let ones = moments(response, step, &weighted(&|_| C64::new(1.0, 0.0)), order);
    let squares = moments(response, step, &weighted(&|h| C64::new(h.norm_sqr(), 0.0)), order);
    let n = order + 1;
    let toeplitz = |m: &[C64]| DMatrix::from_fn(n, n, |i, k| m[i.abs_diff(k)].re);
    // Re Σ w²·conj(z^i)·H·z^k = Re Σ w²·H·z^(k−i).
    let mixed = |values: &[C64]| moments(response, step, values, order);
    let ahead = mixed(&weighted(&|h| h));
    let behind = mixed(&weighted(&|h| h.conj()));
    let s = DMatrix::from_fn(n, n, |i, k| if k >= i { -ahead[k - i].re } else { -behind[i - k].re });
    let mut r = toeplitz(&ones);
    let ridge = RIDGE * r.trace() / n as f64;
    (0..n).for_each(|k| r[(k, k)] += ridge);
    let root = r.cholesky()?;
    Some((toeplitz(&squares), root.l_dirty().solve_lower_triangular(&s)?))
}
