//! Frequency responses and coherence from the spectra of input and output in open loop.

use thiserror::Error;

use super::super::frf::{C64, Frf, Line};
use super::{CrossSpectra, SpectraError};

/// Lines whose input power is below this share of its largest hold rounding only.
const LEAST_INPUT_SHARE: f64 = 1e-28;
/// Fewest independent averages of a response: two segments that overlap by half or less.
const FEWEST_AVERAGES: f64 = 1.5;
/// An instrument that keeps single precision may say this much more than 1.
const ROUNDING_OF_A_SINGLE: f64 = 4.0 * f32::EPSILON as f64;

/// Coherence at one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coherence {
    /// γ̂² = |S_ij|²/(S_ii·S_jj), as `scipy.signal.coherence`; 0 where a channel has no power.
    pub raw: f64,
    /// γ̂² − (1 − γ̂²)²/n_d: freed of its bias to first order (Carter, Knapp & Nuttall, *IEEE Trans. Audio
    /// Electroacoust.* 21, 337, 1973). 0 where the bias is all there is.
    pub corrected: f64,
}

/// A coherence that no spectra can have: they were not averaged alike, or the file is damaged.
#[derive(Clone, Debug, Error, PartialEq)]
#[error(
    "expected coherence within 0 … 1, found {found} at line {} ({} such lines): leave these lines out or ask how it \
     was averaged",
    lines[0], lines.len()
)]
pub struct ImpossibleCoherence {
    /// Lines with such a value, from 0; at least one.
    pub lines: Vec<usize>,
    /// Value at the first of them.
    pub found: f64,
}

/// Looks through a coherence that another instrument or program gave. Nothing is changed.
///
/// # Errors
/// [`ImpossibleCoherence`] names every line that is negative, above 1 by more than the rounding of a single, or
/// not a number.
pub fn judge_coherence(coherence: &[f64]) -> Result<(), ImpossibleCoherence> {
    let possible = 0.0..=1.0 + ROUNDING_OF_A_SINGLE;
    let lines: Vec<usize> =
        coherence.iter().enumerate().filter(|(_, c)| !possible.contains(*c)).map(|(k, _)| k).collect();
    match lines.first() {
        Some(&first) => Err(ImpossibleCoherence { found: coherence[first], lines }),
        None => Ok(()),
    }
}

/// Spectra of input x and output y at one line.
#[derive(Clone, Copy)]
pub(super) struct Two {
    pub(super) xx: f64,
    pub(super) yy: f64,
    pub(super) xy: C64,
}

impl Two {
    fn coherence(self) -> f64 {
        let both = self.xx * self.yy;
        // Cauchy–Schwarz holds for the sums; min takes off the last bit of rounding.
        if both > 0.0 { (self.xy.norm_sqr() / both).min(1.0) } else { 0.0 }
    }
}

impl CrossSpectra {
    /// H1 = S_xy/S_xx: least squares, unbiased under noise at the output only. Unit of output over input.
    ///
    /// Lines from the first to the last below half the sample rate (0 Hz and half the rate are real, half the
    /// freedom), without those that have no input power. Value and uncertainty: `variance` = |H|²·(1 −
    /// γ̂²)/(γ̂²·(n_d − 1)), so sd(|H|)/|H| = √((1 − γ²)/(2γ²·n_d)) (Bendat & Piersol, *Random Data*, 4th ed.,
    /// eq. 9.90); n_d − 1 where the large-sample formula has n_d, because one complex number was fitted: so the
    /// circle is Goodman's with F(2, 2n_d − 2).
    ///
    /// # Errors
    /// No such channel, a constant channel, fewer than two averages: [`SpectraError`].
    pub fn h1(&self, input: usize, output: usize) -> Result<Frf, SpectraError> {
        self.response(input, output, |s| Some(s.xy / s.xx))
    }

    /// H2 = S_yy/S_yx: unbiased under noise at the input only. Lines and uncertainty as [`Self::h1`].
    ///
    /// # Errors
    /// As [`Self::h1`].
    pub fn h2(&self, input: usize, output: usize) -> Result<Frf, SpectraError> {
        self.response(input, output, |s| (s.xy.norm_sqr() > 0.0).then(|| s.xy.conj().inv() * s.yy))
    }

