//! Step response of a closed loop from its frequency response.

use num_complex::Complex64;

/// Half a period of the square wave that stands for the step: everything has settled long before it.
const SETTLED_S: f64 = 20.0;
/// Highest frequency of the series.
const HIGHEST_HZ: f64 = 40.0;
/// Time resolution of the result.
const STEP_S: f64 = 1e-3;
/// How far the response is followed.
const FOLLOWED_S: f64 = 5.0;

/// Figures of a step response of final value 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepResponse {
    /// From 10 % to 90 %.
    pub rise_s: f64,
    /// From the command until it stays within ± 2 %.
    pub settling_s: f64,
    /// Largest value beyond 1; 0 if it never passes it.
    pub overshoot_ratio: f64,
}

/// The answer of a closed loop with unit gain at 0 Hz to a step, by the Fourier series of a slow square wave.
pub fn step_response(closed: impl Fn(f64) -> Complex64) -> StepResponse {
    let base_hz = 0.5 / SETTLED_S;
    let harmonics = (HIGHEST_HZ / base_hz) as u32;
    // Each harmonic as it stands, and how far it turns in a step.
    let mut terms: Vec<(Complex64, Complex64)> = (1..=harmonics)
        .step_by(2)
        .map(|n| {
            let hz = base_hz * f64::from(n);
            let turn = Complex64::from_polar(1.0, std::f64::consts::TAU * hz * STEP_S);
            (closed(hz) * (2.0 / (std::f64::consts::PI * f64::from(n))), turn)
        })
        .collect();
    let mut value = || {
        let sum: f64 = terms
            .iter_mut()
            .map(|(term, turn)| {
                let now = term.im;
                *term *= *turn;
                now
            })
            .sum();
        0.5 + sum
    };
    let samples = (0..(FOLLOWED_S / STEP_S) as u32).map(|_| value()).collect::<Vec<_>>();
    step_figures(&samples, STEP_S)
}

/// Figures of a response that was sampled from the command on.
pub fn step_figures(samples: &[f64], step_s: f64) -> StepResponse {
    let first = |level: f64| {
        let k = samples.iter().position(|y| *y >= level).unwrap_or(samples.len());
        if k == 0 || k == samples.len() {
            return k as f64 * step_s;
        }
        let before = samples[k - 1];
        let after = samples[k];
        (k as f64 - (after - level) / (after - before)) * step_s
    };
    let outside = samples.iter().rposition(|y| (y - 1.0).abs() > 0.02).map_or(0, |k| k + 1);
    let highest = samples.iter().fold(1.0_f64, |top, y| top.max(*y));
    StepResponse {
        rise_s: first(0.9) - first(0.1),
        settling_s: outside as f64 * step_s,
        overshoot_ratio: highest - 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_order_loop_rises_in_2_197_and_settles_in_3_912_time_constants() {
        let found = step_response(|hz| 1.0 / Complex64::new(1.0, std::f64::consts::TAU * hz * 0.25));
        assert!((found.rise_s - 0.25 * 9.0_f64.ln()).abs() < 2e-3, "{found:?}");
        assert!((found.settling_s - 0.25 * 50.0_f64.ln()).abs() < 3e-3, "{found:?}");
        assert!(found.overshoot_ratio < 1e-3);
    }
}
