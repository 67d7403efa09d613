//! The five noises behind an Allan variance.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::gram::{Gram, variances};
use super::{AllanError, Deviation, Noise, Statistic, freedom};
use crate::goodness::Goodness;

/// Number of noises.
pub const FIT_TERMS: usize = 5;
/// Rounds of weights from the model; it settles in three or four.
const ROUNDS: usize = 12;
/// Change of the model's variances at which it has settled.
const SETTLED: f64 = 1e-6;
/// Fewest degrees of freedom of a variance that is still fitted: below, the variance is no measure of its own spread.
const LEAST_DOF: f64 = 2.0;
/// What keeps neighbouring averaging times from being taken for the same.
const RIDGE: f64 = 1e-9;
/// A squared coefficient is determined from this many of its standard uncertainties on.
const DETERMINED: f64 = 2.0;

/// A noise, in the order of [`NoiseFit::terms`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NoiseTerm {
    /// Coefficient ≥ 0: Q (unit·s), N (unit·√s), B (unit), K (unit/√s), R (unit/s), unit that of the rate.
    pub value: f64,
    /// Standard uncertainty of `value`, from that of its square.
    pub u: f64,
    /// Degrees of freedom of the square.
    pub dof: f64,
    /// 95 % interval; from 0 where it is not determined.
    pub interval: [f64; 2],
    /// Whether its square is at least twice its uncertainty.
    pub is_determined: bool,
}

/// σ²(τ) = 3Q²/τ² + N²/τ + (2·ln 2/π)·B² + K²·τ/3 + R²·τ²/2 (IEEE Std 952, annex C).
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseFit {
    /// Quantisation, random walk, bias instability, rate random walk, ramp.
    pub terms: [NoiseTerm; FIT_TERMS],
    /// Covariance of the squared coefficients; zero rows for those at zero.
    pub covariance: DMatrix<f64>,
    /// How well the five noises describe the record, correlation considered.
    pub goodness: Goodness,
    /// Averaging times that were fitted: those whose variance had at least two degrees of freedom.
    pub used: usize,
}

impl NoiseFit {
    /// Random walk N of the integral: the angle random walk of a gyro.
    pub fn random_walk(&self) -> NoiseTerm {
        self.terms[1]
    }

    /// Bias instability B; the deviation is 0.664·B where it is flat.
    pub fn bias_instability(&self) -> NoiseTerm {
        self.terms[2]
    }

    /// Rate random walk K.
    pub fn rate_walk(&self) -> NoiseTerm {
        self.terms[3]
    }

    /// Ramp R.
    pub fn ramp(&self) -> NoiseTerm {
        self.terms[4]
    }

    /// Deviation of the model.
    pub fn deviation(&self, tau_s: f64) -> f64 {
        model(&self.theta(), tau_s).sqrt()
    }

    fn theta(&self) -> [f64; FIT_TERMS] {
        self.terms.map(|t| t.value * t.value)
    }
}

fn model(theta: &[f64; FIT_TERMS], tau_s: f64) -> f64 {
    variances(tau_s).iter().zip(theta).map(|(a, t)| a * t).sum()
}

