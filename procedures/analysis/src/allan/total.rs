//! Total variances: the record is continued by reflection, so that the longest averages count more than once.

use rayon::prelude::*;

/// Total variance: sum of squared second differences of the phases, continued at both ends by the reflection
/// 2·x_end − x, centred on all phases but the ends (NIST SP 1065).
pub(super) fn total(x: &[f64], m: usize) -> (f64, usize) {
    let last = x.len() - 1;
    let continued = |k: isize| -> f64 {
        match usize::try_from(k) {
            Err(_) => 2.0 * x[0] - x[k.unsigned_abs()],
            Ok(k) if k > last => 2.0 * x[last] - x[2 * last - k],
            Ok(k) => x[k],
        }
    };
    let m = m as isize;
    let one = |k: usize| {
        let k = k as isize;
        ((continued(k + m) - continued(k)) - (continued(k) - continued(k - m))).powi(2)
    };
    let terms: Vec<f64> = (1..last).into_par_iter().map(one).collect();
    (terms.iter().sum(), last - 1)
}

/// Modified (of phases) and Hadamard (of rates) total variance: each stretch of 3m values, freed of its half-average
/// slope, is continued by itself backwards on both sides; the mean square of second differences of means over m, over
/// the 6m places where they fit. Returns the sum over stretches and their number (NIST SP 1065).
pub(super) fn reflected(values: &[f64], m: usize) -> (f64, usize) {
    let stretches = values.len() + 1 - 3 * m;
    let each: Vec<f64> =
        (0..stretches).into_par_iter().map(|k| of_stretch(&values[k..k + 3 * m], m)).collect();
    (each.iter().sum(), stretches)
}

fn of_stretch(stretch: &[f64], m: usize) -> f64 {
    let n = stretch.len();
    let half = n / 2;
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let slope = (mean(&stretch[n - half..]) - mean(&stretch[..half])) / (n - half) as f64;
    let free = |k: usize| stretch[k] - slope * k as f64;
    let reflected = |k: usize| match k / n {
        0 => free(n - 1 - k),
        1 => free(k - n),
        _ => free(3 * n - 1 - k),
    };
    let level = free(0);
    let mut sums = Vec::with_capacity(3 * n + 1);
    sums.push(0.0);
    for k in 0..3 * n {
        sums.push(sums[k] + (reflected(k) - level));
    }
    let square = |k: usize| {
        let [a, b, c, d] = [sums[k], sums[k + m], sums[k + 2 * m], sums[k + 3 * m]];
        ((b - a) - 2.0 * (c - b) + (d - c)).powi(2)
    };
    (0..2 * n).map(square).sum::<f64>() / (2 * n) as f64 / (m * m) as f64
}
