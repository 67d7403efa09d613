//! Frequency response of any law, found by running it: small sine in, least squares over what comes out.

use core::f64::consts::TAU;

use crate::complex::Complex;

/// How a law is excited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Sample period of the law.
    pub period_s: f64,
    /// Input around which it is linearised.
    pub operating_point: f64,
    /// Size of the sine on top of it; small enough that no limit is met.
    pub amplitude: f64,
    /// Time for transients to die before anything is measured.
    pub settle_s: f64,
    /// Time that is measured; at least one period of the sine, better several.
    pub measure_s: f64,
}

/// Regressors: sine, cosine, and what integrators make of a sine that was switched on: a constant, a ramp.
const REGRESSORS: usize = 4;

/// Output per input of a law at a frequency, as a complex gain.
///
/// The output is fitted by `A sin ωt + B cos ωt + C + D t`; the gain is `(A + jB)/amplitude`. The constant and the
/// ramp take what single and double integrators keep from the start of the sine, so that laws with poles at z = 1 are
/// measured exactly; all other modes must have died within `settle_s`. `None` where the sine cannot be told from
/// the ramp (less than about a period measured, or a frequency at or above half the rate) or the law gives a number
/// that is not finite.
pub fn frequency_response(
    mut law: impl FnMut(f64) -> f64,
    probe: &Probe,
    frequency_hz: f64,
) -> Option<Complex> {
    let step_rad = TAU * frequency_hz * probe.period_s;
    let [settle, measure] = [probe.settle_s, probe.measure_s].map(|s| libm::round(s / probe.period_s));
    if !(step_rad > 0.0 && step_rad < TAU / 2.0 && measure >= 8.0 && settle >= 0.0) || probe.amplitude == 0.0
    {
        return None;
    }
    let mut normal = [[0.0; REGRESSORS + 1]; REGRESSORS];
    for k in 0..(settle + measure) as u64 {
        let phase_rad = step_rad * k as f64;
        let sine = libm::sin(phase_rad);
        let output = law(probe.operating_point + probe.amplitude * sine);
        let time = (k as f64 - settle) / measure * 2.0 - 1.0;
        if time >= -1.0 {
            accumulate(&mut normal, [sine, libm::cos(phase_rad), 1.0, time], output);
        }
    }
    let [in_phase, quadrature, ..] = solve(normal)?;
    Some(Complex::new(in_phase, quadrature) * (1.0 / probe.amplitude))
}

fn accumulate(normal: &mut [[f64; REGRESSORS + 1]; REGRESSORS], regressors: [f64; REGRESSORS], output: f64) {
    for (row, left) in normal.iter_mut().zip(regressors) {
        for (entry, right) in row.iter_mut().zip(regressors.iter().chain(core::iter::once(&output))) {
            *entry += left * right;
        }
    }
}

/// Gauss elimination; the matrix is positive definite, so the diagonal is a pivot. `None` where it is singular.
fn solve(mut m: [[f64; REGRESSORS + 1]; REGRESSORS]) -> Option<[f64; REGRESSORS]> {
    let scale = m[2][2];
    for column in 0..REGRESSORS {
        let pivot = m[column];
        // Negated, so that NaN is refused, too.
        if !(pivot[column] > 1e-6 * scale && pivot[REGRESSORS].is_finite()) {
            return None;
        }
        for (_, row) in m.iter_mut().enumerate().filter(|(index, _)| *index != column) {
            let factor = row[column] / pivot[column];
            row.iter_mut().zip(pivot).for_each(|(entry, above)| *entry -= factor * above);
        }
    }
    let solution = core::array::from_fn(|k| m[k][REGRESSORS] / m[k][k]);
    solution.iter().all(|x: &f64| x.is_finite()).then_some(solution)
}

#[cfg(test)]
mod tests;
