//! Ranks of samples, and their correlation (C. Spearman, *Am. J. Psychol.* 15, 72, 1904).

/// Ranks from 1 on; equal values share the mean of their ranks.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut below = 0;
    for equal in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let mean = below as f64 + 0.5 * (equal.len() as f64 + 1.0);
        equal.iter().for_each(|&k| ranks[k] = mean);
        below += equal.len();
    }
    ranks
}

/// Spearman's rank correlation of two samples of the same units, -1 to 1; `None` below three units, where lengths differ, or
/// where all values of one sample are equal or one is not a number.
pub fn spearman(first: &[f64], second: &[f64]) -> Option<f64> {
    let is_number = |values: &[f64]| values.iter().all(|value| !value.is_nan());
    if first.len() < 3 || first.len() != second.len() || !is_number(first) || !is_number(second) {
        return None;
    }
    let [first, second] = [first, second].map(ranks);
    let mean = 0.5 * (first.len() as f64 + 1.0);
    let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let scale = (sum(&first, &first) * sum(&second, &second)).sqrt();
    (scale > 0.0).then(|| sum(&first, &second) / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_monotonic_relation_has_the_rank_correlation_one_and_an_inverse_one_minus_one() {
        let x = [0.1, 3.0, 2.0, 7.0, 5.0];
        let cubes: Vec<f64> = x.iter().map(|x: &f64| x.powi(3)).collect();
        let inverse: Vec<f64> = x.iter().map(|x| 1.0 / x).collect();
        assert!((spearman(&x, &cubes).expect("values") - 1.0).abs() < 1e-12);
        assert!((spearman(&x, &inverse).expect("values") + 1.0).abs() < 1e-12);
    }

    /// The linear correlation of the ranks, ties among them, by `statistics.correlation` of Python 3.11.
    #[test]
    fn equal_values_share_their_rank() {
        assert_eq!(ranks(&[2.0, 1.0, 2.0, 5.0]), [2.5, 1.0, 2.5, 4.0]);
        let found = spearman(&[1.0, 2.0, 2.0, 3.0, 4.0], &[2.0, 1.0, 3.0, 3.0, 5.0]).expect("values");
        assert!((found - 0.763_157_894_736_842_1).abs() < 1e-12, "{found}");
    }

    #[test]
    fn a_constant_sample_and_one_of_two_units_have_no_correlation() {
        assert_eq!(spearman(&[1.0, 1.0, 1.0], &[1.0, 2.0, 3.0]), None);
        assert_eq!(spearman(&[1.0, 2.0], &[1.0, 2.0]), None);
        assert_eq!(spearman(&[1.0, 2.0, f64::NAN], &[1.0, 2.0, 3.0]), None);
        assert_eq!(spearman(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0, 4.0]), None);
    }
}
