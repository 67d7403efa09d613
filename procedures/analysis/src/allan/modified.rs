//! Statistics of phases averaged over a window: modified and parabolic.

use rayon::prelude::*;

/// Windows that are reached from one that was summed afresh, at least: rounding does not gather beyond them.
const LEAST_BLOCK: usize = 1 << 12;

/// Sum over all windows of m phases of the square of their mean second difference, and the number of windows
/// (NIST SP 1065, modified Allan variance).
pub(super) fn modified(x: &[f64], m: usize) -> (f64, usize) {
    let terms = x.len() - 3 * m + 1;
    let second = |k: usize| (x[k + 2 * m] - x[k + m]) - (x[k + m] - x[k]);
    let block = |from: usize, to: usize| {
        let mut window: f64 = (from..from + m).map(second).sum();
        let mut sum = window * window;
        for k in from..to - 1 {
            window += second(k + m) - second(k);
            sum += window * window;
        }
        sum
    };
    (in_blocks(terms, m, block) / (m * m) as f64, terms)
}

/// Sum over windows of the square of Σ ((m−1)/2 − k)·(x_{i+k} − x_{i+m+k}) over m², and the number of windows (Vernotte,
/// Lenczner, Bourgeois & Rubiola, *IEEE Trans. UFFC* 63, 611, 2016, equation 18); for m = 1 that of the Allan variance.
pub(super) fn parabolic(x: &[f64], m: usize) -> (f64, usize) {
    if m == 1 {
        // 72 stands in front of the one, 1/2 in front of the other.
        let (sum, terms) = super::plain::apart::<2>(x, 1);
        return (sum / 144.0, terms);
    }
    let terms = x.len() - 2 * m;
    let gap = |k: usize| x[k] - x[k + m];
    let centre = (m - 1) as f64 / 2.0;
    let block = |from: usize, to: usize| {
        let mut plain: f64 = (from..from + m).map(gap).sum();
        let mut tilted: f64 = (0..m).map(|k| (centre - k as f64) * gap(from + k)).sum();
        let mut sum = tilted * tilted;
        for k in from..to - 1 {
            let first = gap(k);
            let next = gap(k + m);
            // Weights move up by one: all but the first gain 1, the newcomer has the last weight.
            tilted += plain - first - centre * first - centre * next;
            plain += next - first;
            sum += tilted * tilted;
        }
        sum
    };
    let m2 = (m * m) as f64;
    (in_blocks(terms, m, block) / (m2 * m2), terms)
}

/// Sums `block(from, to)` over blocks of `terms`, in order.
fn in_blocks(terms: usize, m: usize, block: impl Fn(usize, usize) -> f64 + Sync) -> f64 {
    let length = m.max(LEAST_BLOCK);
    let parts: Vec<f64> = (0..terms.div_ceil(length))
        .into_par_iter()
        .map(|b| block(b * length, terms.min((b + 1) * length)))
        .collect();
    parts.iter().sum()
}
