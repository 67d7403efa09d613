//! Rational functions fitted to frequency responses: a smooth response between lines, with uncertainty.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::frf::{C64, Frf};

mod disturbance;
pub(crate) mod lines;
mod normal;
pub(crate) mod projection;
pub(crate) mod relocation;
mod search;
mod select;
pub(crate) mod shape;
pub(crate) mod solution;
#[cfg(test)]
pub(crate) mod tests;

use lines::Data;
pub use lines::LineError;
use projection::{check_count, settle, solve};
use shape::Shape;
use solution::Solution;

/// Fewest lines per unknown.
pub const LINES_PER_UNKNOWN: usize = 3;

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RationalError {
    /// The lines cannot be used.
    #[error(transparent)]
    Lines(#[from] LineError),
    /// Fewer than three lines per unknown.
    #[error(
        "{lines} lines for {unknowns} unknowns: expected at least {needed}; measure more lines or use fewer poles"
    )]
    TooFew {
        /// Lines of all responses.
        lines: usize,
        /// Real unknowns.
        unknowns: usize,
        /// Lines needed.
        needed: usize,
    },
    /// A delay is not finite, or a power is named twice.
    #[error("expected a finite delay and powers of s each named once")]
    Settings,
    /// The search for poles did not end.
    #[error("no minimum was found: use fewer poles or a narrower band")]
    NotConverged,
    /// Unknowns that the lines do not tell apart.
    #[error("the lines do not determine all unknowns: use fewer poles")]
    Dependent,
}

/// What is known of the delay e^(−sτ) beside the rational function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delay {
    /// Known, s; 0 for none.
    Known(f64),
    /// Fitted from this first value, s.
    Fitted(f64),
}

/// What is fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Number of poles.
    pub poles: usize,
    /// Powers of s beside the poles: 0 for a constant, 1 for a slope at high, −1, −2 for integrators at low frequency.
    pub terms: Vec<i32>,
    /// Delay.
    pub delay: Delay,
    /// Whether first poles to the right of the axis are mirrored. Also with it the final search may cross the axis
    /// where the lines say so.
    pub stable: bool,
}

/// One or several responses as rational functions with common poles:
/// `e^(−sτ)·(Σ r/(s − p) + Σ t·s^k)`, s = jω.
///
/// Maximum likelihood for circular complex normal noise of the lines' variances: minimises Σ 2|Ĝ − G|²/variance, whose
/// mean is `dof` where the model holds (Pintelon & Schoukens, *System Identification*, 2nd ed., §7.9 and §9.11).
/// Starts by relaxed vector fitting, ends by Levenberg–Marquardt with analytic slopes and residues eliminated.
/// Variances of 0 on all lines stand for "unknown, the same on all lines": then the residual gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct RationalFit {
    /// Poles, rad/s, both of each pair.
    pub poles: Vec<C64>,
    /// Residue of each pole, of each response: response unit × rad/s.
    pub residues: Vec<Vec<C64>>,
    /// Coefficient of each power in [`Settings::terms`], of each response: response unit × s^k.
    pub terms: Vec<Vec<f64>>,
    /// Delay, s.
    pub delay_s: f64,
    /// Standard uncertainty of `delay_s`, s; 0 if it was known.
    pub delay_u_s: f64,
    /// Σ 2|Ĝ − G|²/variance, or Σ|Ĝ − G|² where no variance is known.
    pub cost: f64,
    /// Real numbers observed less unknowns; the cost is χ² of that many degrees where the model holds.
    pub dof: usize,
    known_delay_s: f64,
    scale_rad_per_s: f64,
    solution: Solution,
}

impl RationalFit {
    /// Fits `frfs`, which share poles and delay.
    ///
    /// # Errors
    /// See [`RationalError`].
    pub fn new(frfs: &[Frf], settings: &Settings) -> Result<Self, RationalError> {
        let (start_s, fitted) = match settings.delay {
            Delay::Known(delay_s) => (delay_s, false),
            Delay::Fitted(delay_s) => (delay_s, true),
        };
        let twice = (1..settings.terms.len()).any(|k| settings.terms[..k].contains(&settings.terms[k]));
        if !start_s.is_finite() || twice {
            return Err(RationalError::Settings);
        }
        let data = Data::new(frfs, start_s)?;
        let lines = data.line_count();
        if settings.poles > lines {
            let unknowns = settings.poles;
            let needed = unknowns.saturating_mul(LINES_PER_UNKNOWN);
            return Err(RationalError::TooFew { lines, unknowns, needed });
        }
        let shape = Shape {
            pairs: settings.poles / 2,
            singles: settings.poles % 2,
            terms: settings.terms.clone(),
            delay: fitted,
        };
        check_count(&data, &shape)?;
        let mut theta = if settings.poles == 0 {
            Vec::new()
        } else {
            relocation::first_poles(&data, settings.poles, &settings.terms, settings.stable)
                .ok_or(RationalError::NotConverged)?
        };
        // What is left of the delay after the first value was taken out.
        theta.extend(fitted.then_some(0.0));
        let solution = settle(&data, solve(&data, &shape, &theta)?)?;
        Ok(Self::from_solution(solution, data.scale_rad_per_s, start_s))
    }

