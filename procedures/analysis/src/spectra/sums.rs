//! The one pass over the record: sums of |X_i|² and conj(X_i)·X_j over segments.

use std::sync::Arc;

use fourier::RealToComplex;
use rayon::prelude::*;

use super::super::frf::C64;
use super::Detrend;

/// Stretches that are summed on their own and then added in order: enough for 16 threads, few enough for memory.
/// The number of threads never changes what is added to what.
const MOST_STRETCHES: usize = 32;
/// Sums that run side by side, so that one addition need not wait for the last.
const LANES: usize = 8;

/// Sums over segments, not scaled.
pub(super) struct Sums {
    pub(super) auto: Vec<Vec<f64>>,
    pub(super) cross: Vec<Vec<C64>>,
    /// Channels that take more than one value within a segment.
    pub(super) varies: Vec<bool>,
    /// Channels of which every square was finite.
    finite: Vec<bool>,
}

/// What every thread shares.
struct Plan<'a> {
    channels: &'a [&'a [f64]],
    weights: &'a [f64],
    detrend: Detrend,
    fft: Arc<dyn RealToComplex<f64>>,
}

/// What a thread writes over in each segment.
struct Scratch {
    windowed: Vec<f64>,
    spectra: Vec<Vec<C64>>,
    fft: Vec<C64>,
}

/// Place of the pair i < j among the cross spectra of `channels` channels.
pub(super) fn pair(i: usize, j: usize, channels: usize) -> usize {
    i * (2 * channels - i - 1) / 2 + j - i - 1
}

impl Sums {
    /// Sums over the segments of `weights.len()` samples that begin at `starts`, all within the record.
    pub(super) fn over(channels: &[&[f64]], starts: &[usize], weights: &[f64], detrend: Detrend) -> Self {
        let fft = fourier::forward(weights.len());
        let plan = Plan { channels, weights, detrend, fft };
        let stretch = starts.len().div_ceil(MOST_STRETCHES);
        let parts: Vec<Self> = starts
            .par_chunks(stretch)
            .map_init(|| plan.scratch(), |scratch, starts| plan.stretch(starts, scratch))
            .collect();
        parts.into_iter().reduce(Self::plus).unwrap_or_else(|| Self::zero(channels.len(), plan.lines()))
    }

    fn zero(channels: usize, lines: usize) -> Self {
        Self {
            auto: vec![vec![0.0; lines]; channels],
            cross: vec![vec![C64::ZERO; lines]; channels * (channels - 1) / 2],
            varies: vec![false; channels],
            finite: vec![true; channels],
        }
    }

    fn plus(mut self, other: Self) -> Self {
        for (sum, more) in self.auto.iter_mut().zip(&other.auto) {
            sum.iter_mut().zip(more).for_each(|(s, m)| *s += m);
        }
        for (sum, more) in self.cross.iter_mut().zip(&other.cross) {
            sum.iter_mut().zip(more).for_each(|(s, m)| *s += m);
        }
        self.varies.iter_mut().zip(&other.varies).for_each(|(s, m)| *s |= m);
        self.finite.iter_mut().zip(&other.finite).for_each(|(s, m)| *s &= m);
        self
    }

    /// The first channel whose sums are not finite. Cross sums are no larger than the auto sums (Cauchy–Schwarz).
    pub(super) fn overflown(&self) -> Option<usize> {
        let whole =
            |(spectrum, finite): (&Vec<f64>, &bool)| *finite && spectrum.iter().all(|s| s.is_finite());
        self.auto.iter().zip(&self.finite).position(|channel| !whole(channel))
    }

    /// Adds the spectra of one segment, pair by pair.
    fn add(&mut self, spectra: &[Vec<C64>]) {
        for (sum, x) in self.auto.iter_mut().zip(spectra) {
            sum.iter_mut().zip(x).for_each(|(s, x)| *s += x.norm_sqr());
        }
        for (i, x) in spectra.iter().enumerate() {
            for (j, y) in spectra.iter().enumerate().skip(i + 1) {
                let sum = &mut self.cross[pair(i, j, spectra.len())];
                sum.iter_mut().zip(x.iter().zip(y)).for_each(|(s, (x, y))| *s += x.conj() * y);
            }
        }
    }
}

impl Plan<'_> {
    fn lines(&self) -> usize {
        self.weights.len() / 2 + 1
    }

    fn scratch(&self) -> Scratch {
        Scratch {
            windowed: self.fft.make_input_vec(),
            spectra: vec![self.fft.make_output_vec(); self.channels.len()],
            fft: self.fft.make_scratch_vec(),
        }
    }

    /// Sums over some segments, one after the other.
    fn stretch(&self, starts: &[usize], scratch: &mut Scratch) -> Sums {
        let mut sums = Sums::zero(self.channels.len(), self.lines());
        for &start in starts {
            for (channel, values) in self.channels.iter().enumerate() {
                let segment = &values[start..start + self.weights.len()];
                let (mean, square) = moments(segment);
                sums.varies[channel] |= square > 0.0;
                sums.finite[channel] &= square.is_finite();
                let level = if self.detrend == Detrend::Constant { mean } else { 0.0 };
                for ((out, value), weight) in scratch.windowed.iter_mut().zip(segment).zip(self.weights) {
                    *out = (value - level) * weight;
                }
                self.fft
                    .process_with_scratch(
                        &mut scratch.windowed,
                        &mut scratch.spectra[channel],
                        &mut scratch.fft,
                    )
                    .expect("all three lengths come from the plan");
            }
            sums.add(&scratch.spectra);
        }
        sums
    }
}

/// Mean, and the sum of squares of the distances from the first value: 0 only where all are alike, not finite
/// where a value is not.
fn moments(segment: &[f64]) -> (f64, f64) {
    let first = segment.first().copied().unwrap_or_default();
    let mut sum = [0.0; LANES];
    let mut square = [0.0; LANES];
    let lanes = segment.chunks_exact(LANES);
    for value in lanes.remainder() {
        let distance = value - first;
        sum[0] += distance;
        square[0] += distance * distance;
    }
    for values in lanes {
        for lane in 0..LANES {
            let distance = values[lane] - first;
            sum[lane] += distance;
            square[lane] += distance * distance;
        }
    }
    let mean = first + sum.iter().sum::<f64>() / segment.len().max(1) as f64;
    (mean, square.iter().sum())
}
