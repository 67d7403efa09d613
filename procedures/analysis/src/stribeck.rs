//! Friction torque over speed: the Stribeck curve, or a viscous line where all points lie at high speed.

use nalgebra::SMatrix;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::goodness::Goodness;
use crate::least_squares::LinearFit;

mod line;
mod minimise;

pub use line::ViscousLine;

#[cfg(test)]
mod tests;

/// Fewest velocities from which all five parameters are fitted.
pub const LEAST_POINTS: usize = 15;
/// Confidence level of the F test that the curve fits better than a straight line.
const SIGNIFICANCE: f64 = 0.999;
/// Bounds of the shape exponent δ, dimensionless.
const SHAPE: [f64; 2] = [0.2, 6.0];

/// Friction at one velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Speed |ω|, positive.
    pub velocity_rad_per_s: f64,
    /// Friction torque against the motion, positive.
    pub friction_nm: f64,
    /// Standard uncertainty of the friction torque. Errors common to all points (torque constant) are not part of it.
    pub u_nm: f64,
}

/// Friction torque in steady sliding: `T_C + (T_S − T_C)·exp(−(ω/ω_s)^δ) + σ2·ω`
/// (Armstrong-Hélouvry, Dupont & Canudas de Wit, *Automatica* 30, 1083, 1994).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Coulomb torque T_C.
    pub coulomb_nm: f64,
    /// Static torque T_S: the limit of the sliding curve at ω → 0. Ageing of the contact at the slowest velocities is part
    /// of it.
    pub static_nm: f64,
    /// Stribeck velocity ω_s.
    pub stribeck_rad_per_s: f64,
    /// Viscous coefficient σ2.
    pub viscous_nm_s_per_rad: f64,
    /// Shape exponent δ.
    pub shape_ratio: f64,
}

impl Parameters {
    /// Friction torque at |ω|.
    pub fn at_nm(&self, velocity_rad_per_s: f64) -> f64 {
        let static_share = (-(velocity_rad_per_s / self.stribeck_rad_per_s).powf(self.shape_ratio)).exp();
        self.coulomb_nm
            + (self.static_nm - self.coulomb_nm) * static_share
            + self.viscous_nm_s_per_rad * velocity_rad_per_s
    }

    /// Partial derivatives of the friction torque at |ω| with respect to T_C, T_S, ω_s, σ2 and δ, in this order.
    pub fn gradient(&self, velocity_rad_per_s: f64) -> [f64; 5] {
        let ratio = velocity_rad_per_s / self.stribeck_rad_per_s;
        let power = ratio.powf(self.shape_ratio);
        let static_share = (-power).exp();
        // Common factor of the derivatives by ω_s and δ.
        let common_nm = (self.static_nm - self.coulomb_nm) * static_share * power;
        // At standstill power·ln(ratio) tends to 0.
        let ln_ratio = if ratio > 0.0 { ratio.ln() } else { 0.0 };
        let by_stribeck = common_nm * self.shape_ratio / self.stribeck_rad_per_s;
        [1.0 - static_share, static_share, by_stribeck, velocity_rad_per_s, -common_nm * ln_ratio]
    }

    /// The parameters in the order T_C, T_S, ω_s, σ2, δ.
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

/// χ² over its degrees of freedom up to which scatter explains it: 2 is exceeded once in 400 fits of 20 degrees.
const TOLERATED_RATIO: f64 = 2.0;
/// Halvings of the interval in which the misfit lies: to 0.02 % of the largest residual.
const MISFIT_STEPS: usize = 12;
/// Misfit over the static torque beyond which the curve is none.
const HOPELESS_SHARE: f64 = 0.1;

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
        /// F statistic of the curve against the line.
        f_ratio: f64,
        /// Critical value of F: from here on the curve is significant.
        needed_ratio: f64,
    },
    /// No velocity below the Stribeck velocity, or a parameter at its bound.
    #[error("{reason}")]
    NotDetermined {
        /// What is missing.
        reason: String,
    },
    /// The points lie on no such curve.
    #[error(
        "no Stribeck curve: points deviate from every curve by {misfit_nm:.2} N*m (rms) beyond their \
         uncertainty, {most_nm:.2} N*m is allowed"
    )]
    Misfit {
        /// Departure beyond the uncertainties of the points, N·m.
        misfit_nm: f64,
        /// Largest departure of a curve that is still one, N·m.
        most_nm: f64,
    },
    /// The normal equations are singular at the minimum.
    #[error("the parameters cannot be separated")]
    Singular,
}

/// A fitted curve.
#[derive(Clone, Debug, PartialEq)]
pub struct StribeckFit {
    /// The parameters.
    pub parameters: Parameters,
    /// Covariance of the parameters, in the order of [`Parameters::as_array`]. It follows from the uncertainties of the
    /// points; where the points scatter more than those say (χ²/dof above 1), it is multiplied by χ²/dof.
    pub covariance: SMatrix<f64, 5, 5>,
    /// χ² of the points: sum of the squared residuals over their variances, not divided by the degrees of freedom. Those
    /// variances hold `misfit_nm`.
    pub chi2_ratio: f64,
    /// How far the points are from any such curve beyond their uncertainties, N·m (rms); 0 where those explain it.
    pub misfit_nm: f64,
    /// Degrees of freedom: number of points minus number of parameters.
    pub dof_count: usize,
}

