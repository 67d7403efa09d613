//! Differences of phases m apart: second ones (Allan) and third ones (Hadamard).

use rayon::prelude::*;

/// Starts of terms that are taken together: their phases stay in the cache while all factors pass over them.
const BLOCK: usize = 1 << 12;
/// Blocks of one task, so that a thread walks along the record and finds in its cache what it has just read.
const RUN: usize = 32;
/// Partial sums that run side by side.
const LANES: usize = 8;

/// Sum of squares of D-th differences without overlap, and their number.
pub(super) fn apart<const D: usize>(x: &[f64], m: usize) -> (f64, usize) {
    let terms = (x.len() - 1) / m - (D - 1);
    let one = |k: usize| difference::<D>(x, k * m, m).powi(2);
    let blocks: Vec<f64> = (0..terms.div_ceil(BLOCK))
        .into_par_iter()
        .map(|b| (b * BLOCK..terms.min((b + 1) * BLOCK)).map(one).sum())
        .collect();
    (blocks.iter().sum(), terms)
}

fn difference<const D: usize>(x: &[f64], at: usize, m: usize) -> f64 {
    if D == 2 {
        (x[at + 2 * m] - x[at + m]) - (x[at + m] - x[at])
    } else {
        (x[at + 3 * m] - x[at]) - 3.0 * (x[at + 2 * m] - x[at + m])
    }
}

/// Mean squares of overlapping differences, for many factors in one pass: each block of starts is read once from memory and meets all
/// factors there. Blocks are summed in order, whatever thread had them.
pub(super) fn overlapping<const D: usize>(x: &[f64], factors: &[usize]) -> Vec<(f64, usize)> {
    let terms = |m: usize| x.len() - D * m;
    let starts = factors.iter().map(|&m| terms(m)).max().unwrap_or(0);
    let runs: Vec<Vec<f64>> = (0..starts.div_ceil(BLOCK * RUN))
        .into_par_iter()
        .map(|run| {
            let mut sums = vec![0.0; factors.len()];
            for from in (run * BLOCK * RUN..starts.min((run + 1) * BLOCK * RUN)).step_by(BLOCK) {
                for (sum, &m) in sums.iter_mut().zip(factors) {
                    *sum += block::<D>(x, from, terms(m).min(from + BLOCK), m);
                }
            }
            sums
        })
        .collect();
    let sum = |k: usize| runs.iter().map(|sums| sums[k]).sum();
    factors.iter().enumerate().map(|(k, &m)| (sum(k), terms(m))).collect()
}

/// Sum over terms that start in `from..to`.
fn block<const D: usize>(x: &[f64], from: usize, to: usize, m: usize) -> f64 {
    if from >= to {
        return 0.0;
    }
    let shifted = |k: usize| &x[from + k * m..to + k * m];
    let a = shifted(0);
    let b = shifted(1);
    let c = shifted(2);
    if D == 2 {
        squares(a, b, c, |_, a, b, c| (c - b) - (b - a))
    } else {
        let d = shifted(3);
        squares(a, b, c, |k, a, b, c| (d[k] - a) - 3.0 * (c - b))
    }
}

/// Sum of squares of `term` (index, three phases), in lanes that the compiler turns into vectors.
#[inline(always)]
fn squares(a: &[f64], b: &[f64], c: &[f64], term: impl Fn(usize, f64, f64, f64) -> f64) -> f64 {
    let whole = a.len() / LANES * LANES;
    let mut lanes = [0.0; LANES];
    for k in (0..whole).step_by(LANES) {
        let part = k..k + LANES;
        let a = &a[part.clone()];
        let b = &b[part.clone()];
        let c = &c[part];
        for lane in 0..LANES {
            let value = term(k + lane, a[lane], b[lane], c[lane]);
            lanes[lane] += value * value;
        }
    }
    let rest: f64 = (whole..a.len()).map(|k| term(k, a[k], b[k], c[k]).powi(2)).sum();
    lanes.iter().sum::<f64>() + rest
}
