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
    let off = departures(values);
    let largest = off.iter().copied().fold(0.0, f64::max);
    let deviation = PER_MEDIAN * median(off);
    let n = values.len();
    let value = largest / deviation;
    let u = value * ROOT_N_U / (n as f64).sqrt();
    (deviation > 0.0).then_some(Estimate { value, u, dof: n as f64, n })
}

/// Standard deviation that the middle half of the values has, as a Gaussian would: what is far off does not widen it.
pub fn deviation_by_median(values: &[f64]) -> f64 {
    PER_MEDIAN * median(departures(values))
}

/// Magnitudes of the departures from the median.
fn departures(values: &[f64]) -> Vec<f64> {
    let middle = median(values.to_vec());
    values.iter().map(|value| (value - middle).abs()).collect()
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
    use crate::synthetic_noise::gaussian;

    #[test]
    fn one_wrong_sample_is_the_peak_and_does_not_widen_the_noise() {
        let mut noise = gaussian(1);
        let mut values: Vec<f64> = (0..6000).map(|_| noise()).collect();
        let quiet = peak_ratio(&values).expect("enough values").value;
        assert!((3.0..5.0).contains(&quiet), "{quiet}");
        values[1234] = -40.0;
        let found = peak_ratio(&values).expect("enough values");
        assert!((found.value - 40.0).abs() < 3.0 * found.u, "{found:?}");
        assert_eq!(peak_ratio(&[1.0; 100]), None);
    }
}
