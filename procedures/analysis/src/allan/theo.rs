//! Thêo1.

use rayon::prelude::*;

/// Sum of Thêo1's terms over all starts, and their number N − m for N phases (Howe & Peppler, *IEEE Trans. UFFC* 50,
/// 2003; NIST SP 1065); m is even.
pub(super) fn theo1(x: &[f64], m: usize) -> (f64, usize) {
    let half = m / 2;
    let terms = x.len() - m;
    let one = |i: usize| -> f64 {
        let term = |d: usize| {
            let change = (x[i] - x[i + half - d]) + (x[i + m] - x[i + half + d]);
            change * change / (half - d) as f64
        };
        (0..half).map(term).sum()
    };
    let each: Vec<f64> = (0..terms).into_par_iter().map(one).collect();
    (each.iter().sum(), terms)
}
