//! Friction at one velocity: half the difference of the upper and the lower branch of the hysteresis loop.

use crate::estimate::Estimate;
use crate::least_squares::LinearFit;
use crate::uncertainty::{Component, correlation_factor, mean_of_repeats, within_and_between};

/// Harmonics of the cogging period that may modulate friction inside a period.
const HARMONICS: usize = 3;
/// Batches whose scatter tells the noise: as many as this on long maps, half as many on short ones.
const MOST_BATCHES: usize = 32;
const LEAST_BATCHES: usize = 16;
/// Coefficients of the slow change of friction over the angle: slope and curvature.
const TREND: usize = 2;
/// Least bins in a period for these harmonics to be told apart.
const LEAST_BINS: usize = 8;

/// What a slow change of friction along the grid is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlowChange {
    /// A property of the axis, whose mean over these angles is what it is.
    OfAxis,
    /// Perhaps a drift of what measures, which counts as noise of the mean.
    PerhapsDrift,
}

/// Half the difference of both directions, mean over the grid, with its type A uncertainty.
///
/// `forward` and `reverse` hold one binned map a stroke, all on the same grid of whole cogging periods, so cogging,
/// unbalance and spring cancel bin by bin. What is left of noise comes from the residual after a fit of the first
/// three cogging harmonics (velocity ripple modulates friction), as scatter of the means of batches of bins; the
/// scatter between pairs of strokes adds what it exceeds that noise (n − 1 degrees of freedom for n pairs).
///
/// `None` without one stroke each way or with maps of different length. Source: director study, section 3.1.
pub fn half_difference(
    forward: &[Vec<f64>],
    reverse: &[Vec<f64>],
    bins_per_period_count: usize,
    slow_change: SlowChange,
) -> Option<Estimate> {
    let pairs: Vec<Vec<f64>> = forward
        .iter()
        .zip(reverse)
        .map(|(f, r)| f.iter().zip(r).map(|(f, r)| (f - r) / 2.0).collect())
        .collect();
    let bins = pairs.first().map(Vec::len).filter(|&n| n > 0)?;
    if forward.iter().chain(reverse).any(|map| map.len() != bins) {
        return None;
    }
    let count = pairs.len() as f64;
    let mean: Vec<f64> = (0..bins).map(|k| pairs.iter().map(|p| p[k]).sum::<f64>() / count).collect();
    let within = within(&mean, bins_per_period_count, slow_change);
    let means: Vec<f64> = pairs.iter().map(|p| p.iter().sum::<f64>() / bins as f64).collect();
    let between = mean_of_repeats(&means).map(|(_, component)| component);
    let spread = between.map_or(within, |between| within_and_between(within, between));
    let value = mean.iter().sum::<f64>() / bins as f64;
    Some(Estimate { value, u: spread.u, dof: spread.dof, n: bins * pairs.len() })
}

/// Standard uncertainty of the mean of a map, from its residual about constant and cogging harmonics, and about slope and curvature
/// where these belong to the axis.
///
/// By the scatter of the means of batches: noise of the acceleration is blue (it cancels from bin to bin and must not
/// count), friction that wanders along the angle is red (what batches still correlate widens u).
fn within(map: &[f64], bins_per_period: usize, slow_change: SlowChange) -> Component {
    let trend = if slow_change == SlowChange::OfAxis { TREND } else { 0 };
    let harmonics = if bins_per_period >= LEAST_BINS { HARMONICS } else { 0 };
    let phase = |k: usize, h: usize| {
        std::f64::consts::TAU * (h * k % bins_per_period.max(1)) as f64 / bins_per_period as f64
    };
    let mut columns = vec![vec![1.0; map.len()]];
    let place = |k: usize| (2.0 * k as f64 + 1.0) / map.len() as f64 - 1.0;
    for power in 1..=trend as i32 {
        columns.push((0..map.len()).map(|k| place(k).powi(power)).collect());
    }
    for h in 1..=harmonics {
        columns.push((0..map.len()).map(|k| phase(k, h).cos()).collect());
        columns.push((0..map.len()).map(|k| phase(k, h).sin()).collect());
    }
    let Ok(fit) = LinearFit::new(&columns, map, None) else {
        return Component { u: spread(map), dof: 0.0 };
    };
    let length = (map.len() / MOST_BATCHES).max(map.len().min(8 * LEAST_BATCHES) / LEAST_BATCHES).max(1);
    let batches: Vec<f64> =
        fit.residuals.chunks_exact(length).map(|c| c.iter().sum::<f64>() / length as f64).collect();
    // Batches that resolve the harmonics have lost as many degrees of freedom to them.
    let spent = 1 + trend + if length * LEAST_BINS <= bins_per_period { 2 * harmonics } else { 0 };
    let count = batches.len() as f64;
    let free = batches.len().saturating_sub(spent) as f64;
    if free < 1.0 {
        return Component { u: spread(map), dof: 0.0 };
    }
    let factor = correlation_factor(&batches);
    let variance = batches.iter().map(|b| b * b).sum::<f64>() / free / count;
    Component { u: (variance * factor).sqrt(), dof: (free / factor).max(1.0) }
}

