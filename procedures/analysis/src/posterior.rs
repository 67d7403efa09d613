//! Parameters from measured values of several sorts and from weak prior knowledge: the maximum a posteriori estimate by
//! Gauss–Newton (Gelman et al., *Bayesian Data Analysis*, 3rd ed., ch. 4 and 14), damped as by Levenberg and Marquardt where a
//! step makes the fit worse (Nocedal & Wright, *Numerical Optimization*, 2nd ed., ch. 10.3).
//!
//! Each measured value is a function of some parameters. With a function for each, values that say the same of one parameter are
//! weighted by their inverse variances, values that only say something of several parameters together move all of them, and a
//! parameter of which nothing was measured keeps its prior value.

use nalgebra::{DMatrix, DVector};

use crate::uncertainty::{Component, combine};

#[cfg(test)]
mod tests;

/// What is known of a parameter before anything was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// The value.
    pub value: f64,
    /// Standard uncertainty, same unit; larger than 0.
    pub u: f64,
    /// Smallest and largest value that it may have.
    pub range: [f64; 2],
    /// Whether it stays at its value.
    pub is_fixed: bool,
}

impl Prior {
    /// A step of this size from a value: back where forward would leave the range.
    pub fn step_from(&self, value: f64, size: f64) -> f64 {
        if value + size <= self.range[1] { size } else { -size }
    }
}

/// A measured value.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The value.
    pub value: f64,
    /// Standard uncertainty; 0 for what was counted.
    pub u: f64,
    /// Degrees of freedom; infinite for type B.
    pub dof: f64,
    /// Values of one series share a part of their errors, such as that of one torque constant.
    pub series: usize,
    /// Indices of the parameters that it depends on.
    pub parameters: Vec<usize>,
}

/// A parameter after the measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimated {
    /// The value.
    pub value: f64,
    /// Standard uncertainty with its degrees of freedom, that of the prior included.
    pub spread: Component,
    /// Standard uncertainty over that of the prior: 0 where the measurement says everything, 1 where it says nothing.
    pub prior_ratio: f64,
    /// Whether the measured values lie beyond an end of its range.
    pub is_at_end: bool,
    /// Observations that have a share in the value, largest first.
    pub shares: Vec<(usize, f64)>,
}

/// All parameters, and how the measured values fit them.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// The parameters, in the order of their priors.
    pub parameters: Vec<Estimated>,
    /// What each measured value is more than what the parameters say, in its standard uncertainty.
    pub residuals_u: Vec<f64>,
}

/// Iterations at most; a linear problem takes two. A magnitude that is known well makes a narrow, curved valley of its components.
const ITERATIONS: usize = 200;
/// Change of every parameter, in its prior uncertainty, at which the iteration ends.
const CONVERGED: f64 = 1e-9;
/// Largest change of a parameter in one iteration, in its prior uncertainty.
const LONGEST_STEP: f64 = 2.0;
/// Step of the differences that derivatives are taken from, in the prior uncertainty.
const DIFFERENCE: f64 = 1e-4;
/// A value is not taken to be more certain than this share of what the prior makes of it.
const LEAST_U_RATIO: f64 = 1e-5;
/// Damping after the first step that makes the fit worse, in the curvature of the priors, and by what it grows and falls.
const FIRST_DAMPING: f64 = 1.0;
const DAMPING_RATIO: f64 = 8.0;
/// Damping above which no step makes the fit better.
const LARGEST_DAMPING: f64 = 1e18;

