//! Frequency responses and coherence from the spectra of input and output in open loop.

use super::super::frf::{C64, Frf, Line};
use super::{CrossSpectra, SpectraError};

/// Lines whose input power is below this share of its largest hold rounding only.
const LEAST_INPUT_SHARE: f64 = 1e-28;
/// Fewest independent averages of a response: two segments that overlap by half or less.
const FEWEST_AVERAGES: f64 = 1.5;

/// Coherence at one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coherence {
    /// γ̂² = |S_ij|²/(S_ii·S_jj), as `scipy.signal.coherence`; 0 where a channel has no power.
    pub raw: f64,
    /// γ̂² − (1 − γ̂²)²/n_d: freed of its bias to first order (Carter, Knapp & Nuttall, *IEEE Trans. Audio
    /// Electroacoust.* 21, 337, 1973). 0 where the bias is all there is.
    pub corrected: f64,
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
