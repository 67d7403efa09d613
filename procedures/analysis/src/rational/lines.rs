//! Input of the rational fit: lines of frequency responses, checked, with scaled frequencies and weights.

use std::f64::consts::TAU;

use super::super::frf::pooled::{Spread, spread};
use super::super::frf::{C64, Frf};

/// Why lines cannot be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LineError {
    /// No response, or one without lines.
    #[error("response {response} has no lines")]
    Empty {
        /// Index of the response.
        response: usize,
    },
    /// A number is not finite.
    #[error(
        "line {line} of response {response} holds a number that is not finite: leave out lines without a value"
    )]
    NotFinite {
        /// Index of the response.
        response: usize,
        /// Index of the line.
        line: usize,
    },
    /// Frequencies do not ascend from above 0.
    #[error(
        "line {line} of response {response} is at {frequency_hz} Hz: frequencies must be above 0 and \
         ascend, each once"
    )]
    NotAscending {
        /// Index of the response.
        response: usize,
        /// Index of the line.
        line: usize,
        /// What was found.
        frequency_hz: f64,
    },
    /// A variance is below 0, or 0 where others are not.
    #[error(
        "line {line} of response {response} has the variance {variance}: expected above 0 on every line, or 0 on every line if none is known"
    )]
    Variance {
        /// Index of the response.
        response: usize,
        /// Index of the line.
        line: usize,
        /// What was found.
        variance: f64,
    },
}

/// One response for the fit; its vectors have one entry per line.
#[derive(Clone, Debug)]
pub(crate) struct Weighed {
    /// jω/[`Data::scale_rad_per_s`], dimensionless.
    pub(crate) s: Vec<C64>,
    /// Response with the known delay removed.
    pub(crate) value: Vec<C64>,
    /// Square root of the weight of the real part, and of the imaginary part: √(2/variance) = 1/(standard deviation of
    /// either part).
    pub(crate) root: Vec<f64>,
}

/// Responses that are fitted together.
#[derive(Clone, Debug)]
pub(crate) struct Data {
    /// Frequency that is scaled to 1, rad/s: the highest of all lines.
    pub(crate) scale_rad_per_s: f64,
    /// One entry per response.
    pub(crate) responses: Vec<Weighed>,
    /// Whether the variances are known. If not, all weights are 1 and the noise is estimated from the residuals.
    pub(crate) known: bool,
    /// Factor on the covariance, at least 1, because the weights are estimates themselves.
    pub(crate) widening: f64,
}

/// Checks the lines of several responses; returns whether their variances are known.
///
/// # Errors
/// See [`LineError`].
pub(crate) fn check(frfs: &[Frf]) -> Result<bool, LineError> {
    if frfs.is_empty() {
        return Err(LineError::Empty { response: 0 });
    }
    if let Some(response) = frfs.iter().position(Vec::is_empty) {
        return Err(LineError::Empty { response });
    }
    let known = frfs.iter().flatten().any(|l| l.variance > 0.0);
    for (response, frf) in frfs.iter().enumerate() {
        let mut last_hz = 0.0;
        for (line, l) in frf.iter().enumerate() {
            let finite = [l.frequency_hz, l.value.re, l.value.im, l.variance].iter().all(|v| v.is_finite());
            if !finite || l.dof.is_nan() {
                return Err(LineError::NotFinite { response, line });
            }
            if l.frequency_hz <= last_hz {
                return Err(LineError::NotAscending { response, line, frequency_hz: l.frequency_hz });
            }
            if l.variance < 0.0 || (known && l.variance <= 0.0) {
                return Err(LineError::Variance { response, line, variance: l.variance });
            }
            last_hz = l.frequency_hz;
        }
    }
    Ok(known)
}

impl Spread {
    /// Factor on the variance that makes its reciprocal unbiased: ν/(ν − 1), from the mean of an inverse χ² with 2ν
    /// degrees of freedom.
    fn mean_factor(self) -> f64 {
        if self.dof.is_infinite() { 1.0 } else { self.dof / (self.dof - 1.0) }
    }
}

impl Data {
    /// Checks the lines, removes the delay `delay_s` from the responses, and weights the lines.
    ///
    /// A variance s² that is estimated with ν complex degrees of freedom gives the weight 1/(s²·ν/(ν − 1)). With it the
    /// cost of the true model is on average the number of its degrees of freedom.
    ///
    /// The covariance is (ν − 1)/(ν − 2) times that for known variances: the mean square of an inverse χ² with 2ν degrees
    /// of freedom over its squared mean. With fewer than three degrees of freedom a variance is pooled with those of
    /// neighbouring lines.
    pub(crate) fn new(frfs: &[Frf], delay_s: f64) -> Result<Self, LineError> {
        let known = check(frfs)?;
        let highest_hz = frfs.iter().flatten().map(|l| l.frequency_hz).fold(0.0, f64::max);
        let scale_rad_per_s = TAU * highest_hz;
        let spreads: Vec<Vec<Spread>> =
            frfs.iter().map(|frf| (0..frf.len()).map(|k| spread(frf, k)).collect()).collect();
        let responses = frfs
            .iter()
            .zip(&spreads)
            .map(|(frf, spreads)| Weighed {
                s: frf.iter().map(|l| C64::new(0.0, l.frequency_hz / highest_hz)).collect(),
                value: frf
                    .iter()
                    .map(|l| l.value * C64::from_polar(1.0, TAU * l.frequency_hz * delay_s))
                    .collect(),
                root: spreads
                    .iter()
                    .map(|s| if known { (2.0 / (s.variance * s.mean_factor())).sqrt() } else { 1.0 })
                    .collect(),
            })
            .collect();
        let count = frfs.iter().map(Vec::len).sum::<usize>() as f64;
        // (ν − 1)/(ν − 2) with the harmonic mean of all ν; known variances have infinite ν.
        let mean_inverse_dof = spreads.iter().flatten().map(|s| 1.0 / s.dof).sum::<f64>() / count;
        let widening = if known { (1.0 - mean_inverse_dof) / (1.0 - 2.0 * mean_inverse_dof) } else { 1.0 };
        Ok(Self { scale_rad_per_s, responses, known, widening })
    }

    /// Number of lines of all responses together.
    pub(crate) fn line_count(&self) -> usize {
        self.responses.iter().map(|r| r.s.len()).sum()
    }

    /// Weighted sum of squares of all responses: the cost of a model that is zero everywhere.
    pub(crate) fn size(&self) -> f64 {
        let size = |r: &Weighed| -> f64 {
            r.value.iter().zip(&r.root).map(|(v, root)| root * root * v.norm_sqr()).sum()
        };
        self.responses.iter().map(size).sum()
    }

    /// Lowest scaled frequency of all lines.
    pub(crate) fn lowest(&self) -> f64 {
        self.responses.iter().map(|r| r.s[0].im).fold(1.0, f64::min)
    }

    /// Spacing of neighbouring lines around a scaled frequency, itself scaled, of the response with the densest lines there.
    pub(crate) fn spacing_at(&self, frequency: f64) -> f64 {
        let spacing = |r: &Weighed| {
            let k = r.s.partition_point(|s| s.im < frequency).clamp(1, r.s.len().saturating_sub(1).max(1));
            r.s.get(k).map_or(f64::INFINITY, |s| s.im - r.s[k - 1].im)
        };
        self.responses.iter().map(spacing).fold(f64::INFINITY, f64::min)
    }
}
