//! The mirror by itself: impedance of its actuators, response of its servo.

use analysis::frf::{C64, Frf, Line};

use crate::axis::Axes;
use crate::device::MIRROR_AXES;
use crate::measurement::Conclusion;

pub(in crate::kinds) mod fsm_impedance;
pub(in crate::kinds) mod fsm_response;

/// A conclusion about the mirror whose measurements belong to the axes that it and the trackers look along: cross-elevation belongs to the outer axis,
/// elevation to the inner one.
pub(in crate::kinds) fn on_gimbal(mut conclusion: Conclusion, axes: &Axes) -> Conclusion {
    let Ok(gimbal) = axes.gimbal() else { return conclusion };
    for measurement in &mut conclusion.measurements {
        if let Some(index) = MIRROR_AXES.iter().position(|word| *word == measurement.axis) {
            gimbal.names()[index].clone_into(&mut measurement.axis);
        }
    }
    conclusion
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
    let line = |l: usize, frequency_hz: f64| {
        let mean_u = mean(u, l);
        let mean_y = mean(y, l);
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
    frequencies_hz.iter().enumerate().map(|(l, &frequency_hz)| line(l, frequency_hz)).collect()
}
