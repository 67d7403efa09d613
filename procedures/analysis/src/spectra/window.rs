//! Windows, and how many independent averages overlapping segments are worth.

use std::f64::consts::TAU;

/// Weight of the samples of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// ½ − ½·cos(2πn/N), periodic: for everything that is not periodic in the segment.
    Hann,
    /// All samples alike: for whole periods.
    Rectangular,
}

/// What is taken off each segment before the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detrend {
    /// Nothing.
    None,
    /// The mean of the segment is taken off.
    Constant,
}

impl Window {
    pub(super) fn weights(self, samples: usize) -> Vec<f64> {
        match self {
            Self::Hann => (0..samples).map(|n| 0.5 - 0.5 * (TAU * n as f64 / samples as f64).cos()).collect(),
            Self::Rectangular => vec![1.0; samples],
        }
    }
}

/// Number of independent averages that has the variance of the average over these segments.
///
/// Powers of two segments `lag` samples apart correlate by ρ = (Σ w(n)·w(n + lag) / Σ w²)² (white Gaussian
/// noise; Welch 1967, eq. 9; Harris, *Proc. IEEE* 66, 51, 1978, eq. 17), so Var{Ŝ}/S² = K⁻²·ΣΣρ and n_d =
/// K²/ΣΣρ. Hann at half overlap has ρ = 1/36: n_d = K/(1 + (1 − 1/K)/18) → 0.947·K.
pub(super) fn averages(starts: &[usize], weights: &[f64]) -> f64 {
    let n = weights.len();
    let mut sorted = starts.to_vec();
    sorted.sort_unstable();
    let mut pairs_of_lag = vec![0_usize; n];
    for (i, &a) in sorted.iter().enumerate() {
        sorted[i + 1..].iter().take_while(|&&b| b - a < n).for_each(|&b| pairs_of_lag[b - a] += 1);
    }
    let power: f64 = weights.iter().map(|w| w * w).sum();
    let correlation = |lag: usize| -> f64 {
        let common: f64 = weights.iter().zip(&weights[lag..]).map(|(a, b)| a * b).sum();
        (common / power).powi(2)
    };
    let overlapping = pairs_of_lag.iter().enumerate().filter(|(_, pairs)| **pairs > 0);
    let double_sum: f64 = overlapping.map(|(lag, &pairs)| 2.0 * pairs as f64 * correlation(lag)).sum();
    let segments = starts.len() as f64;
    segments * segments / (segments + double_sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn starts(count: usize, hop: usize) -> Vec<usize> {
        (0..count).map(|k| k * hop).collect()
    }

    #[test]
    fn hann_at_half_overlap_is_worth_0947_of_its_segments() {
        let weights = Window::Hann.weights(256);
        let found = averages(&starts(1000, 128), &weights);
        let expected = 1000.0 / (1.0 + 0.999 / 18.0);
        assert!((found - expected).abs() < 1e-6 * expected, "{found} against {expected}");
        assert!((found / 1000.0 - 0.947).abs() < 5e-4);
    }

    #[test]
    fn segments_that_share_nothing_count_in_full_and_one_twice_counts_once() {
        for window in [Window::Hann, Window::Rectangular] {
            let weights = window.weights(64);
            assert_eq!(averages(&starts(7, 64), &weights), 7.0);
            assert!((averages(&[100, 100], &weights) - 1.0).abs() < 1e-12);
        }
    }

    /// ρ(lag) = (1 − lag/N)² for the rectangle: at half overlap K/(1 + 2·(1 − 1/K)/4).
    #[test]
    fn rectangle_at_half_overlap_loses_a_third() {
        let found = averages(&starts(50, 32), &Window::Rectangular.weights(64));
        assert!((found - 50.0 / (1.0 + 0.5 * 0.98)).abs() < 1e-9, "{found}");
    }

    #[test]
    fn order_of_the_segments_does_not_matter() {
        let weights = Window::Hann.weights(64);
        assert_eq!(averages(&[300, 0, 32, 400], &weights), averages(&[0, 32, 300, 400], &weights));
    }
}
