//! Friction over velocity: the Stribeck curve, and the viscous line where there are only fast points.

use nalgebra::SMatrix;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::least_squares::LinearFit;

mod line;
mod minimise;

pub use line::ViscousLine;

#[cfg(test)]
mod tests;

/// Least number of velocities for all five parameters.
pub const LEAST_POINTS: usize = 15;
/// Significance that the curve must have over a straight line.
const SIGNIFICANCE: f64 = 0.999;
/// Bounds of the shape δ.
const SHAPE: [f64; 2] = [0.2, 6.0];

/// Friction at one velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// |ω|.
    pub velocity_rad_per_s: f64,
    /// Friction torque.
    pub friction_nm: f64,
    /// Standard uncertainty of the friction torque, without what all points share (torque constant).
    pub u_nm: f64,
}

/// Steady sliding: `T_C + (T_S − T_C)·exp(−(ω/ω_s)^δ) + σ2·ω`
/// (Armstrong-Hélouvry, Dupont & Canudas de Wit, *Automatica* 30, 1083, 1994).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Coulomb torque T_C.
    pub coulomb_nm: f64,
    /// Static torque T_S, as sliding shows it (ageing of the contact at the slowest velocities included).
    pub static_nm: f64,
    /// Stribeck velocity ω_s.
    pub stribeck_rad_per_s: f64,
    /// Viscous coefficient σ2.
    pub viscous_nm_s_per_rad: f64,
    /// Shape δ.
    pub shape_ratio: f64,
}

impl Parameters {
    /// Friction torque at |ω|.
    pub fn at_nm(&self, velocity_rad_per_s: f64) -> f64 {
        let fall = (-(velocity_rad_per_s / self.stribeck_rad_per_s).powf(self.shape_ratio)).exp();
        self.coulomb_nm
            + (self.static_nm - self.coulomb_nm) * fall
            + self.viscous_nm_s_per_rad * velocity_rad_per_s
    }

    /// Derivatives by T_C, T_S, ω_s, σ2, δ.
    pub fn gradient(&self, velocity_rad_per_s: f64) -> [f64; 5] {
        let ratio = velocity_rad_per_s / self.stribeck_rad_per_s;
        let power = ratio.powf(self.shape_ratio);
        let fall = (-power).exp();
        let drop = (self.static_nm - self.coulomb_nm) * fall * power;
        let log = if ratio > 0.0 { ratio.ln() } else { 0.0 };
        [1.0 - fall, fall, drop * self.shape_ratio / self.stribeck_rad_per_s, velocity_rad_per_s, -drop * log]
    }

    /// T_C, T_S, ω_s, σ2, δ.
    pub fn as_array(&self) -> [f64; 5] {
        [
            self.coulomb_nm,
            self.static_nm,
            self.stribeck_rad_per_s,
            self.viscous_nm_s_per_rad,
            self.shape_ratio,
        ]
    }
}

/// Why there is no Stribeck curve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoCurve {
    /// Too few velocities.
    #[error("{found} velocities, {LEAST_POINTS} needed")]
    TooFew {
        /// Velocities given.
        found: usize,
    },
    /// A velocity, torque or uncertainty is not a positive finite number.
    #[error("a velocity, torque or uncertainty is not a positive number")]
    NotPositive,
    /// A straight line explains the points as well.
    #[error("no Stribeck effect above noise (F = {f_ratio:.2}, needed {needed_ratio:.2})")]
    NoEffect {
        /// Variance ratio of curve against line.
        f_ratio: f64,
        /// Ratio that would be significant.
        needed_ratio: f64,
    },
    /// No velocity below the Stribeck velocity, or a parameter at its bound.
    #[error("{reason}")]
    NotDetermined {
        /// What is missing.
        reason: String,
    },
    /// The normal equations are singular at the minimum.
    #[error("the parameters cannot be told apart")]
    Singular,
}

/// A fitted curve.
#[derive(Clone, Debug, PartialEq)]
pub struct StribeckFit {
    /// The parameters.
    pub parameters: Parameters,
    /// Covariance of the parameters, in the order of [`Parameters::as_array`]: from the points' u, widened by χ²/dof where the
    /// points scatter more than that.
    pub covariance: SMatrix<f64, 5, 5>,
    /// χ² of the points.
    pub chi2_ratio: f64,
    /// Points minus parameters.
    pub dof_count: usize,
}

