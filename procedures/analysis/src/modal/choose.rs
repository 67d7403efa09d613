//! From candidate poles to modes: what is too weak goes, what the residual still shows comes in.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::super::frf::C64;
use super::super::rational::lines::Data;
use super::super::rational::projection::{evaluate, settle, solve};
use super::super::rational::relocation::first_pair;
use super::super::rational::shape::Shape;
use super::super::rational::solution::Solution;
use super::super::rational::{LINES_PER_UNKNOWN, RationalError};
use super::{Lower, Reason, Rejected, Settings, Upper};

/// Probability that noise alone gives a mode, or that noise alone looks like a misfit.
const FALSE_ALARM: f64 = 1e-3;
/// Standard uncertainties below 0 at which a damping ratio says "unstable".
const UNSTABLE_SIGMA: f64 = 3.0;
/// Residual over value, rms, that is rounding and not noise: below it nothing is sought.
const ROUNDING: f64 = 1e-12;
/// First pole of the rigid body with viscous friction, over the lowest line.
const VISCOUS_START: f64 = 0.1;

/// χ² of one degree count that noise exceeds with a probability.
pub(super) fn quantile(dof: usize, probability: f64) -> f64 {
    ChiSquared::new(dof.max(1) as f64).map_or(f64::INFINITY, |d| d.inverse_cdf(1.0 - probability))
}

/// Modes, being fitted.
pub(super) struct Choice<'a> {
    data: &'a Data,
    settings: &'a Settings,
    lower_terms: Vec<i32>,
    singles: usize,
    /// Weight below which a mode is noise: χ² of its parameters over all places where noise may look like one.
    least_weight: f64,
    /// Misfit that rounding makes.
    least_misfit: f64,
    pub(super) rejected: Vec<Rejected>,
}

impl<'a> Choice<'a> {
    pub(super) fn new(data: &'a Data, settings: &'a Settings) -> Self {
        let below = match settings.lower {
            Lower::None | Lower::Viscous => None,
            Lower::Mass => Some(-2),
            Lower::Rigid => Some(-1),
        };
        let above: &[i32] = match settings.upper {
            Upper::None => &[],
            Upper::Constant => &[0],
            Upper::Linear => &[1],
            Upper::Affine => &[0, 1],
        };
        let places = data.responses.iter().map(|r| r.s.len()).max().unwrap_or(1) as f64;
        let parameters = 2 + 2 * data.responses.len();
        let least_misfit = ROUNDING * ROUNDING * data.size() / (2 * data.line_count()) as f64;
        Self {
            data,
            settings,
            lower_terms: below.into_iter().chain(above.iter().copied()).collect(),
            singles: usize::from(settings.lower == Lower::Viscous),
            least_weight: quantile(parameters, FALSE_ALARM / places),
            least_misfit,
            rejected: Vec::new(),
        }
    }

    fn shape(&self, pairs: usize) -> Shape {
        Shape {
            pairs,
            singles: self.singles,
            terms: self.lower_terms.clone(),
            delay: self.settings.fits_delay,
        }
    }

    /// Unknowns of a number of modes and the residual terms.
    fn unknowns(&self, pairs: usize) -> usize {
        let shape = self.shape(pairs);
        shape.nonlinear_count() + self.data.responses.len() * shape.linear_count()
    }

    /// Unknowns of a single mode and the residual terms.
    pub(super) fn unknowns_of_one(&self) -> usize {
        self.unknowns(1)
    }

    /// Modes that the lines are enough for.
    pub(super) fn most_pairs(&self) -> usize {
        let allowed = self.data.line_count() / LINES_PER_UNKNOWN;
        allowed.saturating_sub(self.unknowns(0)) / (self.unknowns(1) - self.unknowns(0))
    }

    fn theta(&self, poles: &[C64]) -> Vec<f64> {
        let pairs = poles.iter().flat_map(|p| [-2.0 * p.re, p.norm_sqr()]);
        let single = (self.singles == 1).then(|| VISCOUS_START * self.data.lowest());
        pairs.chain(single).chain(self.settings.fits_delay.then_some(0.0)).collect()
    }

    /// Noise over what was stated, ≥ 1; for unknown variances the residual's; never below rounding.
    fn inflation(&self, misfit: f64) -> f64 {
        let least = if self.data.known { self.least_misfit.max(1.0) } else { self.least_misfit };
        misfit.max(least)
    }

    fn reject(&mut self, pole: C64, reason: Reason) {
        let scale_hz = self.data.scale_rad_per_s / std::f64::consts::TAU;
        let found =
            Rejected { frequency_hz: pole.norm() * scale_hz, damping: -pole.re / pole.norm(), reason };
        self.rejected.push(found);
    }

    /// Leaves out, with poles held, what does not carry its weight: spares the search most noise poles.
    fn screen(&mut self, mut poles: Vec<C64>) -> Result<Vec<C64>, RationalError> {
        loop {
            let shape = self.shape(poles.len());
            let theta = self.theta(&poles);
            let Ok(solution) = evaluate(self.data, &shape, &theta) else { return Ok(poles) };
            let inflation = self.inflation(solution.misfit());
            let weakest = (0..poles.len())
                .map(|k| (solution.weight_of_pair(k) / inflation, k))
                .min_by(|x, y| x.0.total_cmp(&y.0));
            match weakest {
                Some((weight, k)) if weight < self.least_weight => {
                    let pole = poles.remove(k);
                    self.reject(pole, Reason::Weak { weight, needed: self.least_weight });
                }
                _ => return Ok(poles),
            }
        }
    }