impl StribeckFit {
    /// Fits the curve by weighted least squares (Levenberg–Marquardt) from several starts on a grid of (ω_s, δ).
    ///
    /// Transformed parameters keep ω_s and δ within their bounds, and T_C, T_S − T_C and σ2 positive. Of all starts the
    /// one with the least χ² is taken; of equal ones the first.
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
        let fit = Self::of_weights(points)?;
        if fit.chi2_ratio <= TOLERATED_RATIO * fit.dof_count as f64 {
            return Ok(fit);
        }
        fit.with_misfit(points)
    }

    /// The fit where each point departs from the curve by more than its own uncertainty: ageing and settling are not in the
    /// model. That misfit is the same at all velocities, while uncertainties span decades: weights of the slowest points
    /// alone would decide. The least misfit for which χ² equals its degrees of freedom is added to all.
    fn with_misfit(&self, points: &[Point]) -> Result<Self, NoCurve> {
        let residual = |p: &Point| (p.friction_nm - self.parameters.at_nm(p.velocity_rad_per_s)).abs();
        let most_nm = points.iter().map(residual).fold(0.0, f64::max);
        let widened = |misfit_nm: f64| -> Vec<Point> {
            points.iter().map(|p| Point { u_nm: p.u_nm.hypot(misfit_nm), ..*p }).collect()
        };
        let [mut low_nm, mut high_nm] = [0.0, most_nm];
        for _ in 0..MISFIT_STEPS {
            let middle_nm = 0.5 * (low_nm + high_nm);
            // Beside too large a misfit there may be no curve to be seen.
            let is_less = |fit: StribeckFit| fit.chi2_ratio > fit.dof_count as f64;
            if Self::of_weights(&widened(middle_nm)).is_ok_and(is_less) {
                low_nm = middle_nm;
            } else {
                high_nm = middle_nm;
            }
        }
        let fit = Self { misfit_nm: high_nm, ..Self::of_weights(&widened(high_nm))? };
        let most_nm = HOPELESS_SHARE * fit.parameters.static_nm;
        if high_nm > most_nm { Err(NoCurve::Misfit { misfit_nm: high_nm, most_nm }) } else { Ok(fit) }
    }

    fn of_weights(points: &[Point]) -> Result<Self, NoCurve> {
        let bounds = Bounds::new(points);
        let (parameters, chi2) = minimise::from_all_starts(points, &bounds).ok_or(NoCurve::Singular)?;
        let dof = points.len() - 5;
        significant(points, chi2, dof)?;
        bounds.reject(&parameters)?;
        // Points that scatter less than their uncertainties say do not make the parameters more certain.
        let widening = Goodness::of_known(chi2 / dof as f64, dof).variance_factor();
        let covariance = fisher(points, &parameters).try_inverse().ok_or(NoCurve::Singular)? * widening;
        Ok(Self { parameters, covariance, chi2_ratio: chi2, misfit_nm: 0.0, dof_count: dof })
    }

    /// Standard uncertainty of the parameter with index `k` in [`Parameters::as_array`], in the unit of that parameter.
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

/// F test of the curve against a straight line.
///
/// # Errors
/// [`NoCurve::NoEffect`] where the line fits as well; [`NoCurve::Singular`] where no line can be fitted.
fn significant(points: &[Point], chi2: f64, dof: usize) -> Result<(), NoCurve> {
    let one = vec![1.0; points.len()];
    let velocity: Vec<f64> = points.iter().map(|p| p.velocity_rad_per_s).collect();
    let friction: Vec<f64> = points.iter().map(|p| p.friction_nm).collect();
    let weight: Vec<f64> = points.iter().map(|p| 1.0 / (p.u_nm * p.u_nm)).collect();
    let line = LinearFit::new(&[one, velocity], &friction, Some(&weight)).map_err(|_| NoCurve::Singular)?;
    let line_chi2 = line.residual_variance * line.dof as f64;
    let chi2_per_dof = (chi2 / dof as f64).max(1.0);
    // The curve has three parameters more than the line: T_S, ω_s and δ.
    let f_ratio = (line_chi2 - chi2) / 3.0 / chi2_per_dof;
    let needed_ratio =
        FisherSnedecor::new(3.0, dof as f64).map_or(f64::INFINITY, |f| f.inverse_cdf(SIGNIFICANCE));
    if f_ratio < needed_ratio { Err(NoCurve::NoEffect { f_ratio, needed_ratio }) } else { Ok(()) }
}

/// Bounds of ω_s and δ in the fit.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// Of ω_s, rad/s. The lower one lies below all points: a fit that goes there is rejected afterwards.
    stribeck: [f64; 2],
    /// Of δ.
    shape: [f64; 2],
    /// Slowest velocity of the points, rad/s.
    slowest: f64,
}

impl Bounds {
    fn new(points: &[Point]) -> Self {
        let velocities = || points.iter().map(|p| p.velocity_rad_per_s);
        let slowest = velocities().fold(f64::INFINITY, f64::min);
        let fastest = velocities().fold(0.0, f64::max);
        Self { stribeck: [slowest / 3.0, fastest], shape: SHAPE, slowest }
    }

    /// Rejects parameters at a bound: χ² has no minimum there, so the points do not determine them.
    fn reject(&self, parameters: &Parameters) -> Result<(), NoCurve> {
        // Within the outer hundredths of the interval, which is divided logarithmically.
        let is_at_bound = |value: f64, [low, high]: [f64; 2]| {
            let position = (value / low).ln() / (high / low).ln();
            !(0.01..=0.99).contains(&position)
        };
        let reason = if parameters.stribeck_rad_per_s < self.slowest {
            "no velocity below the Stribeck velocity"
        } else if is_at_bound(parameters.stribeck_rad_per_s, self.stribeck) {
            "the Stribeck velocity runs into the fastest velocity"
        } else if is_at_bound(parameters.shape_ratio, self.shape) {
            "the Stribeck shape runs into its bound (0.2 … 6)"
        } else {
            return Ok(());
        };
        Err(NoCurve::NotDetermined { reason: reason.to_owned() })
    }
}
