//! How well a reference is followed: error in time, as it is and with a pure delay removed.

use crate::estimate::Estimate;

#[cfg(test)]
mod tests;

/// Part of the samples that the percentile leaves below: unlike the peak it does not grow with the record.
pub const PERCENTILE: f64 = 0.999;
/// Fewer blocks tell nothing of their scatter.
const LEAST_BLOCKS: usize = 5;
/// Resampled records of the bootstrap.
const RESAMPLES: usize = 200;

/// Error of following, in the unit of the error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Following {
    /// Root mean square, mean included.
    pub rms: Estimate,
    /// 99.9 % of all magnitudes are not above it.
    pub percentile: Estimate,
    /// Largest magnitude; its uncertainty is that of the percentile.
    pub peak: Estimate,
    /// Mean, signed.
    pub mean: f64,
}

/// Why an error says nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FollowingError {
    /// The record has too few blocks.
    #[error("{found} samples are fewer than {LEAST_BLOCKS} blocks of {block}: use a longer record")]
    Short {
        /// Samples.
        found: usize,
        /// Samples of a block.
        block: usize,
    },
    /// A sample that is no number.
    #[error("a following error is not a number: look for gaps in the record")]
    NotANumber,
}

/// Root mean square, percentile and peak of a settled error.
///
/// Samples of a following error are not independent: the uncertainties are standard deviations over resampled records put
/// together from circular blocks of `block` samples (Politis & Romano 1992), which begin at the same places in every call.
///
/// # Errors
/// See [`FollowingError`].
pub fn following(errors: &[f64], block: usize) -> Result<Following, FollowingError> {
    let n = errors.len();
    let block = block.max(1);
    if n < LEAST_BLOCKS * block {
        return Err(FollowingError::Short { found: n, block });
    }
    if errors.iter().any(|e| !e.is_finite()) {
        return Err(FollowingError::NotANumber);
    }
    let blocks = n.div_ceil(block);
    let mut state = 0_u64;
    let mut scratch = Vec::with_capacity(blocks * block);
    let mut found = [Vec::with_capacity(RESAMPLES), Vec::with_capacity(RESAMPLES)];
    for _ in 0..RESAMPLES {
        scratch.clear();
        for _ in 0..blocks {
            let from = (next(&mut state) % n as u64) as usize;
            scratch.extend((from..from + block).map(|k| errors[k % n]));
        }
        found[0].push(rms(&scratch));
        found[1].push(percentile(&mut scratch));
    }
    let [of_rms, of_percentile] = found.map(|all| crate::positioning::deviation(&all).1);
    let dof = (blocks - 1) as f64;
    let estimate = |value, u| Estimate { value, u, dof, n };
    let mut all = errors.to_vec();
    let peak = errors.iter().map(|e| e.abs()).fold(0.0, f64::max);
    Ok(Following {
        rms: estimate(rms(errors), of_rms),
        percentile: estimate(percentile(&mut all), of_percentile),
        peak: estimate(peak, of_percentile),
        mean: errors.iter().sum::<f64>() / n as f64,
    })
}

/// The pure delay that explains most of an error, s: Σ e·ṙ / Σ ṙ² for errors `e` (reference less place) and reference rates
/// `ṙ`. On a ramp it cannot be told from a constant error. `None` where the reference does not move.
pub fn delay(errors: &[f64], rates_per_s: &[f64]) -> Option<f64> {
    let square: f64 = rates_per_s.iter().map(|r| r * r).sum();
    let product: f64 = errors.iter().zip(rates_per_s).map(|(e, r)| e * r).sum();
    (square > 0.0 && product.is_finite()).then(|| product / square)
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Reorders the values.
fn percentile(values: &mut [f64]) -> f64 {
    values.iter_mut().for_each(|v| *v = v.abs());
    let rank = ((PERCENTILE * values.len() as f64).ceil() as usize).clamp(1, values.len()) - 1;
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// SplitMix64 (Steele, Lea & Flood 2014): a fixed sequence of places, no source of chance.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
