//! Electrical impedance of a piezo stack that drives a resonant mechanism.
//!
//! ```text
//!  o── R_s ──┬────────────┐
//!        C_0 (tan δ)  R_1─L_1─C_1
//!  o─────────┴────────────┘
//! ```
//! Butterworth–Van Dyke (IEEE Std 176-1987), with a dielectric of constant loss angle.

use std::f64::consts::FRAC_PI_2;

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::frf::Line;
use super::goodness::Goodness;
use super::nonlinear::NonlinearFit;
use super::rational::lines::check;
use super::rational::{LINES_PER_UNKNOWN, LineError};
use model::Values;

mod model;
mod start;
#[cfg(test)]
mod tests;

/// Probability that noise alone gives a resonance.
const FALSE_ALARM: f64 = 1e-3;
/// Parameters of the resonance: C_1, f_s, ζ.
const RESONANCE_UNKNOWNS: usize = 3;

/// Why there is no circuit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CircuitError {
    /// The lines cannot be used.
    #[error(transparent)]
    Lines(#[from] LineError),
    /// Fewer than three lines per unknown.
    #[error("{lines} lines for {unknowns} unknowns: expected at least {needed}")]
    TooFew {
        /// Lines given.
        lines: usize,
        /// Unknowns of the circuit.
        unknowns: usize,
        /// Lines needed.
        needed: usize,
    },
    /// The reference frequency is not above 0.
    #[error("the capacitance is requested at {frequency_hz} Hz: expected a frequency above 0")]
    Reference {
        /// What was found.
        frequency_hz: f64,
    },
    /// Not the impedance of a capacitance.
    #[error(
        "no capacitance found: expected a negative reactance that falls with frequency; check the sign of the phase and the shunt"
    )]
    NoCapacitance,
}

/// A number with its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Standard uncertainty.
    pub u: f64,
}

/// Resonance of the mechanism as the terminals show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonance {
    /// Series resonance f_s (terminals short-circuited), Hz.
    pub series_hz: Estimate,
    /// Parallel resonance f_p = f_s·√(1 + C_1/C_0) (terminals open), Hz, C_0 as it is at f_s.
    pub parallel_hz: Estimate,
    /// Damping ratio ζ = R_1/2·√(C_1/L_1).
    pub damping: Estimate,
    /// Coupling k² = 1 − (f_s/f_p)² = C_1/(C_0 + C_1).
    pub coupling: Estimate,
    /// Motional resistance R_1, Ω.
    pub resistance_ohm: f64,
    /// Motional inductance L_1, H.
    pub inductance_h: f64,
    /// Motional capacitance C_1, F.
    pub capacitance_f: f64,
}

/// Why there is no resonance.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoResonance {
    /// Noise alone would look like that.
    #[error("no resonance visible: chi squared falls by {gain:.1} with one, expected {needed:.1}")]
    BelowNoise {
        /// By what χ² falls with a resonance.
        gain: f64,
        /// What noise stays below anywhere in the band with a probability of 99.9 %.
        needed: f64,
    },
    /// The best fit is no resonance of a passive mechanism inside the band.
    #[error(
        "no resonance inside the band: the best fit is at {frequency_hz:.1} Hz with damping ratio {damping:.3}"
    )]
    Outside {
        /// f_s of the fit.
        frequency_hz: f64,
        /// ζ of the fit.
        damping: f64,
    },
}

/// The circuit at the terminals.
#[derive(Clone, Debug, PartialEq)]
pub struct CircuitFit {
    /// Clamped capacitance C_0 at the frequency asked for, F. Without a resonance the whole capacitance.
    pub capacitance_f: Estimate,
    /// Loss tangent of C_0.
    pub loss_tangent: Estimate,
    /// Series resistance R_s, Ω.
    pub series_ohm: Estimate,
    /// The resonance, or why there is none.
    pub resonance: Result<Resonance, NoResonance>,
    /// Σ 2|Ẑ − Z|²/variance; Σ 2|Ẑ/Z − 1|² where no variance is known.
    pub cost: f64,
    /// Real numbers observed less unknowns.
    pub dof: usize,
    /// How well the circuit describes the lines.
    pub goodness: Goodness,
    values: Values,
}

impl CircuitFit {
    /// Fits lines of impedance (Ω, variance in Ω²) by complex nonlinear least squares; C_0 is stated at `reference_hz`.
    ///
    /// The dielectric is a constant phase element, C_0·(jω/ω_ref)^(−2δ/π): loss angle δ at every frequency, with the
    /// fall of capacitance that belongs to it (Jonscher, *J. Phys. D* 32, R57, 1999). Covariance from the inverse
    /// Fisher information and [`Goodness`].
    ///
    /// # Errors
    /// See [`CircuitError`].
    pub fn new(lines: &[Line], reference_hz: f64) -> Result<Self, CircuitError> {
        let known = check(&[lines.to_vec()])?;
        let unknowns = Values::COUNT;
        let needed = LINES_PER_UNKNOWN * unknowns;
        if lines.len() < needed {
            return Err(CircuitError::TooFew { lines: lines.len(), unknowns, needed });
        }
        if !(reference_hz > 0.0 && reference_hz.is_finite()) {
            return Err(CircuitError::Reference { frequency_hz: reference_hz });
        }
        let problem = Problem { lines, reference_hz, known };
        let plain = problem.fit(&start::dielectric(lines, reference_hz).ok_or(CircuitError::NoCapacitance)?);
        let plain = plain.ok_or(CircuitError::NoCapacitance)?;
        let first = Values::from_parameters(&plain.parameters, reference_hz);
        let full = start::resonance(lines, &problem.roots(), &first).and_then(|v| problem.fit(&v));
        Ok(match problem.verdict(&plain, full.as_ref()) {
            Ok(()) => problem.result(full.as_ref().unwrap_or(&plain), None),
            Err(reason) => problem.result(&plain, Some(reason)),
        })
    }

