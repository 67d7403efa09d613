//! Checked lines in scaled frequency, with the weight of each.

use std::f64::consts::TAU;

use super::super::frf::{C64, Frf};

/// Least complex degrees of freedom a variance is treated as having: below, its reciprocal has no finite mean square.
const LEAST_VARIANCE_DOF: f64 = 3.0;

/// Degrees of freedom that are joined from neighbouring lines where a line has fewer than that.
const JOINED_DOF: f64 = 32.0;
/// Most lines to each side that are joined.
const MOST_REACH: usize = 32;

/// What is wrong with lines.
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
        "line {line} of response {response} holds a number that is not finite: leave lines without a value out"
    )]
    NotFinite {
        /// Index of the response.
        response: usize,
        /// Index of the line.
        line: usize,
    },
    /// Frequencies do not ascend from above 0.
    #[error(
        "line {line} of response {response} is at {frequency_hz} Hz: frequencies have to ascend from above 0, none twice"
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

/// One response in scaled frequency.
#[derive(Clone, Debug)]
pub(crate) struct Weighed {
    /// jω over the scale of frequency.
    pub(crate) s: Vec<C64>,
    /// Values, a known delay taken out.
    pub(crate) value: Vec<C64>,
    /// Weight of the real and of the imaginary part: 1/sd of either, √(2/variance).
    pub(crate) root: Vec<f64>,
}

/// Responses that are fitted together.
#[derive(Clone, Debug)]
pub(crate) struct Data {
    /// Scale of frequency, rad/s: the highest of all lines.
    pub(crate) scale_rad_per_s: f64,
    /// One entry a response.
    pub(crate) responses: Vec<Weighed>,
    /// Whether variances were given; without, all weights are 1 and the residual tells the noise.
    pub(crate) known: bool,
    /// By what the covariance grows because the weights are estimates themselves.
    pub(crate) widening: f64,
}

/// Checks the lines of several responses; returns whether their variances are known.
///
/// # Errors
/// See [`LineError`].
pub(crate) fn check(frfs: &[Frf]) -> Result<bool, LineError> {
    if let Some(response) = frfs.iter().position(Vec::is_empty).or(frfs.is_empty().then_some(0)) {
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

/// A variance with its complex degrees of freedom.
#[derive(Clone, Copy)]
struct Spread {
    variance: f64,
    dof: f64,
}

impl Spread {
    /// Factor that makes the reciprocal right on average, ν/(ν − 1) (mean of the inverse χ² of 2ν).
    fn mean_factor(self) -> f64 {
        if self.dof.is_infinite() { 1.0 } else { self.dof / (self.dof - 1.0) }
    }
}

/// Variance of line `k`; with fewer degrees than can be treated it is joined with those of its neighbours, as many to
/// each side as make up [`JOINED_DOF`]: a variance of two or three windows that happens to be small would give its line
/// all the weight. Noise is smooth over a few lines.
fn spread(frf: &Frf, k: usize) -> Spread {
    let own = &frf[k];
    if own.dof >= LEAST_VARIANCE_DOF {
        return Spread { variance: own.variance, dof: own.dof };
    }
    let mut reach = 0;
    loop {
        let near = &frf[k.saturating_sub(reach)..(k + reach + 1).min(frf.len())];
        let dof: f64 = near.iter().map(|l| l.dof.clamp(0.0, JOINED_DOF)).sum();
        if dof >= JOINED_DOF || reach >= MOST_REACH || near.len() == frf.len() {
            let variance = near.iter().map(|l| l.variance).sum::<f64>() / near.len() as f64;
            return Spread { variance, dof: dof.max(LEAST_VARIANCE_DOF) };
        }
        reach += 1;
    }
}

impl Data {
    /// Checks and weighs; takes out `delay_s`.
    ///
    /// A variance that is itself estimated, with ν complex degrees of freedom, weighs 1/(s²·ν/(ν − 1)), so that the
    /// cost of the true model is its dof on average; the covariance is (ν − 1)/(ν − 2) times that of known variances
    /// (mean square of the inverse χ² of 2ν over its squared mean). Below three degrees it is joined with those of its
    /// neighbours.
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
        let inverse = spreads.iter().flatten().map(|s| 1.0 / s.dof).sum::<f64>() / count;
        let widening = if known { (1.0 - inverse) / (1.0 - 2.0 * inverse) } else { 1.0 };
        Ok(Self { scale_rad_per_s, responses, known, widening })
    }

    /// Lines of all responses.
    pub(crate) fn line_count(&self) -> usize {
        self.responses.iter().map(|r| r.s.len()).sum()
    }

    /// Sum of weighted squares of the values.
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

    /// Spacing of the lines around a scaled frequency, of the response that is closest there.
    pub(crate) fn spacing_at(&self, frequency: f64) -> f64 {
        let spacing = |r: &Weighed| {
            let k = r.s.partition_point(|s| s.im < frequency).clamp(1, r.s.len().saturating_sub(1).max(1));
            r.s.get(k).map_or(f64::INFINITY, |s| s.im - r.s[k - 1].im)
        };
        self.responses.iter().map(spacing).fold(f64::INFINITY, f64::min)
    }
}