    /// Fits one response with as few poles as describe it: from `poles` of the settings up to `most_poles`, by the
    /// Bayesian information criterion (Schwarz, *Ann. Stat.* 6, 461, 1978).
    ///
    /// Orders that bend between two lines (a pole narrower than their spacing inside the band) are passed over: such
    /// a fit is no interpolant.
    ///
    /// # Errors
    /// Those of [`RationalFit::new`] if no order gives a fit.
    pub fn select(frf: &Frf, settings: &Settings, most_poles: usize) -> Result<Self, RationalError> {
        select::select(frf, settings, most_poles)
    }

    pub(crate) fn from_solution(solution: Solution, scale_rad_per_s: f64, known_delay_s: f64) -> Self {
        let shape = &solution.shape;
        let last = shape.nonlinear_count().wrapping_sub(1);
        let (rest_s, delay_u_s) = if shape.delay {
            let variance = solution.covariance[0][(last, last)];
            (solution.theta[last] / scale_rad_per_s, variance.sqrt() / scale_rad_per_s)
        } else {
            (0.0, 0.0)
        };
        let units = shape.linear_units(scale_rad_per_s);
        let first = 2 * shape.pairs + shape.singles;
        let terms = |c: &Vec<f64>| c[first..].iter().zip(&units[first..]).map(|(c, u)| c * u).collect();
        Self {
            poles: poles(&solution).iter().map(|p| p * scale_rad_per_s).collect(),
            residues: solution
                .c
                .iter()
                .map(|c| residues(&solution, c).iter().map(|r| r * scale_rad_per_s).collect())
                .collect(),
            terms: solution.c.iter().map(terms).collect(),
            delay_s: known_delay_s + rest_s,
            delay_u_s,
            cost: solution.cost,
            dof: solution.dof,
            known_delay_s,
            scale_rad_per_s,
            solution,
        }
    }

    fn s(&self, frequency_hz: f64) -> C64 {
        C64::new(0.0, TAU * frequency_hz / self.scale_rad_per_s)
    }

    /// First response at a frequency in Hz, delay included.
    pub fn at(&self, frequency_hz: f64) -> C64 {
        self.response_at(0, frequency_hz)
    }

    /// E|Ĝ − G|² of the first response at a frequency in Hz, as far as the lines' noise goes.
    pub fn variance_at(&self, frequency_hz: f64) -> f64 {
        self.response_variance_at(0, frequency_hz)
    }

    /// Response `response` (< number of responses) at a frequency in Hz.
    pub fn response_at(&self, response: usize, frequency_hz: f64) -> C64 {
        let turn = C64::from_polar(1.0, -TAU * frequency_hz * self.known_delay_s);
        self.solution.at(response, self.s(frequency_hz)) * turn
    }

    /// E|Ĝ − G|² of response `response` at a frequency in Hz.
    pub fn response_variance_at(&self, response: usize, frequency_hz: f64) -> f64 {
        self.solution.variance_at(response, self.s(frequency_hz))
    }

    /// Cost over dof: 1 on average where the model holds and variances are known.
    pub fn misfit_ratio(&self) -> f64 {
        self.solution.misfit()
    }

    /// Covariance of the parameters of one response, inverse Fisher information: a (rad/s) and b (rad²/s²) of each
    /// section of second order `(c·s + d)/(s² + a·s + b)`, q of one of first order `c/(s + q)`, τ (s) if fitted; then
    /// c, d of each, c, and the terms. Sections follow [`RationalFit::poles`].
    pub fn covariance(&self, response: usize) -> DMatrix<f64> {
        let shape = &self.solution.shape;
        let mut units = shape.nonlinear_units(self.scale_rad_per_s);
        units.extend(shape.linear_units(self.scale_rad_per_s));
        let n = units.len();
        DMatrix::from_fn(n, n, |k, l| self.solution.covariance[response][(k, l)] * units[k] * units[l])
    }
}

/// Roots of s² + a·s + b, the upper or larger one first.
fn roots(a: f64, b: f64) -> [C64; 2] {
    let half = 0.25 * a * a - b;
    if half < 0.0 {
        let p = C64::new(-0.5 * a, (-half).sqrt());
        return [p, p.conj()];
    }
    // The larger one without cancellation, the other by their product; never twice the same, for the residues' sake.
    let half = half.max(1e-16 * a * a).max(f64::MIN_POSITIVE);
    let far = -0.5 * a - half.sqrt().copysign(a);
    let near = if far == 0.0 { 0.0 } else { b / far };
    [C64::new(far, 0.0), C64::new(near, 0.0)]
}

/// Poles of a solution, scaled.
pub(crate) fn poles(solution: &Solution) -> Vec<C64> {
    let (sections, rest) = solution.theta.split_at(2 * solution.shape.pairs);
    let pairs = sections.chunks_exact(2).flat_map(|ab| roots(ab[0], ab[1]));
    pairs.chain(rest[..solution.shape.singles].iter().map(|q| C64::new(-q, 0.0))).collect()
}

/// Residues of a solution for the linear parameters of one response, scaled.
fn residues(solution: &Solution, c: &[f64]) -> Vec<C64> {
    let pairs = solution.shape.pairs;
    let of_pair = |(k, ab): (usize, &[f64])| {
        let [one, other] = roots(ab[0], ab[1]);
        let residue = |p: C64, q: C64| (p * c[2 * k] + c[2 * k + 1]) / (p - q);
        [residue(one, other), residue(other, one)]
    };
    let sections = solution.theta[..2 * pairs].chunks_exact(2).enumerate().flat_map(of_pair);
    sections.chain(c[2 * pairs..][..solution.shape.singles].iter().map(|c| C64::new(*c, 0.0))).collect()
}