    /// Impedance of the fit at a frequency in Hz, Ω.
    pub fn at(&self, frequency_hz: f64) -> super::frf::C64 {
        self.values.impedance(frequency_hz)
    }
}

struct Problem<'a> {
    lines: &'a [Line],
    reference_hz: f64,
    known: bool,
}

/// χ² of `dof` that noise exceeds with a probability.
fn quantile(dof: usize, probability: f64) -> f64 {
    ChiSquared::new(dof.max(1) as f64).map_or(f64::INFINITY, |d| d.inverse_cdf(1.0 - probability))
}

impl Problem<'_> {
    /// 1/sd of either part of each line; relative to its magnitude where no variance is known.
    fn roots(&self) -> Vec<f64> {
        let variance =
            |l: &Line| if self.known { l.variance } else { l.value.norm_sqr().max(f64::MIN_POSITIVE) };
        self.lines.iter().map(|l| (2.0 / variance(l)).sqrt()).collect()
    }

    fn fit(&self, start: &Values) -> Option<NonlinearFit> {
        let roots = self.roots();
        let residuals = |p: &[f64]| -> Vec<f64> {
            let values = Values::from_parameters(p, self.reference_hz);
            let error = |(l, root): (&Line, &f64)| {
                let e = (values.impedance(l.frequency_hz) - l.value) * *root;
                [e.re, e.im]
            };
            self.lines.iter().zip(&roots).flat_map(error).collect()
        };
        let parameters = start.parameters();
        let scale = start.scales();
        NonlinearFit::new(residuals, &parameters, &scale)
    }

    /// Whether the resonance is one.
    fn verdict(&self, plain: &NonlinearFit, full: Option<&NonlinearFit>) -> Result<(), NoResonance> {
        let places = self.lines.len() as f64;
        let needed = quantile(RESONANCE_UNKNOWNS, FALSE_ALARM / places);
        let Some(full) = full else { return Err(NoResonance::BelowNoise { gain: 0.0, needed }) };
        let cost = |fit: &NonlinearFit| fit.residual_variance * fit.dof as f64;
        let noise = if self.known { full.residual_variance.max(1.0) } else { full.residual_variance };
        let gain = (cost(plain) - cost(full)) / noise.max(f64::MIN_POSITIVE);
        if gain < needed {
            return Err(NoResonance::BelowNoise { gain, needed });
        }
        let values = Values::from_parameters(&full.parameters, self.reference_hz);
        let band = [self.lines[0].frequency_hz, self.lines[self.lines.len() - 1].frequency_hz];
        match values.resonance {
            Some(r)
                if r.motional_f > 0.0
                    && r.series_hz > band[0]
                    && r.series_hz < band[1]
                    && r.damping < 0.5 =>
            {
                Ok(())
            }
            Some(r) => Err(NoResonance::Outside { frequency_hz: r.series_hz, damping: r.damping }),
            None => Err(NoResonance::BelowNoise { gain, needed }),
        }
    }

    fn result(&self, fit: &NonlinearFit, reason: Option<NoResonance>) -> CircuitFit {
        let cost = fit.residual_variance * fit.dof as f64;
        let goodness = Goodness::of_lines(self.lines, fit.residual_variance, fit.dof);
        let values = Values::from_parameters(&fit.parameters, self.reference_hz);
        let estimate = |of: &dyn Fn(&Values) -> f64| Estimate {
            value: of(&values),
            u: variance(fit, self.reference_hz, of).sqrt() * goodness.widening(),
        };
        let resonance = match (reason, values.resonance) {
            (None, Some(r)) => Ok(Resonance {
                series_hz: estimate(&|v| v.resonance.map_or(0.0, |r| r.series_hz)),
                parallel_hz: estimate(&Values::parallel_hz),
                damping: estimate(&|v| v.resonance.map_or(0.0, |r| r.damping)),
                coupling: estimate(&Values::coupling),
                resistance_ohm: r.resistance_ohm(),
                inductance_h: r.inductance_h(),
                capacitance_f: r.motional_f,
            }),
            (Some(reason), _) => Err(reason),
            (None, None) => Err(NoResonance::BelowNoise { gain: 0.0, needed: 0.0 }),
        };
        CircuitFit {
            capacitance_f: estimate(&|v| v.capacitance_f),
            loss_tangent: estimate(&|v| (FRAC_PI_2 * v.loss_exponent).tan()),
            series_ohm: estimate(&|v| v.series_ohm),
            resonance,
            cost,
            dof: fit.dof,
            goodness,
            values,
        }
    }
}

/// Variance of a number that follows from the parameters: gradient by central differences of one standard
/// uncertainty.
fn variance(fit: &NonlinearFit, reference_hz: f64, of: &dyn Fn(&Values) -> f64) -> f64 {
    let covariance = &fit.unscaled_covariance;
    let n = fit.parameters.len();
    let gradient: Vec<f64> = (0..n)
        .map(|k| {
            let step = 1e-5 * fit.parameters[k].abs().max(1e-6);
            let cost = |sign: f64| {
                let mut moved = fit.parameters.clone();
                moved[k] += sign * step;
                of(&Values::from_parameters(&moved, reference_hz))
            };
            (cost(1.0) - cost(-1.0)) / (2.0 * step)
        })
        .collect();
    let row = nalgebra::DVector::from_vec(gradient);
    row.dot(&(covariance * &row)).max(0.0)
}
