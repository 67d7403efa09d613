//! Spectra of sampled records by Welch's method: power, cross power, and the responses that follow from them.
//!
//! Welch, *IEEE Trans. Audio Electroacoust.* 15, 70 (1967); scaling and conventions are those of
//! `scipy.signal.welch` and `csd` with `scaling="density"`: one-sided densities, S_ij = mean of conj(X_i)·X_j.

use super::frf::C64;

mod closed_loop;
mod error;
mod psd;
mod response;
mod sums;
mod window;

pub use error::SpectraError;
pub use psd::Psd;
pub use response::Coherence;
use sums::Sums;
pub use window::{Detrend, Window};

#[cfg(test)]
mod fixture_tests;
#[cfg(test)]
mod recovery_tests;
#[cfg(test)]
mod tests;

/// Fewest samples of a segment.
pub const FEWEST_SEGMENT_SAMPLES: usize = 8;

/// How a record is cut into segments and what happens to each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WelchSettings {
    /// Samples per second, Hz.
    pub sample_rate_hz: f64,
    /// Samples of a segment, at least 8: lines are spaced by `sample_rate_hz / segment_samples`.
    pub segment_samples: usize,
    /// Share of a segment that it has in common with the next, 0 ≤ ratio < 1.
    pub overlap_ratio: f64,
    /// Weight of the samples of a segment.
    pub window: Window,
    /// What is taken off each segment first.
    pub detrend: Detrend,
}

impl WelchSettings {
    /// Hann window, half overlap, mean taken off: the defaults of `scipy.signal.welch`.
    pub fn new(sample_rate_hz: f64, segment_samples: usize) -> Self {
        Self {
            sample_rate_hz,
            segment_samples,
            overlap_ratio: 0.5,
            window: Window::Hann,
            detrend: Detrend::Constant,
        }
    }

    /// Samples between the starts of neighbouring segments.
    pub fn hop_samples(&self) -> usize {
        let common = (self.overlap_ratio * self.segment_samples as f64) as usize;
        self.segment_samples.saturating_sub(common).max(1)
    }

    fn check(&self) -> Result<(), SpectraError> {
        if !(self.sample_rate_hz > 0.0 && self.sample_rate_hz.is_finite()) {
            return Err(SpectraError::SampleRate { found: self.sample_rate_hz });
        }
        if !(0.0..1.0).contains(&self.overlap_ratio) {
            return Err(SpectraError::Overlap { found: self.overlap_ratio });
        }
        if self.segment_samples < FEWEST_SEGMENT_SAMPLES {
            return Err(SpectraError::Segment { found: self.segment_samples });
        }
        Ok(())
    }
}

/// All auto- and cross spectra of a few channels, averaged over segments.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossSpectra {
    settings: WelchSettings,
    frequency_hz: Vec<f64>,
    /// One-sided densities, unit²/Hz, one a channel.
    auto: Vec<Vec<f64>>,
    /// One-sided cross densities of the pairs i < j: (0, 1), (0, 2) … (1, 2) …
    cross: Vec<Vec<C64>>,
    varies: Vec<bool>,
    segments: usize,
    averages: f64,
}

impl CrossSpectra {
    /// Spectra of channels of equal length over all whole segments; samples after the last whole one are left.
    ///
    /// Work is shared by the threads of the current rayon pool; the result does not depend on their number.
    ///
    /// # Errors
    /// Settings out of range; no channel, unequal lengths, less than one segment, a value that is not finite or
    /// too large to square: [`SpectraError`].
    pub fn welch(channels: &[&[f64]], settings: &WelchSettings) -> Result<Self, SpectraError> {
        settings.check()?;
        let samples = equal_length(channels)?;
        if samples < settings.segment_samples {
            let expected = settings.segment_samples;
            return Err(SpectraError::TooShort { channel: 0, expected, found: samples });
        }
        let last = samples - settings.segment_samples;
        let starts: Vec<usize> = (0..=last).step_by(settings.hop_samples()).collect();
        let covered = starts.last().map_or(0, |s| s + settings.segment_samples);
        for (channel, values) in channels.iter().enumerate() {
            if let Some(at) = values[covered..].iter().position(|v| !v.is_finite()) {
                return Err(not_finite(channels, channel, covered + at, &starts, settings));
            }
        }
        Self::of_segments(channels, &starts, settings)
    }

    /// Spectra over the segments that begin at these samples (any order, any distance), as of the plateaus of a
    /// record with turn-rounds; `overlap_ratio` is not used, what the segments share is counted.
    ///
    /// # Errors
    /// As [`Self::welch`], and [`SpectraError::SegmentOutside`] for a segment that ends after the record. Only
    /// samples within segments are looked at.
    pub fn of_segments(
        channels: &[&[f64]],
        starts: &[usize],
        settings: &WelchSettings,
    ) -> Result<Self, SpectraError> {
        settings.check()?;
        let samples = equal_length(channels)?;
        let n = settings.segment_samples;
        if starts.is_empty() {
            return Err(SpectraError::TooShort { channel: 0, expected: n, found: 0 });
        }
        if let Some(segment) = starts.iter().position(|s| s.checked_add(n).is_none_or(|end| end > samples)) {
            let start = starts[segment];
            return Err(SpectraError::SegmentOutside { segment, start, length: n, found: samples });
        }
        let weights = settings.window.weights(n);
        let sums = Sums::over(channels, starts, &weights, settings.detrend);
        if let Some(channel) = sums.overflown() {
            return Err(overflow(channels, channel, starts, settings));
        }
        let power: f64 = weights.iter().map(|w| w * w).sum();
        let averages = window::averages(starts, &weights);
        Self::scaled(sums, settings, power, starts.len(), averages)
    }