    /// H_v, total least squares: unbiased under noise at both ends, if `noise_ratio` is the density of the
    /// output noise over that of the input noise, (unit of output / unit of input)². |H1| ≤ |H_v| ≤ |H2|. Lines
    /// and uncertainty as [`Self::h1`].
    ///
    /// With y scaled by 1/√noise_ratio both noises are alike; the smallest eigenvector of [[S_xx, S_xy], [S_yx,
    /// S_yy]] is normal to (1, H) (Allemang & Brown in *Harris' Shock and Vibration Handbook*, ch. 21), which
    /// gives the quadratic solved here.
    ///
    /// # Errors
    /// As [`Self::h1`]; [`SpectraError::NoiseRatio`].
    pub fn hv(&self, input: usize, output: usize, noise_ratio: f64) -> Result<Frf, SpectraError> {
        if !(noise_ratio > 0.0 && noise_ratio.is_finite()) {
            return Err(SpectraError::NoiseRatio { found: noise_ratio });
        }
        self.response(input, output, |s| {
            let excess = noise_ratio * s.xx - s.yy;
            let root = excess.hypot(2.0 * noise_ratio.sqrt() * s.xy.norm());
            // Two forms of one root: the sum without cancellation is taken.
            if excess > 0.0 {
                Some(s.xy * (2.0 * noise_ratio / (excess + root)))
            } else {
                (s.xy.norm_sqr() > 0.0).then(|| s.xy.conj().inv() * (0.5 * (root - excess)))
            }
        })
    }

    /// Coherence of two channels at every line of [`Self::frequency_hz`].
    ///
    /// # Errors
    /// As [`Self::h1`]: with one average it is 1 whatever the record.
    pub fn coherence(&self, i: usize, j: usize) -> Result<Vec<Coherence>, SpectraError> {
        self.check_averaged(&[i, j])?;
        let line = |k: usize| {
            let raw = self.two(i, j, k).coherence();
            Coherence { raw, corrected: self.corrected(raw) }
        };
        Ok((0..self.frequency_hz.len()).map(line).collect())
    }

    /// Lines of an estimator of two channels.
    fn response(
        &self,
        input: usize,
        output: usize,
        value: impl Fn(Two) -> Option<C64>,
    ) -> Result<Frf, SpectraError> {
        self.check_averaged(&[input, output])?;
        let line = |k: usize| {
            let two = self.two(input, output, k);
            let value = value(two)?;
            let raw = two.coherence();
            let variance = value.norm_sqr() * (1.0 - raw) / raw / (self.averages - 1.0);
            self.line(k, value, variance, raw)
        };
        Ok(self.driven_lines(input).filter_map(line).collect())
    }

    /// A line of a response, unless it has no finite value.
    pub(super) fn line(&self, k: usize, value: C64, variance: f64, raw_coherence: f64) -> Option<Line> {
        (value.is_finite() && variance.is_finite()).then(|| Line {
            frequency_hz: self.frequency_hz[k],
            value,
            variance,
            dof: self.averages - 1.0,
            coherence: Some(self.corrected(raw_coherence)),
        })
    }

    fn corrected(&self, raw: f64) -> f64 {
        (raw - (1.0 - raw).powi(2) / self.averages).max(0.0)
    }

    pub(super) fn two(&self, i: usize, j: usize, line: usize) -> Two {
        Two { xx: self.auto[i][line], yy: self.auto[j][line], xy: self.cross_at(i, j, line) }
    }

    /// Complex lines at which a channel has more power than rounding.
    pub(super) fn driven_lines(&self, channel: usize) -> impl Iterator<Item = usize> {
        let power = &self.auto[channel];
        let least = LEAST_INPUT_SHARE * power.iter().copied().fold(0.0, f64::max);
        self.complex_lines().filter(move |&k| power[k] > least)
    }

    /// Channels exist and vary, and there are averages enough for a scatter.
    pub(super) fn check_averaged(&self, channels: &[usize]) -> Result<(), SpectraError> {
        channels.iter().try_for_each(|&c| self.known(c))?;
        if let Some(&channel) = channels.iter().find(|&&c| !self.varies[c]) {
            return Err(SpectraError::Constant { channel });
        }
        if self.averages < FEWEST_AVERAGES {
            return Err(SpectraError::TooFewAverages { segments: self.segments, averages: self.averages });
        }
        Ok(())
    }
}