impl StribeckFit {
    /// Weighted least squares by Levenberg and Marquardt from several starts on a grid of (ω_s, δ), with ω_s and δ
    /// bounded and T_C, T_S − T_C, σ2 positive by transformed parameters.
    ///
    /// The start with the least χ² wins, the first of equals.
    ///
    /// # Errors
    /// See [`NoCurve`].
    pub fn new(points: &[Point]) -> Result<Self, NoCurve> {
        if points.len() < LEAST_POINTS {
            return Err(NoCurve::TooFew { found: points.len() });
        }
        let positive = |v: f64| v > 0.0 && v.is_finite();
        if !points.iter().all(|p| [p.velocity_rad_per_s, p.friction_nm, p.u_nm].into_iter().all(positive)) {
            return Err(NoCurve::NotPositive);
        }
        let bounds = Bounds::new(points);
        let (parameters, chi2) = minimise::from_all_starts(points, &bounds).ok_or(NoCurve::Singular)?;
        let dof = points.len() - 5;
        significant(points, chi2, dof)?;
        bounds.reject(&parameters)?;
        let scale = (chi2 / dof as f64).max(1.0);
        let covariance = fisher(points, &parameters).try_inverse().ok_or(NoCurve::Singular)? * scale;
        Ok(Self { parameters, covariance, chi2_ratio: chi2, dof_count: dof })
    }

    /// Standard uncertainty of parameter `k` in the order of [`Parameters::as_array`].
    pub fn u(&self, k: usize) -> f64 {
        self.covariance[(k, k)].max(0.0).sqrt()
    }

    /// Standard uncertainty of the curve at |ω|.
    pub fn u_at_nm(&self, velocity_rad_per_s: f64) -> f64 {
        let g = SMatrix::<f64, 5, 1>::from(self.parameters.gradient(velocity_rad_per_s));
        (g.transpose() * self.covariance * g)[0].max(0.0).sqrt()
    }
}

/// Fisher information of the points at these parameters; its inverse is the Cramér–Rao lower bound.
pub fn fisher(points: &[Point], parameters: &Parameters) -> SMatrix<f64, 5, 5> {
    let mut information = SMatrix::<f64, 5, 5>::zeros();
    for point in points {
        let g = SMatrix::<f64, 5, 1>::from(parameters.gradient(point.velocity_rad_per_s)) / point.u_nm;
        information += g * g.transpose();
    }
    information
}

/// The F test of the curve against a line.
fn significant(points: &[Point], chi2: f64, dof: usize) -> Result<(), NoCurve> {
    let one = vec![1.0; points.len()];
    let velocity: Vec<f64> = points.iter().map(|p| p.velocity_rad_per_s).collect();
    let friction: Vec<f64> = points.iter().map(|p| p.friction_nm).collect();
    let weight: Vec<f64> = points.iter().map(|p| 1.0 / (p.u_nm * p.u_nm)).collect();
    let line = LinearFit::new(&[one, velocity], &friction, Some(&weight)).map_err(|_| NoCurve::Singular)?;
    let line_chi2 = line.residual_variance * line.dof as f64;
    let per_dof = (chi2 / dof as f64).max(1.0);
    let f_ratio = (line_chi2 - chi2) / 3.0 / per_dof;
    let needed_ratio =
        FisherSnedecor::new(3.0, dof as f64).map_or(f64::INFINITY, |f| f.inverse_cdf(SIGNIFICANCE));
    if f_ratio < needed_ratio { Err(NoCurve::NoEffect { f_ratio, needed_ratio }) } else { Ok(()) }
}

/// Bounds of ω_s and δ.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    stribeck: [f64; 2],
    shape: [f64; 2],
    slowest: f64,
}

impl Bounds {
    fn new(points: &[Point]) -> Self {
        let velocities = || points.iter().map(|p| p.velocity_rad_per_s);
        let slowest = velocities().fold(f64::INFINITY, f64::min);
        let fastest = velocities().fold(0.0, f64::max);
        Self { stribeck: [slowest / 3.0, fastest], shape: SHAPE, slowest }
    }

    /// A minimum at a bound is none.
    fn reject(&self, parameters: &Parameters) -> Result<(), NoCurve> {
        let near = |value: f64, [low, high]: [f64; 2]| {
            let place = (value / low).ln() / (high / low).ln();
            !(0.01..=0.99).contains(&place)
        };
        let reason = if parameters.stribeck_rad_per_s < self.slowest {
            "no velocity below the Stribeck velocity"
        } else if near(parameters.stribeck_rad_per_s, self.stribeck) {
            "the Stribeck velocity runs into the fastest velocity"
        } else if near(parameters.shape_ratio, self.shape) {
            "the Stribeck shape runs into its bound (0.2 … 6)"
        } else {
            return Ok(());
        };
        Err(NoCurve::NotDetermined { reason: reason.to_owned() })
    }
}