impl Posterior {
    /// The parameters that explain the observations best. `predicted(i, parameters)` is what observation `i` would be; it must
    /// be finite.
    pub fn new(
        priors: &[Prior],
        observations: &[Observation],
        predicted: &dyn Fn(usize, &[f64]) -> f64,
    ) -> Self {
        let problem = Problem { priors, observations, predicted };
        let mut values: Vec<f64> = priors.iter().map(|prior| prior.value).collect();
        let mut model = problem.linearised(&values);
        let mut damping = 0.0;
        for _ in 0..ITERATIONS {
            let (step, _) = problem.step(&model, &values, damping);
            let (next, longest) = problem.moved(&values, &step);
            if problem.cost(&next, &model.u) > problem.cost(&values, &model.u) {
                damping = (DAMPING_RATIO * damping).max(FIRST_DAMPING);
                if damping > LARGEST_DAMPING {
                    break;
                }
                continue;
            }
            damping = if damping > FIRST_DAMPING { damping / DAMPING_RATIO } else { 0.0 };
            values = next;
            model = problem.linearised(&values);
            if longest < CONVERGED {
                break;
            }
        }
        problem.posterior(&model, &values)
    }
}

/// What is to be solved.
struct Problem<'a> {
    priors: &'a [Prior],
    observations: &'a [Observation],
    predicted: &'a dyn Fn(usize, &[f64]) -> f64,
}

/// The observations about some values of the parameters, in units of their uncertainties.
struct Linearised {
    /// A row for each observation, a column for each parameter.
    sensitivity: DMatrix<f64>,
    residuals: DVector<f64>,
    u: Vec<f64>,
}

