//! Noise and nonlinear distortion from several realisations.

use super::error::{PeriodicError, within_range};
use super::ratio::errors_in_variables;
use crate::frf::{C64, Line};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// One realisation of random phases: windows × lines of input and output.
#[derive(Clone, Copy, Debug)]
pub struct Realisation<'a> {
    /// Input.
    pub u: &'a [Vec<C64>],
    /// Output.
    pub y: &'a [Vec<C64>],
}

/// One line of the best linear approximation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobustLine {
    /// Mean over the realisations, with the **total** variance of that mean (noise and distortion), R − 1 degrees.
    pub response: Line,
    /// Variance of that mean by noise alone, from the scatter between windows of one realisation.
    pub noise_variance: f64,
    /// Variance of **one** realisation's response by stochastic nonlinear distortion: R·(total − noise), not below 0.
    /// Cut off at 0 it is too large on average where distortion is not above the noise: [`nonlinear_rms`] of many lines
    /// is not.
    pub nonlinear_variance: f64,
    /// Probability that the realisations would scatter so much more than the noise if the plant were linear.
    pub linear_probability: f64,
}

impl RobustLine {
    /// Whether distortion stands out of the noise, at 1 % of false alarms.
    pub fn is_distorted(&self) -> bool {
        self.linear_probability < 0.01
    }
}

/// Standard deviation of **one** realisation's response by stochastic nonlinear distortion, rms over the lines:
/// √mean(R·(total − noise)), without cutting off line by line, so that noise cancels; `None` without a line, 0 where
/// noise is all there is. Unit of the response.
pub fn nonlinear_rms(lines: &[RobustLine]) -> Option<f64> {
    let excess = |l: &RobustLine| (l.response.dof + 1.0) * (l.response.variance - l.noise_variance);
    let mean = lines.iter().map(excess).sum::<f64>() / lines.len() as f64;
    (!lines.is_empty()).then(|| mean.max(0.0).sqrt())
}

/// The robust method (Pintelon & Schoukens, *System Identification*, 2nd ed., §4.3.1): realisations of random phases
/// on the same lines with the same amplitudes, each in steady state and cut into windows. Within a realisation
/// distortion repeats from window to window, so that scatter is noise; between realisations it does not.
///
/// total = Σ|G_m − Ḡ|²/(R(R − 1)), noise = Σ var G_m/R²; their ratio follows F(2(R − 1), 2R(P − 1)) if the plant is
/// linear.
///
/// # Errors
/// [`PeriodicError::TooFew`] below two realisations or two windows; those of
/// [`errors_in_variables`](super::errors_in_variables).
pub fn robust(
    frequencies_hz: &[f64],
    realisations: &[Realisation<'_>],
) -> Result<Vec<RobustLine>, PeriodicError> {
    if realisations.len() < 2 {
        let found = realisations.len();
        return Err(PeriodicError::TooFew { what: "realisations", expected: 2, found });
    }
    let each: Result<Vec<Vec<Line>>, _> =
        realisations.iter().map(|r| errors_in_variables(frequencies_hz, r.u, r.y)).collect();
    let each = each?;
    let windows: usize = realisations.iter().map(|r| r.u.len() - 1).sum();
    (0..frequencies_hz.len()).map(|l| line(&each, l, windows as f64)).collect()
}

fn line(each: &[Vec<Line>], l: usize, noise_dof: f64) -> Result<RobustLine, PeriodicError> {
    let r = each.len() as f64;
    let value = each.iter().map(|g| g[l].value).sum::<C64>() / r;
    let variance = each.iter().map(|g| (g[l].value - value).norm_sqr()).sum::<f64>() / (r * (r - 1.0));
    let noise_variance = each.iter().map(|g| g[l].variance).sum::<f64>() / (r * r);
    within_range("response", r * variance + noise_variance)?;
    let coherence = mean_coherence(each, l);
    Ok(RobustLine {
        response: Line { frequency_hz: each[0][l].frequency_hz, value, variance, dof: r - 1.0, coherence },
        noise_variance,
        nonlinear_variance: r * (variance - noise_variance).max(0.0),
        linear_probability: chance(variance, noise_variance, r - 1.0, noise_dof),
    })
}

/// P(F > total/noise); dof are complex, so both count twice.
fn chance(total: f64, noise: f64, total_dof: f64, noise_dof: f64) -> f64 {
    if noise <= 0.0 {
        return if total > 0.0 { 0.0 } else { 1.0 };
    }
    FisherSnedecor::new(2.0 * total_dof, 2.0 * noise_dof).map_or(1.0, |f| f.sf(total / noise))
}

fn mean_coherence(each: &[Vec<Line>], l: usize) -> Option<f64> {
    let all: Option<Vec<f64>> = each.iter().map(|g| g[l].coherence).collect();
    all.map(|c| c.iter().sum::<f64>() / c.len() as f64)
}
