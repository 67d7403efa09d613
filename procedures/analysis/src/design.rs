//! Points of the unit cube that cover it more evenly than independent ones: Latin hypercubes and scrambled Sobol points.
//!
//! Means over such points scatter less than over independent ones, but their scatter cannot be told from the points of one
//! set. So a study takes several sets, each randomised on its own, and tells the scatter from how their results differ.
//!
//! Latin hypercube: M. D. McKay, R. J. Beckman, W. J. Conover, *Technometrics* 21, 239 (1979). Scrambling: A. B. Owen, *J.
//! Complexity* 14, 466 (1998), by the hash of B. Burley, *J. Comput. Graph. Tech.* 9 (4), 1 (2020).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Dimensions for which there are Sobol points.
pub const MOST_SOBOL_DIMENSIONS: usize = sobol_burley::NUM_DIMENSIONS as usize;
/// Points of one Sobol set.
pub const MOST_SOBOL_POINTS: usize = 1 << 16;

/// Why there are no points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DesignError {
    /// No direction numbers for so many dimensions.
    #[error("Sobol points of {dimensions} dimensions; expected at most {MOST_SOBOL_DIMENSIONS}")]
    Dimensions {
        /// Dimensions.
        dimensions: usize,
    },
    /// The sequence ends before.
    #[error("a set of {points} Sobol points; expected at most {MOST_SOBOL_POINTS}")]
    Points {
        /// Points.
        points: usize,
    },
}

/// A Latin hypercube: in every dimension one point lies in each of `points` equal slices of (0, 1), at a random place of it.
///
/// A pure function of its arguments; `stream` numbers the randomisations of one seed.
pub fn latin_hypercube(points: usize, dimensions: usize, seed: u64, stream: u64) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    let mut all = vec![Vec::with_capacity(dimensions); points];
    for _ in 0..dimensions {
        let mut slices: Vec<usize> = (0..points).collect();
        shuffle(&mut slices, &mut random);
        for (point, slice) in all.iter_mut().zip(slices) {
            point.push((slice as f64 + uniform(random.next_u64())) / points as f64);
        }
    }
    all
}

/// The first points of a scrambled Sobol sequence. A number of points that is a power of two covers the cube best.
///
/// A pure function of its arguments; `stream` numbers the randomisations of one seed.
///
/// # Errors
/// More dimensions or points than the sequence has.
pub fn scrambled_sobol(
    points: usize,
    dimensions: usize,
    seed: u64,
    stream: u64,
) -> Result<Vec<Vec<f64>>, DesignError> {
    if dimensions > MOST_SOBOL_DIMENSIONS {
        return Err(DesignError::Dimensions { dimensions });
    }
    if points > MOST_SOBOL_POINTS {
        return Err(DesignError::Points { points });
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    let scrambling = random.next_u32();
    // The points are multiples of 2⁻²⁴ from 0 on; half a step keeps them off 0, where a quantile may be infinite.
    const HALF_STEP: f64 = 0.5 / (1_u32 << 24) as f64;
    let coordinate = |point: usize, dimension: usize| {
        f64::from(sobol_burley::sample(point as u32, dimension as u32, scrambling)) + HALF_STEP
    };
    Ok((0..points).map(|k| (0..dimensions).map(|d| coordinate(k, d)).collect()).collect())
}

/// A number of (0, 1) from 64 random bits, with 53 digits; never an end.
fn uniform(bits: u64) -> f64 {
    ((bits >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

/// Every order is as likely (R. Durstenfeld, *Commun. ACM* 7, 420, 1964).
fn shuffle(items: &mut [usize], random: &mut ChaCha8Rng) {
    for last in (1..items.len()).rev() {
        let chosen = (uniform(random.next_u64()) * (last + 1) as f64) as usize;
        items.swap(last, chosen.min(last));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Standard deviation of the mean of a smooth function of ten dimensions, over 40 sets of 64 points.
    fn scatter(sets: impl Fn(u64) -> Vec<Vec<f64>>) -> f64 {
        let function = |point: &Vec<f64>| point.iter().map(|x| (x - 0.5).exp()).sum::<f64>();
        let mean = |points: &[Vec<f64>]| points.iter().map(function).sum::<f64>() / points.len() as f64;
        let means: Vec<f64> = (0..40).map(|stream| mean(&sets(stream))).collect();
        let expected = 10.0 * (0.5_f64.exp() - (-0.5_f64).exp());
        let all = means.iter().sum::<f64>() / 40.0;
        assert!((all - expected).abs() < 0.05, "unbiased: {all}, not {expected}");
        (means.iter().map(|mean| (mean - all).powi(2)).sum::<f64>() / 39.0).sqrt()
    }

    fn independent(stream: u64) -> Vec<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        random.set_stream(stream);
        (0..64).map(|_| (0..10).map(|_| uniform(random.next_u64())).collect()).collect()
    }

    #[test]
    fn means_over_both_designs_scatter_far_less_than_over_independent_points() {
        let independent = scatter(independent);
        let latin = scatter(|stream| latin_hypercube(64, 10, 3, stream));
        let sobol = scatter(|stream| scrambled_sobol(64, 10, 3, stream).expect("few"));
        assert!(latin < 0.1 * independent && sobol < 0.1 * independent, "{independent} {latin} {sobol}");
    }

    #[test]
    fn every_slice_of_every_dimension_has_one_point() {
        let sobol = scrambled_sobol(64, 200, 7, 2).expect("few");
        for points in [latin_hypercube(60, 200, 7, 2), sobol] {
            let count = points.len();
            for dimension in 0..200 {
                let mut slices: Vec<usize> =
                    points.iter().map(|point| (point[dimension] * count as f64) as usize).collect();
                slices.sort_unstable();
                assert!(slices.into_iter().eq(0..count), "dimension {dimension} of {count} points");
            }
        }
    }

    #[test]
    fn the_same_seed_and_stream_are_the_same_points_and_another_stream_is_another_set() {
        let sobol = |seed, stream| scrambled_sobol(16, 4, seed, stream).expect("few");
        assert_eq!(latin_hypercube(16, 4, 9, 1), latin_hypercube(16, 4, 9, 1));
        assert_ne!(latin_hypercube(16, 4, 9, 1), latin_hypercube(16, 4, 9, 2));
        assert_ne!(latin_hypercube(16, 4, 9, 1), latin_hypercube(16, 4, 8, 1));
        assert_eq!(sobol(9, 1), sobol(9, 1));
        assert_ne!(sobol(9, 1), sobol(9, 2));
        assert_ne!(sobol(9, 1), sobol(8, 1));
    }

    #[test]
    fn more_dimensions_or_points_than_the_sequence_has_are_refused() {
        assert_eq!(
            scrambled_sobol(2, 257, 1, 0).expect_err("too many").to_string(),
            "Sobol points of 257 dimensions; expected at most 256"
        );
        assert!(scrambled_sobol(MOST_SOBOL_POINTS + 1, 1, 1, 0).is_err());
    }
}
