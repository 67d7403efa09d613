//! Lines of whole periods, and the response with errors in both channels.

use std::f64::consts::TAU;

use analysis::frf::{C64, Frf, Line};

/// Complex amplitudes X of X·e^(jωt) (t from the first sample) at whole numbers of periods in `samples`.
///
/// X = (2/N)·Σ x·e^(−j2πkn/N): exact for a record that holds whole periods only.
pub(super) fn amplitudes(samples: &[f64], orders: &[usize]) -> Vec<C64> {
    let n = samples.len();
    let mean = samples.iter().sum::<f64>() / n.max(1) as f64;
    let turns: Vec<C64> =
        (0..n).map(|k| C64::from_polar(2.0 / n as f64, -TAU * k as f64 / n as f64)).collect();
    let line = |&order: &usize| {
        samples.iter().enumerate().map(|(k, x)| turns[order * k % n] * (x - mean)).sum::<C64>()
    };
    orders.iter().map(line).collect()
}

/// Ĝ = Ȳ/Ū over P periods (periods × lines) with var Ĝ = Σ|δY − Ĝ·δU|²/(P(P−1)·|Ū|²), P − 1 complex degrees of
/// freedom (Pintelon & Schoukens, *System Identification*, 2nd ed., §2.4). The coherence is that of one period.
///
/// `None` for fewer than two periods or a line without input.
pub(in crate::kinds) fn errors_in_variables(
    frequencies_hz: &[f64],
    u: &[Vec<C64>],
    y: &[Vec<C64>],
) -> Option<Frf> {
    let p = u.len() as f64;
    if u.len() < 2 || u.len() != y.len() {
        return None;
    }
    let mean = |all: &[Vec<C64>], l: usize| all.iter().map(|w| w[l]).sum::<C64>() / p;
    let line = |(l, &frequency_hz): (usize, &f64)| {
        let (mean_u, mean_y) = (mean(u, l), mean(y, l));
        if mean_u.norm() <= 0.0 {
            return None;
        }
        let value = mean_y / mean_u;
        let rest = |w: usize| ((y[w][l] - mean_y) - value * (u[w][l] - mean_u)).norm_sqr();
        let noise = (0..u.len()).map(rest).sum::<f64>() / (p - 1.0);
        let signal = (mean_y.norm_sqr() - noise / p).max(0.0);
        let coherence = if signal > 0.0 { signal / (signal + noise) } else { 0.0 };
        let variance = noise / (p * mean_u.norm_sqr());
        Some(Line { frequency_hz, value, variance, dof: p - 1.0, coherence: Some(coherence) })
    };
    frequencies_hz.iter().enumerate().map(line).collect()
}