/// Fits the five noises to overlapping Allan deviations of a record of `rates` rates, `period_s` apart.
///
/// Generalised least squares of the variances with no coefficient below zero: variance 2σ⁴/ν with ν the equivalent
/// degrees of freedom of the noise that prevails, correlation between averaging times from the model's spectrum, both
/// of the model (not of the data, which would favour whatever came out low) and repeated until they settle. Octave
/// spacing says all that there is to say.
///
/// # Errors
/// [`AllanError::TooFewTimes`] for fewer than six averaging times with two degrees of freedom,
/// [`AllanError::NoFit`].
pub fn fit(deviations: &[Deviation], rates: usize, period_s: f64) -> Result<NoiseFit, AllanError> {
    let dof_of =
        |d: &&Deviation| freedom(Statistic::Oadev, Noise::FlickerRate, d.factor, rates).unwrap_or(0.0);
    let used: Vec<&Deviation> = deviations.iter().filter(|d| dof_of(d) >= LEAST_DOF).collect();
    if used.len() <= FIT_TERMS {
        return Err(AllanError::TooFewTimes { found: used.len(), least: FIT_TERMS + 1 });
    }
    let factors: Vec<usize> = used.iter().map(|d| d.factor).collect();
    let gram = Gram::new(&factors, period_s);
    let observed = DVector::from_iterator(used.len(), used.iter().map(|d| d.deviation * d.deviation));
    let design = DMatrix::from_fn(used.len(), FIT_TERMS, |i, k| variances(used[i].tau_s)[k]);
    let mut now = first_guess(&used);
    for _ in 0..ROUNDS {
        let before = &design * DVector::from_row_slice(&now);
        let problem = Problem::new(&design, &observed, &factors, &now, (&gram, rates));
        let problem = problem.ok_or(AllanError::NoFit)?;
        let (theta, active) = problem.solve().ok_or(AllanError::NoFit)?;
        now = theta;
        let after = &design * DVector::from_row_slice(&now);
        let settled = before.iter().zip(&after).all(|(b, a)| (a - b).abs() <= SETTLED * b.abs());
        if settled {
            return Ok(problem.result(&theta, active));
        }
    }
    let problem =
        Problem::new(&design, &observed, &factors, &now, (&gram, rates)).ok_or(AllanError::NoFit)?;
    let (theta, active) = problem.solve().ok_or(AllanError::NoFit)?;
    Ok(problem.result(&theta, active))
}

/// White noise from the shortest averaging time, and a floor where the deviation is least.
fn first_guess(used: &[&Deviation]) -> [f64; FIT_TERMS] {
    let square = |d: &Deviation| d.deviation * d.deviation;
    let least = used.iter().map(|d| square(d)).fold(f64::INFINITY, f64::min);
    let last = used[used.len() - 1];
    [0.0, used[0].tau_s * square(used[0]), least, 3.0 * square(last) / last.tau_s, 0.0]
}

/// One round: whitened design and observations.
struct Problem {
    design: DMatrix<f64>,
    observed: DVector<f64>,
    /// Size of each column, taken off for the sake of numbers.
    scale: Vec<f64>,
}

