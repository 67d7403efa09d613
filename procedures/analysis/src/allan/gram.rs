//! How the variances of one record hang together.

use std::f64::consts::{LN_2, PI};

use nalgebra::DMatrix;

/// Points of the grid of frequencies per factor e.
const PER_E_FOLD: f64 = 150.0;
/// Lowest frequency, over the inverse of the longest averaging time.
const LOWEST: f64 = 0.01;

/// Squared transfer functions from the rate to each variance on a logarithmic grid of frequencies.
///
/// An overlapping Allan variance is ∫S(f)·|H(f)|² df over the periodogram, H = 2·sin⁴(πfτ)/(m·sin(πfτ0))², and lines of
/// a periodogram are independent: two variances of one record share the covariance ∫S²·|H₁|²·|H₂|² df/T.
pub(super) struct Gram {
    f_hz: Vec<f64>,
    /// A row an averaging time, each value times the root of its frequency step.
    shapes: DMatrix<f64>,
    period_s: f64,
}

impl Gram {
    pub(super) fn new(factors: &[usize], period_s: f64) -> Self {
        let longest = factors.iter().copied().max().unwrap_or(1) as f64 * period_s;
        let low = LOWEST / longest;
        let high = 0.5 / period_s;
        let count = (PER_E_FOLD * (high / low).ln()).ceil().max(2.0) as usize;
        let step = (high / low).ln() / count as f64;
        let f_hz: Vec<f64> = (0..count).map(|k| low * ((k as f64 + 0.5) * step).exp()).collect();
        let shapes = DMatrix::from_fn(factors.len(), count, |row, k| {
            let m = factors[row] as f64;
            let f = f_hz[k];
            let ratio = (PI * f * m * period_s).sin().powi(2) / (m * (PI * f * period_s).sin());
            2.0 * ratio * ratio * (f * step).sqrt()
        });
        Self { f_hz, shapes, period_s }
    }

    /// Correlation of the variances if the squared coefficients of the noises are `theta` (order of
    /// [`super::NoiseTerm`]); a drift is no noise.
    pub(super) fn correlation(&self, theta: &[f64; 5]) -> DMatrix<f64> {
        let mut weighted = self.shapes.clone();
        for (k, mut column) in weighted.column_iter_mut().enumerate() {
            column *= self.spectrum(theta, self.f_hz[k]);
        }
        let gram = &weighted * weighted.transpose();
        let root: Vec<f64> = (0..gram.nrows()).map(|k| gram[(k, k)].sqrt()).collect();
        DMatrix::from_fn(gram.nrows(), gram.ncols(), |i, k| {
            let scale = root[i] * root[k];
            if i == k {
                1.0
            } else if scale > 0.0 {
                gram[(i, k)] / scale
            } else {
                0.0
            }
        })
    }

    /// One-sided spectrum of the sampled rate.
    fn spectrum(&self, [q2, n2, b2, k2, _]: &[f64; 5], f_hz: f64) -> f64 {
        let sine = (PI * f_hz * self.period_s).sin();
        8.0 * q2 * sine * sine / self.period_s
            + 2.0 * n2
            + b2 / (PI * f_hz)
            + k2 / (2.0 * PI * PI * f_hz * f_hz)
    }
}

/// Variance that a squared coefficient of 1 gives at an averaging time (IEEE Std 952, annex C): quantisation 3/τ²,
/// random walk 1/τ, bias instability 2·ln 2/π, rate random walk τ/3, ramp τ²/2.
pub(super) fn variances(tau_s: f64) -> [f64; 5] {
    [3.0 / (tau_s * tau_s), 1.0 / tau_s, 2.0 * LN_2 / PI, tau_s / 3.0, tau_s * tau_s / 2.0]
}
