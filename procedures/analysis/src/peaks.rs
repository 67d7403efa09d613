//! Peaks over noise: single samples that no Gaussian has.

use crate::estimate::Estimate;

/// Fewest values that have a noise.
const LEAST: usize = 32;
/// Standard deviation of a Gaussian over the median of its absolute values.
pub const PER_MEDIAN: f64 = 1.4826;
/// Relative uncertainty of a deviation that is found so, times √n: it is 37 % efficient (Rousseeuw & Croux, *J. Am. Stat.
/// Assoc.* 88 (1993) 1273), so √(1/(2·0.37)).
const ROOT_N_U: f64 = 1.17;

/// Largest departure from the median over the standard deviation that the middle half of the values has, as a Gaussian
/// would; uncertainty by that of the deviation. `None` for fewer than 32 values, and where half of them are one value.
pub fn peak_ratio(values: &[f64]) -> Option<Estimate> {
    if values.len() < LEAST {
        return None;
    }
    let middle = median(values.to_vec());
    let off: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
    let largest = off.iter().copied().fold(0.0, f64::max);
    let deviation = PER_MEDIAN * median(off);
    let n = values.len();
    let value = largest / deviation;
    let u = value * ROOT_N_U / (n as f64).sqrt();
    (deviation > 0.0).then_some(Estimate { value, u, dof: n as f64, n })
}

/// Middle of the values by size, the mean of both where they are even in number; 0 without values.
pub fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gaussian enough: the sum of twelve uniform numbers less six, of a linear congruential generator.
    fn noise(n: usize) -> Vec<f64> {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..n).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
    }

    #[test]
    fn one_wrong_sample_is_the_peak_and_does_not_widen_the_noise() {
        let mut values = noise(6000);
        let quiet = peak_ratio(&values).expect("enough values").value;
        assert!((3.0..5.0).contains(&quiet), "{quiet}");
        values[1234] = -40.0;
        let found = peak_ratio(&values).expect("enough values");
        assert!((found.value - 40.0).abs() < 3.0 * found.u, "{found:?}");
        assert_eq!(peak_ratio(&[1.0; 100]), None);
    }
}
