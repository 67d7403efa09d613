//! Complex linear least squares for small, well scaled problems.

use super::C64;

/// Part of a column's length that must be independent of the columns before it.
const LEAST_INDEPENDENCE: f64 = 1e-11;

/// A solution with the root of its covariance.
pub(super) struct Solution {
    /// Coefficients.
    pub(super) coefficients: Vec<C64>,
    /// R⁻¹ by columns, upper triangular: R⁻¹·R⁻ᴴ is the covariance for weights 1/σ.
    pub(super) root: Vec<Vec<C64>>,
}

/// Minimises |b − A·x|² by modified Gram–Schmidt on the columns (Björck, *Numerical Methods for Least Squares Problems*,
/// §2.4.2); `None` where columns depend on each other.
pub(super) fn least_squares(mut columns: Vec<Vec<C64>>, mut rhs: Vec<C64>) -> Option<Solution> {
    let n = columns.len();
    let mut r = vec![vec![C64::default(); n]; n];
    let mut projected = vec![C64::default(); n];
    let lengths: Vec<f64> = columns.iter().map(|c| norm(c)).collect();
    for j in 0..n {
        let length = norm(&columns[j]);
        if length.is_nan() || length <= LEAST_INDEPENDENCE * lengths[j] {
            return None;
        }
        r[j][j] = C64::from(length);
        let (done, rest) = columns.split_at_mut(j + 1);
        let unit = &mut done[j];
        unit.iter_mut().for_each(|v| *v /= length);
        for (k, column) in rest.iter_mut().enumerate() {
            r[j][j + 1 + k] = remove(unit, column);
        }
        projected[j] = remove(unit, &mut rhs);
    }
    let coefficients = back(&r, &projected);
    let root = (0..n)
        .map(|k| back(&r, &(0..n).map(|i| C64::from(f64::from(u8::from(i == k)))).collect::<Vec<_>>()))
        .collect();
    Some(Solution { coefficients, root })
}

fn norm(column: &[C64]) -> f64 {
    column.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt()
}

/// Takes the part along `unit` out of `column`.
fn remove(unit: &[C64], column: &mut [C64]) -> C64 {
    let along: C64 = unit.iter().zip(column.iter()).map(|(u, v)| u.conj() * v).sum();
    column.iter_mut().zip(unit).for_each(|(v, u)| *v -= along * u);
    along
}

/// Solves R·x = y for upper triangular R.
fn back(r: &[Vec<C64>], y: &[C64]) -> Vec<C64> {
    let mut x = y.to_vec();
    for i in (0..y.len()).rev() {
        let known: C64 = (i + 1..y.len()).map(|k| r[i][k] * x[k]).sum();
        x[i] = (x[i] - known) / r[i][i];
    }
    x
}
