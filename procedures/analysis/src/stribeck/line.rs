//! Coulomb and viscous friction from the velocities of gross sliding alone.

use super::Point;
use crate::goodness::Goodness;
use crate::least_squares::LinearFit;

/// Points that a line needs at least.
const LEAST: usize = 3;
/// A point belongs to the line while it lies within this many standard uncertainties of it.
const BELONGS: f64 = 3.0;

/// `T_C + σ2·ω` through the fastest points that lie on one line.
#[derive(Clone, Debug, PartialEq)]
pub struct ViscousLine {
    /// T_C and its standard uncertainty.
    pub coulomb_nm: [f64; 2],
    /// σ2 and its standard uncertainty.
    pub viscous_nm_s_per_rad: [f64; 2],
    /// Covariance of the two.
    pub covariance: f64,
    /// Degrees of freedom: infinite where the points' own u rules, points − 2 where their scatter does.
    pub dof: f64,
    /// How well a line describes the points.
    pub goodness: Goodness,
    /// Slowest velocity that still belongs to it.
    pub from_rad_per_s: f64,
    /// Points on it.
    pub points_count: usize,
}

impl ViscousLine {
    /// Starts with the three fastest points and takes slower ones while they lie on the line of the faster ones
    /// (within 3 u of point and line together): what lies off it is the Stribeck effect.
    ///
    /// `None` for fewer than three points. The covariance comes from the points' u, widened by χ²/dof where they
    /// scatter more.
    pub fn new(points: &[Point]) -> Option<Self> {
        let mut sorted = points.to_vec();
        sorted.sort_by(|a, b| b.velocity_rad_per_s.total_cmp(&a.velocity_rad_per_s));
        if sorted.len() < LEAST || sorted.iter().any(|p| p.u_nm <= 0.0 || !p.u_nm.is_finite()) {
            return None;
        }
        let mut taken = LEAST;
        let mut line = fit(&sorted[..taken])?;
        while let Some(next) = sorted.get(taken) {
            let row = [1.0, next.velocity_rad_per_s];
            let widening = Goodness::of_known(line.residual_variance, line.dof).widening();
            let u_line = widening * line.u_at(&row) / line.residual_variance.max(f64::MIN_POSITIVE).sqrt();
            if (next.friction_nm - line.at(&row)).abs() > BELONGS * u_line.hypot(next.u_nm) {
                break;
            }
            taken += 1;
            line = fit(&sorted[..taken])?;
        }
        let rms = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
        let left_nm = rms(&mut line.residuals.iter().copied());
        let observed_nm = rms(&mut sorted[..taken].iter().map(|p| p.friction_nm));
        let goodness = Goodness::of_known(line.residual_variance, line.dof).with_share(left_nm / observed_nm);
        let covariance = &line.unscaled_covariance * goodness.variance_factor();
        Some(Self {
            coulomb_nm: [line.coefficients[0], covariance[(0, 0)].sqrt()],
            viscous_nm_s_per_rad: [line.coefficients[1], covariance[(1, 1)].sqrt()],
            covariance: covariance[(0, 1)],
            dof: goodness.dof(),
            goodness,
            from_rad_per_s: sorted[taken - 1].velocity_rad_per_s,
            points_count: taken,
        })
    }

    /// The line at |ω| and its standard uncertainty.
    pub fn at_nm(&self, velocity_rad_per_s: f64) -> [f64; 2] {
        let [c, u_c] = self.coulomb_nm;
        let [s, u_s] = self.viscous_nm_s_per_rad;
        let v = velocity_rad_per_s;
        let variance = u_c * u_c + 2.0 * v * self.covariance + v * v * u_s * u_s;
        [c + s * v, variance.max(0.0).sqrt()]
    }
}

fn fit(points: &[Point]) -> Option<LinearFit> {
    let velocity: Vec<f64> = points.iter().map(|p| p.velocity_rad_per_s).collect();
    let friction: Vec<f64> = points.iter().map(|p| p.friction_nm).collect();
    let weight: Vec<f64> = points.iter().map(|p| 1.0 / (p.u_nm * p.u_nm)).collect();
    LinearFit::new(&[vec![1.0; points.len()], velocity], &friction, Some(&weight)).ok()
}