    /// Sums over segments as one-sided densities.
    fn scaled(
        mut sums: Sums,
        settings: &WelchSettings,
        window_power: f64,
        segments: usize,
        averages: f64,
    ) -> Result<Self, SpectraError> {
        let n = settings.segment_samples;
        let scale = 1.0 / (settings.sample_rate_hz * window_power * segments as f64);
        let two_sided = complex_lines(n);
        let scale_of = |k: usize| if two_sided.contains(&k) { 2.0 * scale } else { scale };
        for spectrum in &mut sums.auto {
            spectrum.iter_mut().enumerate().for_each(|(k, s)| *s *= scale_of(k));
        }
        for spectrum in &mut sums.cross {
            spectrum.iter_mut().enumerate().for_each(|(k, s)| *s *= scale_of(k));
        }
        if let Some(channel) = sums.overflown() {
            return Err(SpectraError::TooLarge { channel });
        }
        let spacing_hz = settings.sample_rate_hz / n as f64;
        let frequency_hz = (0..=n / 2).map(|k| k as f64 * spacing_hz).collect();
        let Sums { auto, cross, varies, .. } = sums;
        Ok(Self { settings: *settings, frequency_hz, auto, cross, varies, segments, averages })
    }

    /// Frequencies of the lines, Hz: 0 to half the sample rate.
    pub fn frequency_hz(&self) -> &[f64] {
        &self.frequency_hz
    }

    /// Segments that were averaged.
    pub fn segments(&self) -> usize {
        self.segments
    }

    /// Number of independent averages n_d that have the variance of these segments, which overlap: 0.947 of the
    /// segments for Hann at half overlap. Var{Ŝ} = S²/n_d.
    pub fn averages(&self) -> f64 {
        self.averages
    }

    /// Power spectral density of a channel.
    ///
    /// # Errors
    /// [`SpectraError::NoSuchChannel`].
    pub fn psd(&self, channel: usize) -> Result<Psd, SpectraError> {
        self.known(channel)?;
        Ok(Psd::new(&self.frequency_hz, &self.auto[channel], &self.settings, self.averages))
    }

    /// Cross spectral density S_ij = mean of conj(X_i)·X_j at every line, unit_i·unit_j/Hz, one-sided.
    ///
    /// # Errors
    /// [`SpectraError::NoSuchChannel`].
    pub fn csd(&self, i: usize, j: usize) -> Result<Vec<C64>, SpectraError> {
        self.known(i)?;
        self.known(j)?;
        Ok((0..self.frequency_hz.len()).map(|k| self.cross_at(i, j, k)).collect())
    }

    fn known(&self, channel: usize) -> Result<(), SpectraError> {
        let found = self.auto.len();
        if channel < found { Ok(()) } else { Err(SpectraError::NoSuchChannel { channel, found }) }
    }

    /// S_ij at a line of channels that exist.
    fn cross_at(&self, i: usize, j: usize, line: usize) -> C64 {
        match i.cmp(&j) {
            std::cmp::Ordering::Equal => C64::new(self.auto[i][line], 0.0),
            std::cmp::Ordering::Less => self.cross[sums::pair(i, j, self.auto.len())][line],
            std::cmp::Ordering::Greater => self.cross[sums::pair(j, i, self.auto.len())][line].conj(),
        }
    }

    /// Lines with a complex amplitude: all but 0 Hz and, for an even segment, half the sample rate.
    fn complex_lines(&self) -> std::ops::Range<usize> {
        complex_lines(self.settings.segment_samples)
    }
}

fn complex_lines(segment_samples: usize) -> std::ops::Range<usize> {
    1..segment_samples.div_ceil(2)
}

/// Samples of every channel.
fn equal_length(channels: &[&[f64]]) -> Result<usize, SpectraError> {
    let expected = channels.first().ok_or(SpectraError::NoChannels)?.len();
    match channels.iter().position(|c| c.len() != expected) {
        Some(channel) => {
            Err(SpectraError::UnequalLengths { channel, expected, found: channels[channel].len() })
        }
        None => Ok(expected),
    }
}

/// The error of a channel of which the sum of squares is not finite.
fn overflow(channels: &[&[f64]], channel: usize, starts: &[usize], settings: &WelchSettings) -> SpectraError {
    match first_not_finite(channels[channel], starts, settings.segment_samples) {
        Some(index) => SpectraError::NotFinite { channel, index, found: channels[channel][index] },
        None => SpectraError::TooLarge { channel },
    }
}

/// The error of a value after the last segment: an earlier one of the same channel is named first.
fn not_finite(
    channels: &[&[f64]],
    channel: usize,
    tail: usize,
    starts: &[usize],
    settings: &WelchSettings,
) -> SpectraError {
    let index = first_not_finite(channels[channel], starts, settings.segment_samples).unwrap_or(tail);
    SpectraError::NotFinite { channel, index, found: channels[channel][index] }
}

fn first_not_finite(values: &[f64], starts: &[usize], length: usize) -> Option<usize> {
    let within = |&s: &usize| values[s..s + length].iter().position(|v| !v.is_finite()).map(|at| s + at);
    starts.iter().filter_map(within).min()
}