    /// Searches from `theta`, leaves out the weakest of what is no mode, searches again.
    fn refine(&mut self, mut theta: Vec<f64>, mut pairs: usize) -> Result<Solution, RationalError> {
        loop {
            let solution = match solve(self.data, &self.shape(pairs), &theta) {
                Err(RationalError::NotConverged) if pairs > 1 => {
                    // A pair that noise made may wander for ever: the one that carries least goes.
                    let (k, weight) = self.weakest(&theta, pairs)?;
                    let a = theta[2 * k];
                    let b = theta[2 * k + 1];
                    let pole = C64::new(-0.5 * a, (b - 0.25 * a * a).max(0.0).sqrt());
                    self.reject(pole, Reason::Weak { weight, needed: self.least_weight });
                    theta.drain(2 * k..2 * k + 2);
                    pairs -= 1;
                    continue;
                }
                other => other?,
            };
            let worst = (0..pairs)
                .filter_map(|k| {
                    self.judge(&solution, k).map(|reason| (solution.weight_of_pair(k), k, reason))
                })
                .min_by(|x, y| x.0.total_cmp(&y.0));
            let Some((_, k, reason)) = worst else { return Ok(solution) };
            self.reject(pole_of(&solution, k), reason);
            theta = solution.theta.clone();
            theta.drain(2 * k..2 * k + 2);
            pairs -= 1;
        }
    }

    /// The pair that carries least where all poles are held, and its weight.
    fn weakest(&self, theta: &[f64], pairs: usize) -> Result<(usize, f64), RationalError> {
        let held = evaluate(self.data, &self.shape(pairs), theta)?;
        let inflation = self.inflation(held.misfit());
        let weights = (0..pairs).map(|k| (k, held.weight_of_pair(k) / inflation));
        weights.min_by(|x, y| x.1.total_cmp(&y.1)).ok_or(RationalError::NotConverged)
    }

    /// Why section `k` is no mode.
    fn judge(&self, solution: &Solution, k: usize) -> Option<Reason> {
        let inflation = self.inflation(solution.misfit());
        let weight = solution.weight_of_pair(k) / inflation;
        let a = solution.theta[2 * k];
        let b = solution.theta[2 * k + 1];
        let frequency = b.max(0.0).sqrt();
        if weight < self.least_weight {
            return Some(Reason::Weak { weight, needed: self.least_weight });
        }
        if 0.25 * a * a >= b || frequency < self.data.lowest() || frequency > 1.0 {
            return Some(Reason::OutOfBand);
        }
        let damping = 0.5 * a / frequency;
        let sd = (solution.covariance[0][(2 * k, 2 * k)] * inflation).sqrt();
        if a < -(UNSTABLE_SIGMA * sd).max(self.data.spacing_at(frequency)) {
            return Some(Reason::Unstable);
        }
        (damping > self.settings.most_damping).then_some(Reason::Damping { most: self.settings.most_damping })
    }

    /// The fit of the candidates, then of what its residual still shows.
    pub(super) fn run(&mut self, candidates: Vec<C64>) -> Result<Solution, RationalError> {
        let poles = self.screen(candidates)?;
        let mut best = self.refine(self.theta(&poles), poles.len())?;
        while best.shape.pairs < self.most_pairs().min(self.settings.most_modes) && self.misses(&best) {
            let Some(pair) = self.residual_pair(&best) else { break };
            let mut theta = best.theta.clone();
            let at = 2 * best.shape.pairs;
            theta.splice(at..at, pair);
            let noted = self.rejected.len();
            let Ok(next) = self.refine(theta, best.shape.pairs + 1) else { break };
            if next.shape.pairs <= best.shape.pairs {
                break;
            }
            self.rejected.truncate(noted);
            best = next;
        }
        settle(self.data, best)
    }

    /// Whether the residual is more than noise, or nobody knows.
    fn misses(&self, solution: &Solution) -> bool {
        let noise = !self.data.known || solution.cost > quantile(solution.dof, FALSE_ALARM);
        noise && solution.misfit() > self.least_misfit
    }

    /// a, b of the pair that the residual shows at its largest.
    fn residual_pair(&self, solution: &Solution) -> Option<Vec<f64>> {
        let mut rest = self.data.clone();
        let mut largest = (0.0, 0.0);
        for (m, response) in rest.responses.iter_mut().enumerate() {
            for (k, s) in response.s.iter().enumerate() {
                response.value[k] -= solution.at(m, *s);
                let size = response.root[k] * response.value[k].norm();
                if size > largest.0 {
                    largest = (size, s.im);
                }
            }
        }
        let pair = first_pair(&rest, largest.1)?;
        // A pair that fell onto the real axis is no start for a mode.
        let narrow = pair[0] * pair[0] < 4.0 * pair[1] * self.settings.most_damping.powi(2);
        Some(if narrow { pair } else { vec![0.02 * largest.1, largest.1 * largest.1] })
    }
}

/// Upper pole of section `k`, scaled; on the axis if it is none.
pub(super) fn pole_of(solution: &Solution, k: usize) -> C64 {
    let a = solution.theta[2 * k];
    let b = solution.theta[2 * k + 1];
    C64::new(-0.5 * a, (b - 0.25 * a * a).max(0.0).sqrt())
}