impl Problem {
    fn new(
        design: &DMatrix<f64>,
        observed: &DVector<f64>,
        factors: &[usize],
        theta: &[f64; FIT_TERMS],
        (gram, rates): (&Gram, usize),
    ) -> Option<Self> {
        let n = factors.len();
        let expected = design * DVector::from_row_slice(theta);
        let sd: Vec<f64> = (0..n)
            .map(|i| {
                let noise = prevailing(&design.row(i).iter().copied().collect::<Vec<_>>(), theta);
                let dof = freedom(Statistic::Oadev, noise, factors[i], rates).unwrap_or(1.0);
                expected[i] * (2.0 / dof).sqrt()
            })
            .collect();
        if sd.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
            return None;
        }
        let mut correlation = gram.correlation(theta);
        for k in 0..n {
            correlation[(k, k)] += RIDGE;
        }
        let root: Cholesky<f64, Dyn> = correlation.cholesky()?;
        let whiten = |column: DVector<f64>| {
            let by_sd = DVector::from_fn(n, |i, _| column[i] / sd[i]);
            root.l_dirty().solve_lower_triangular(&by_sd)
        };
        let columns: Option<Vec<DVector<f64>>> =
            design.column_iter().map(|column| whiten(column.into_owned())).collect();
        let mut columns = columns?;
        let scale: Vec<f64> = columns.iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
        columns.iter_mut().zip(&scale).for_each(|(c, s)| *c /= *s);
        Some(Self { design: DMatrix::from_columns(&columns), observed: whiten(observed.clone())?, scale })
    }

    /// Squared coefficients ≥ 0 with the least χ², and which of them are not held at zero. All 31 sets are tried: that
    /// is exact and needs no rule for leaving a corner.
    fn solve(&self) -> Option<([f64; FIT_TERMS], u32)> {
        let mut best: Option<(f64, [f64; FIT_TERMS], u32)> = None;
        for active in 1_u32..1 << FIT_TERMS {
            let Some((theta, chi2)) = self.restricted(active) else { continue };
            let better = best.as_ref().is_none_or(|(least, ..)| chi2 < *least);
            if better && theta.iter().all(|t| *t >= 0.0) {
                best = Some((chi2, theta, active));
            }
        }
        best.map(|(_, theta, active)| (theta, active))
    }

    fn columns(&self, active: u32) -> Vec<usize> {
        (0..FIT_TERMS).filter(|k| active >> k & 1 == 1).collect()
    }

    fn restricted(&self, active: u32) -> Option<([f64; FIT_TERMS], f64)> {
        let columns = self.columns(active);
        let design = self.design.select_columns(&columns);
        let normal = (design.transpose() * &design).cholesky()?;
        let found = normal.solve(&(design.transpose() * &self.observed));
        let chi2 = (&self.observed - &design * &found).norm_squared();
        let mut theta = [0.0; FIT_TERMS];
        for (&k, value) in columns.iter().zip(&found) {
            theta[k] = value / self.scale[k];
        }
        Some((theta, chi2))
    }

    /// Covariance with those columns.
    fn covariance(&self, active: u32) -> DMatrix<f64> {
        let columns = self.columns(active);
        let design = self.design.select_columns(&columns);
        let inverse = (design.transpose() * &design).cholesky().map(|c| c.inverse());
        let mut covariance = DMatrix::zeros(FIT_TERMS, FIT_TERMS);
        if let Some(inverse) = inverse {
            for (i, &row) in columns.iter().enumerate() {
                for (k, &column) in columns.iter().enumerate() {
                    covariance[(row, column)] = inverse[(i, k)] / (self.scale[row] * self.scale[column]);
                }
            }
        }
        covariance
    }

    fn result(&self, theta: &[f64; FIT_TERMS], active: u32) -> NoiseFit {
        let covariance = self.covariance(active);
        let chi2 = self.restricted(active).map_or(0.0, |(_, chi2)| chi2);
        let dof = self.observed.len() - self.columns(active).len();
        let terms = std::array::from_fn(|k| {
            if active >> k & 1 == 1 {
                return term(theta[k], covariance[(k, k)].sqrt());
            }
            // At zero: how much of it would still have gone unnoticed.
            let u = self.covariance(active | 1 << k)[(k, k)].sqrt();
            NoiseTerm { interval: [0.0, (1.96 * u).sqrt()], ..NoiseTerm::default() }
        });
        let goodness = Goodness::of_known(chi2 / dof as f64, dof);
        NoiseFit { terms, covariance, goodness, used: self.observed.len() }
    }
}

/// Root of a squared coefficient that is about χ² with 2·(value/u)² degrees of freedom.
fn term(square: f64, u: f64) -> NoiseTerm {
    let value = square.sqrt();
    let dof = if u > 0.0 { 2.0 * (square / u).powi(2) } else { f64::INFINITY };
    let is_determined = square >= DETERMINED * u;
    let high = (square + 1.96 * u).sqrt();
    let chi2 = ChiSquared::new(dof).ok().filter(|_| is_determined);
    let end = |p: f64| chi2.as_ref().map(|c| (square * dof / c.inverse_cdf(p)).sqrt());
    let interval = match (end(0.975), end(0.025)) {
        (Some(low), Some(high)) if low.is_finite() && high.is_finite() => [low, high],
        _ => [0.0, high],
    };
    NoiseTerm { value, u: if value > 0.0 { 0.5 * u / value } else { 0.0 }, dof, interval, is_determined }
}

/// The noise with the largest share of the model's variance.
fn prevailing(row: &[f64], theta: &[f64; FIT_TERMS]) -> Noise {
    const NOISES: [Noise; 4] = [Noise::WhitePhase, Noise::WhiteRate, Noise::FlickerRate, Noise::WalkRate];
    let share = |k: &usize| row[*k] * theta[*k];
    let most = (0..NOISES.len()).max_by(|a, b| share(a).total_cmp(&share(b)));
    most.map_or(Noise::WhiteRate, |k| NOISES[k])
}
