//! Tracking errors: root mean squares with their uncertainty, percentiles, and peaks with what caused them.
//!
//! Errors of a track loop are correlated over its own time constants, so the scatter of their mean square is not that of
//! independent samples: it is taken from a circular block bootstrap (Politis & Romano 1992), whose block length follows
//! from the record's own correlation (Politis & White 2004, corrected by Patton, Politis & White 2009).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

mod blocks;
mod dwell;
#[cfg(test)]
mod tests;
mod windows;

use blocks::block_length;

pub use dwell::{Dwell, longest_dwell};
pub use windows::opened;

/// Resamples of the bootstrap: the standard deviation of their spread is known to 4 %.
const RESAMPLES: u32 = 400;
/// Fewest blocks that a spread is read from.
const LEAST_BLOCKS: usize = 8;

/// Why there is no number.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrackingError {
    /// Records of different lengths.
    #[error("{errors} errors, but {flags} flags: one for each sample is needed")]
    Lengths {
        /// Samples of the error.
        errors: usize,
        /// Flags given.
        flags: usize,
    },
    /// Something that is no number.
    #[error("sample {0} of the error is not a number: leave out samples that were not tracked")]
    NotFinite(usize),
    /// Too short for its own correlation.
    #[error(
        "{samples} samples are {blocks} blocks of the record's correlation length; at least {LEAST_BLOCKS} \
         are needed: track longer"
    )]
    TooShort {
        /// Samples given.
        samples: usize,
        /// Blocks that they are.
        blocks: usize,
    },
}

/// A root mean square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rms {
    /// In the unit of the samples.
    pub value: f64,
    /// Standard uncertainty.
    pub u: f64,
    /// Degrees of freedom of `u`: independent blocks less one.
    pub dof: f64,
    /// Samples.
    pub n: usize,
}

/// The root mean square of a record with zero as its reference, and how well the record determines it. `seed` is that of
/// the bootstrap: the same data and seed give the same bits.
///
/// # Errors
/// [`TrackingError::NotFinite`]; [`TrackingError::TooShort`] for fewer than eight blocks.
pub fn rms(errors: &[f64], seed: u64) -> Result<Rms, TrackingError> {
    if let Some(sample) = errors.iter().position(|e| !e.is_finite()) {
        return Err(TrackingError::NotFinite(sample));
    }
    let squares: Vec<f64> = errors.iter().map(|e| e * e).collect();
    let n = squares.len();
    let (length, missing) = block_length(&squares);
    let blocks = n / length.max(1);
    if blocks < LEAST_BLOCKS {
        return Err(TrackingError::TooShort { samples: n, blocks });
    }
    let mean = squares.iter().sum::<f64>() / n as f64;
    let value = mean.sqrt();
    // Of a root: half the relative deviation of the square. Blocks are few, so that their variance is too small by
    // (b − 1)/b, and they cut off correlation.
    let shown = (1.0 - 1.0 / blocks as f64) * (1.0 - missing);
    let u = if mean > 0.0 { 0.5 * spread(&squares, length, seed) / shown.sqrt() / value } else { 0.0 };
    Ok(Rms { value, u, dof: blocks as f64 - 1.0, n })
}

/// Standard deviation of the mean over circular blocks that are drawn with replacement.
fn spread(values: &[f64], length: usize, seed: u64) -> f64 {
    let n = values.len();
    // Sums of every block, by running sums over the record and its beginning again.
    let mut sums = Vec::with_capacity(n + length + 1);
    sums.push(0.0);
    for k in 0..n + length {
        sums.push(sums[k] + values[k % n]);
    }
    let blocks = n.div_ceil(length);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || {
        let total: f64 = (0..blocks)
            .map(|_| {
                let start = ((u128::from(random.next_u64()) * n as u128) >> 64) as usize;
                sums[start + length] - sums[start]
            })
            .sum();
        total / (blocks * length) as f64
    };
    let means: Vec<f64> = (0..RESAMPLES).map(|_| draw()).collect();
    let centre = means.iter().sum::<f64>() / f64::from(RESAMPLES);
    let variance = means.iter().map(|m| (m - centre).powi(2)).sum::<f64>() / f64::from(RESAMPLES - 1);
    // The last block overhangs: the mean of n samples scatters a little more.
    (variance * (blocks * length) as f64 / n as f64).sqrt()
}

