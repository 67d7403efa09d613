//! A mode with the uncertainty of its frequency, damping and residues.

use std::f64::consts::TAU;

use super::super::frf::C64;
use super::super::goodness::Goodness;
use super::super::rational::lines::Data;
use super::super::rational::solution::Solution;
use super::choose::pole_of;
use super::{Damping, Mode, Unresolved};

/// Factor on all variances: what the residual exceeds the stated noise by.
pub(super) fn excess(data: &Data, solution: &Solution) -> f64 {
    if data.known { Goodness::of_known(solution.misfit(), solution.dof).variance_factor() } else { 1.0 }
}

/// Mode of section `k`.
pub(super) fn mode(data: &Data, solution: &Solution, k: usize, orders: usize) -> Mode {
    let scale = data.scale_rad_per_s;
    let factor = excess(data, solution);
    let a = solution.theta[2 * k];
    let b = solution.theta[2 * k + 1];
    let frequency = b.sqrt();
    let ratio = 0.5 * a / frequency;
    let covariance = |i: usize, j: usize| factor * solution.covariance[0][(2 * k + i, 2 * k + j)];
    let frequency_u = covariance(1, 1).sqrt() / (2.0 * frequency);
    // ζ = a/(2√b).
    let slope = [0.5 / frequency, -0.5 * ratio / b];
    let variance = slope[0] * slope[0] * covariance(0, 0)
        + 2.0 * slope[0] * slope[1] * covariance(0, 1)
        + slope[1] * slope[1] * covariance(1, 1);
    let all: Vec<Residue> = (0..solution.c.len()).map(|m| residue(solution, k, m, factor)).collect();
    let scaled = |u: fn(&Residue) -> f64| all.iter().map(|r| u(r) * scale).collect();
    Mode {
        frequency_hz: frequency * scale / TAU,
        frequency_u_hz: frequency_u * scale / TAU,
        damping: damping(
            ratio,
            variance.max(0.0).sqrt(),
            [a * scale / TAU, data.spacing_at(frequency) * scale / TAU],
        ),
        residues: all.iter().map(|r| r.value * scale).collect(),
        residue_u: scaled(|r| r.u),
        observed_u: scaled(|r| r.observed_u),
        orders,
    }
}

fn damping(ratio: f64, u: f64, [width_hz, spacing_hz]: [f64; 2]) -> Result<Damping, Unresolved> {
    if width_hz < spacing_hz {
        return Err(Unresolved::Spacing { width_hz: width_hz.max(0.0), spacing_hz });
    }
    if u > 0.5 * ratio {
        return Err(Unresolved::Noise { ratio, u });
    }
    Ok(Damping { ratio, u })
}

/// R with √(E|R̂ − R|²), and the same of R·e^(−pτ), scaled.
struct Residue {
    value: C64,
    u: f64,
    observed_u: f64,
}

/// R = (c·p + d)/(2jβ), p = −a/2 + jβ.
fn residue(solution: &Solution, k: usize, m: usize, factor: f64) -> Residue {
    let a = solution.theta[2 * k];
    let p = pole_of(solution, k);
    let beta = p.im;
    let c = solution.c[m][2 * k];
    let d = solution.c[m][2 * k + 1];
    let under = C64::new(0.0, 2.0 * beta);
    let r = (p * c + d) / under;
    let beta_a = -0.25 * a / beta;
    let beta_b = 0.5 / beta;
    let first = solution.shape.nonlinear_count();
    let mut slopes = vec![C64::default(); first + solution.shape.linear_count()];
    slopes[2 * k] = C64::new(-0.5, beta_a) * c / under - r * (beta_a / beta);
    slopes[2 * k + 1] = C64::new(0.0, beta_b) * c / under - r * (beta_b / beta);
    slopes[first + 2 * k] = p / under;
    slopes[first + 2 * k + 1] = under.inv();
    let u = |slopes: &[C64]| (factor * solution.variance_along(m, slopes)).sqrt();
    let own_u = u(&slopes);
    if solution.shape.delay {
        slopes[first - 1] = -p * r;
    }
    Residue { value: r, u: own_u, observed_u: u(&slopes) }
}