/// Largest deviation from the mean: all that too few bins can say.
fn spread(map: &[f64]) -> f64 {
    let mean = map.iter().sum::<f64>() / map.len() as f64;
    map.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Maps over `periods` periods of 16 bins: friction, cogging, a slope, and a seedless small ripple.
    fn map(sign: f64, periods: usize, extra: f64) -> Vec<f64> {
        (0..16 * periods)
            .map(|k| {
                let angle = k as f64 / 16.0;
                let ripple = 0.1 * (k as f64 * 2.399_963).sin() * sign;
                sign * (100.0 + extra) + 8.0 * (angle * std::f64::consts::TAU).sin() + 3.0 * angle + ripple
            })
            .collect()
    }

    #[test]
    fn cogging_and_slope_cancel_bin_by_bin() {
        let estimate = half_difference(&[map(1.0, 4, 0.0)], &[map(-1.0, 4, 0.0)], 16, SlowChange::OfAxis)
            .expect("one pair");
        assert!((estimate.value - 100.0).abs() < 0.02, "{estimate:?}");
        assert!(estimate.u > 0.003 && estimate.u < 0.02, "{estimate:?}");
        assert!(estimate.dof > 8.0 && estimate.dof <= 15.0, "sixteen batches: {estimate:?}");
    }

    /// A twentieth more friction at one end of the stroke than at the other is no noise of its mean.
    #[test]
    fn friction_that_changes_slowly_along_the_stroke_is_known_as_well_as_even_friction() {
        let with = |change: f64, sign: f64| {
            let mut map = map(sign, 60, 0.0);
            let bins = map.len() as f64;
            map.iter_mut().enumerate().for_each(|(k, v)| *v += sign * change * (k as f64 / bins - 0.5));
            map
        };
        let estimate = |change: f64| {
            half_difference(&[with(change, 1.0)], &[with(change, -1.0)], 16, SlowChange::OfAxis)
                .expect("one pair")
        };
        let [even, sloped] = [0.0, 10.0].map(estimate);
        assert!((sloped.value - even.value).abs() < 0.02, "{sloped:?}");
        assert!(sloped.u < 1.5 * even.u && sloped.dof > 10.0, "{even:?} {sloped:?}");
    }

    #[test]
    fn strokes_that_disagree_widen_u_and_cost_freedom() {
        let forward = [map(1.0, 4, 0.0), map(1.0, 4, 6.0)];
        let reverse = [map(-1.0, 4, 0.0), map(-1.0, 4, 6.0)];
        let estimate = half_difference(&forward, &reverse, 16, SlowChange::OfAxis).expect("two pairs");
        assert!((estimate.u - 3.0).abs() < 0.01, "s/√2 = 4.24/1.41: {estimate:?}");
        assert!(estimate.dof < 1.1);
    }

    #[test]
    fn a_missing_direction_is_none() {
        assert_eq!(half_difference(&[map(1.0, 4, 0.0)], &[], 16, SlowChange::OfAxis), None);
        assert_eq!(half_difference(&[map(1.0, 4, 0.0)], &[map(-1.0, 3, 0.0)], 16, SlowChange::OfAxis), None);
    }
}