/// What a record of one axis amounts to.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Over all of it, or why that is not known well enough.
    pub whole: Result<Rms, TrackingError>,
    /// Outside the declared windows, or why not.
    pub outside: Result<Rms, TrackingError>,
    /// Inside them; `None` where too little lies there.
    pub inside: Option<Rms>,
    /// Share of the record that lies inside.
    pub inside_ratio: f64,
    /// Mean over all of it.
    pub mean: f64,
    /// Magnitude that 99.9 % of the samples stay below (nearest rank).
    pub percentile_999: f64,
    /// Half of the distance between the ranks beside it: how well so many samples determine it.
    pub percentile_999_u: f64,
    /// Largest magnitude.
    pub largest: f64,
    /// Largest error less the smallest: it grows with the length of the record.
    pub peak_to_peak: f64,
}

/// Errors of one axis, sample by sample; `inside` marks the windows that were declared beforehand.
///
/// # Errors
/// [`TrackingError::Lengths`], [`TrackingError::NotFinite`]; [`TrackingError::TooShort`] for no sample at all.
pub fn summarise(errors: &[f64], inside: &[bool], seed: u64) -> Result<Summary, TrackingError> {
    if errors.len() != inside.len() {
        return Err(TrackingError::Lengths { errors: errors.len(), flags: inside.len() });
    }
    let whole = match rms(errors, seed) {
        Err(TrackingError::TooShort { samples, blocks }) if !errors.is_empty() => {
            Err(TrackingError::TooShort { samples, blocks })
        }
        other => Ok(other?),
    };
    let part = |wanted: bool| -> Vec<f64> {
        errors.iter().zip(inside).filter(|(_, inside)| **inside == wanted).map(|(e, _)| *e).collect()
    };
    let within = part(true);
    let without = part(false);
    let mut sizes: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let last = sizes.len() - 1;
    let rank = ((0.999 * sizes.len() as f64).ceil() as usize).clamp(1, sizes.len()) - 1;
    let (low, high) =
        errors.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(*e), h.max(*e)));
    Ok(Summary {
        whole,
        outside: rms(&without, seed),
        inside: rms(&within, seed).ok(),
        inside_ratio: within.len() as f64 / errors.len() as f64,
        mean: errors.iter().sum::<f64>() / errors.len() as f64,
        percentile_999: sizes[rank],
        percentile_999_u: 0.5 * (sizes[(rank + 1).min(last)] - sizes[rank.saturating_sub(1)]),
        largest: sizes[last],
        peak_to_peak: high - low,
    })
}

/// What can cause a peak, the likeliest first where several come together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// The tracker had no target.
    Loss,
    /// The mirror stood at the end of its stroke.
    Saturation,
    /// The target turned round.
    Reversal,
    /// The rate of the target changed at once, without turning round.
    Jump,
    /// The target went over a joint of its rails.
    Joint,
    /// None of these.
    Unknown,
}

/// A time in which something happened that explains peaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Happening {
    /// What.
    pub cause: Cause,
    /// First sample that it explains.
    pub from: usize,
    /// First sample after it.
    pub to: usize,
}

/// A stretch in which an error is beyond a threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Sample of its largest value.
    pub at: usize,
    /// The value of the largest error, signed.
    pub value: f64,
    /// What explains it.
    pub cause: Cause,
}

/// Peaks beyond a threshold, in order of time; stretches less than `apart` samples apart are one. A peak belongs to the
/// first cause in the order of [`Cause`] that touches its stretch. Samples that are no number exceed nothing.
pub fn peaks(errors: &[f64], threshold: f64, apart: usize, happenings: &[Happening]) -> Vec<Peak> {
    let mut stretches: Vec<(usize, usize)> = Vec::new();
    for (k, _) in errors.iter().enumerate().filter(|(_, e)| e.abs() > threshold) {
        match stretches.last_mut() {
            Some((_, end)) if k < *end + apart => *end = k + 1,
            _ => stretches.push((k, k + 1)),
        }
    }
    let event = |&(from, to): &(usize, usize)| {
        let at = (from..to).fold(from, |best, k| if errors[k].abs() > errors[best].abs() { k } else { best });
        let touches = |h: &&Happening| h.from < to && h.to > from;
        let cause = happenings.iter().filter(touches).map(|h| h.cause).min().unwrap_or(Cause::Unknown);
        Peak { at, value: errors[at], cause }
    };
    stretches.iter().map(event).collect()
}
