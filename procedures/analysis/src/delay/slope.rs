//! Delay as the slope of the phase.

use std::f64::consts::TAU;

use super::input::check_lines;
use super::{DelayError, Includes};
use crate::frf::{Line, unwrapped_rad};
use crate::goodness::Goodness;
use crate::least_squares::LinearFit;

/// φ(ω) = offset − ω·delay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseSlope {
    /// −dφ/dω, s.
    pub delay_s: f64,
    /// Standard uncertainty of `delay_s`, s.
    pub u_s: f64,
    /// Phase at zero frequency, rad.
    pub offset_rad: f64,
    /// Standard uncertainty of `offset_rad`, rad.
    pub offset_u_rad: f64,
    /// How well a straight line describes the phase.
    pub goodness: Goodness,
    /// What the delay holds.
    pub includes: Includes,
}

/// Weighted straight line through the unwrapped phase: weights 1/σ_φ², var(τ) = σ_φ²/Σ(ω − ω̄)² for equal lines.
///
/// Neighbouring lines must be less than 1/(2·delay) apart.
///
/// # Errors
/// Lines that are none, fewer than five; a phase that no straight line describes.
pub fn phase_slope(lines: &[Line]) -> Result<PhaseSlope, DelayError> {
    check_lines(lines, 5)?;
    let exact = lines.iter().all(|l| l.variance <= 0.0);
    let weight: Vec<f64> = lines.iter().map(|l| if exact { 1.0 } else { l.relative_sd().powi(-2) }).collect();
    let omega: Vec<f64> = lines.iter().map(|l| -TAU * l.frequency_hz).collect();
    let columns = [omega, vec![1.0; lines.len()]];
    let fit =
        LinearFit::new(&columns, &unwrapped_rad(lines), Some(&weight)).map_err(|_| DelayError::NoFit)?;
    let goodness = Goodness::of_lines(lines, fit.residual_variance, fit.dof);
    goodness.check()?;
    let u = |k: usize| fit.unscaled_covariance[(k, k)].sqrt() * goodness.widening();
    Ok(PhaseSlope {
        delay_s: fit.coefficients[0],
        u_s: u(0),
        offset_rad: fit.coefficients[1],
        offset_u_rad: u(1),
        goodness,
        includes: Includes::WholePhaseSlope,
    })
}