impl Problem<'_> {
    fn linearised(&self, values: &[f64]) -> Linearised {
        let mut sensitivity = DMatrix::zeros(self.observations.len(), self.priors.len());
        let mut residuals = DVector::zeros(self.observations.len());
        let mut all_u = Vec::with_capacity(self.observations.len());
        let mut moved = values.to_vec();
        for (i, observation) in self.observations.iter().enumerate() {
            let here = (self.predicted)(i, values);
            for &k in observation.parameters.iter().filter(|&&k| !self.priors[k].is_fixed) {
                let prior = &self.priors[k];
                let step = prior.step_from(values[k], DIFFERENCE * prior.u);
                moved[k] = values[k] + step;
                let there = (self.predicted)(i, &moved);
                sensitivity[(i, k)] = (there - here) / step * prior.u;
                moved[k] = values[k];
            }
            let by_prior = sensitivity.row(i).norm();
            let u = observation.u.max(LEAST_U_RATIO * by_prior).max(f64::MIN_POSITIVE);
            sensitivity.row_mut(i).scale_mut(1.0 / u);
            residuals[i] = (observation.value - here) / u;
            all_u.push(u);
        }
        Linearised { sensitivity, residuals, u: all_u }
    }

    /// How far the values are from their priors, in the uncertainties of these.
    fn beyond_prior(&self, values: &[f64]) -> DVector<f64> {
        DVector::from_iterator(
            values.len(),
            values.iter().zip(self.priors).map(|(value, prior)| (value - prior.value) / prior.u),
        )
    }

    /// The damped Gauss–Newton step, in the uncertainties of the priors, and the parameters that it leaves at an end of their range.
    fn step(&self, model: &Linearised, values: &[f64], damping: f64) -> (DVector<f64>, Vec<usize>) {
        let mut sensitivity = model.sensitivity.clone();
        let mut at_end: Vec<usize> = Vec::new();
        loop {
            let mut gradient = sensitivity.tr_mul(&model.residuals) - self.beyond_prior(values);
            at_end.iter().for_each(|&k| gradient[k] = 0.0);
            let step = inverse_curvature(&sensitivity, damping) * gradient;
            let leaves = |&k: &usize| !at_end.contains(&k) && self.leaves_range(k, values[k], step[k]);
            let Some(leaving) = (0..values.len()).find(leaves) else {
                return (step.map(|one| one.clamp(-LONGEST_STEP, LONGEST_STEP)), at_end);
            };
            at_end.push(leaving);
            sensitivity.column_mut(leaving).fill(0.0);
        }
    }

    /// Whether a parameter is at an end of its range and a step would take it out.
    fn leaves_range(&self, k: usize, value: f64, step: f64) -> bool {
        let [least, most] = self.priors[k].range;
        step < -CONVERGED && value <= least || step > CONVERGED && value >= most
    }

    /// The values after the step, inside their ranges, and the largest change in the uncertainties of the priors.
    fn moved(&self, values: &[f64], step: &DVector<f64>) -> (Vec<f64>, f64) {
        let moved = |k: usize| {
            let Prior { u, range, is_fixed, .. } = self.priors[k];
            if is_fixed { values[k] } else { (values[k] + step[k] * u).clamp(range[0], range[1]) }
        };
        let next: Vec<f64> = (0..values.len()).map(moved).collect();
        let change = |k: usize| ((next[k] - values[k]) / self.priors[k].u).abs();
        let longest = (0..values.len()).map(change).fold(0.0, f64::max);
        (next, longest)
    }

    fn cost(&self, values: &[f64], u: &[f64]) -> f64 {
        let residual = |i: usize| (self.observations[i].value - (self.predicted)(i, values)) / u[i];
        let of_observations: f64 = (0..self.observations.len()).map(|i| residual(i).powi(2)).sum();
        of_observations + self.beyond_prior(values).norm_squared()
    }

    fn posterior(&self, model: &Linearised, values: &[f64]) -> Posterior {
        let inverse = inverse_curvature(&model.sensitivity, 0.0);
        let gain = &inverse * model.sensitivity.transpose();
        let (_, at_end) = self.step(model, values, 0.0);
        let estimated = |k: usize| {
            let prior = &self.priors[k];
            let mut components = self.by_series(k, &gain);
            let by_prior = inverse.row(k).norm();
            components.push(Component::known(by_prior));
            let spread = combine(&components);
            Estimated {
                value: values[k],
                spread: Component { u: spread.u * prior.u, dof: spread.dof },
                prior_ratio: spread.u,
                is_at_end: at_end.contains(&k),
                shares: self.shares(k, &gain, model),
            }
        };
        Posterior {
            parameters: (0..values.len()).map(estimated).collect(),
            residuals_u: model.residuals.iter().copied().collect(),
        }
    }

    fn series(&self) -> usize {
        self.observations.iter().map(|observation| observation.series + 1).max().unwrap_or(0)
    }

    /// What each series adds to the uncertainty of a parameter: as if all errors of a series were one, or none had to do with
    /// another, whichever is more.
    fn by_series(&self, k: usize, gain: &DMatrix<f64>) -> Vec<Component> {
        let one = |series: usize| {
            let own = || self.observations.iter().enumerate().filter(move |(_, o)| o.series == series);
            let together = own().map(|(i, _)| gain[(k, i)]).sum::<f64>().abs();
            let apart = own().map(|(i, _)| gain[(k, i)].powi(2)).sum::<f64>().sqrt();
            let dof = own().map(|(_, o)| o.dof).fold(f64::INFINITY, f64::min);
            Component { u: together.max(apart), dof }
        };
        (0..self.series()).map(one).collect()
    }

    /// Share of each observation in the value of a parameter.
    fn shares(&self, k: usize, gain: &DMatrix<f64>, model: &Linearised) -> Vec<(usize, f64)> {
        let share = |i: usize| (i, gain[(k, i)] * model.sensitivity[(i, k)]);
        let mut shares: Vec<(usize, f64)> = (0..self.observations.len()).map(share).collect();
        shares.retain(|(_, share)| *share > 0.0);
        shares.sort_by(|a, b| b.1.total_cmp(&a.1));
        shares
    }
}

/// (SᵀS + 1 + λ)⁻¹: without the damping λ the covariance of independent observations and priors, in the uncertainties of the priors.
fn inverse_curvature(sensitivity: &DMatrix<f64>, damping: f64) -> DMatrix<f64> {
    let count = sensitivity.ncols();
    let curvature = sensitivity.tr_mul(sensitivity) + (1.0 + damping) * DMatrix::identity(count, count);
    // Symmetric, and no eigenvalue below 1.
    curvature.cholesky().map_or_else(|| DMatrix::identity(count, count), |factor| factor.inverse())
}
