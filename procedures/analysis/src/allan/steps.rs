//! The step in which a sensor puts out its numbers, from a record of its noise.

use super::screen::quantum_of;
use crate::estimate::Estimate;
use crate::uncertainty::rectangular_u;

/// Numbers that are looked at.
const MOST_VALUES: usize = 20_000;
/// Neighbours within this many steps are counted to find the step; over more of them its error adds up.
const NEAR_STEPS: f64 = 20.0;
/// Numbers on a grid are off it by less than this part of its step, as a root mean square.
const MOST_OFF_GRID: f64 = 0.05;

/// Two numbers of 32 bits that differ by less than this part of the largest are one, but for their rounding.
const ROUNDING_RATIO: f64 = 1.0 / (1 << 22) as f64;

/// Half of the last of these bits, relative. What a record shows most are few multiples of a coarse step, which round alike: no scatter
/// tells that.
const HALF_BIT_RATIO: f64 = 1.0 / (1 << 24) as f64;

/// What a record shows of the step of its numbers, in their unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutputStep {
    /// The numbers are multiples of this, but for their rounding, which is the uncertainty.
    Seen(Estimate),
    /// No step is seen, and there is none above this: numbers on a coarser grid would be further apart.
    AtMost(f64),
}

/// Step of the numbers of a record, which were written with 32 bits. A step far below the noise is found by the numbers in the order of
/// their size, where neighbours are one or a few steps apart. `None` where half of the record is a single number.
pub fn output_step(values: &[f64]) -> Option<OutputStep> {
    let values = &values[..values.len().min(MOST_VALUES)];
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rounding = ROUNDING_RATIO * sorted.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let firsts = sorted.windows(2).filter(|v| v[1] - v[0] > rounding).map(|v| v[1]);
    let different: Vec<f64> = sorted.first().copied().into_iter().chain(firsts).collect();
    let rounded = |v: &f64| different[different.partition_point(|d| d <= v).saturating_sub(1)];
    let in_time: Vec<f64> = values.iter().map(rounded).collect();
    let least = quantum_of(&in_time).or_else(|| quantum_of(&different));
    let seen = least.and_then(|least| refined(&sorted, least));
    seen.map(OutputStep::Seen).or_else(|| widest_gap(&sorted).map(OutputStep::AtMost))
}

/// Slope of the numbers over the steps that were counted up to them. `least` is the smallest difference, which errs by the rounding
/// of two numbers.
fn refined(sorted: &[f64], least: f64) -> Option<Estimate> {
    let gaps: Vec<f64> = sorted.windows(2).map(|v| v[1] - v[0]).collect();
    let near = gaps.iter().filter(|gap| **gap < NEAR_STEPS * least);
    let (way, steps) = near.fold((0.0, 0.0), |(way, steps), gap| (way + gap, steps + (gap / least).round()));
    // Neighbours that are all far apart are whole multiples of the smallest difference nevertheless.
    let step = if steps > 0.0 { way / steps } else { least };
    let mut counted = vec![0.0];
    counted.extend(gaps.iter().scan(0.0, |at, gap| {
        *at += (gap / step).round();
        Some(*at)
    }));
    let n = sorted.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
    let (value_mean, count_mean) = (mean(sorted), mean(&counted));
    let pairs = || sorted.iter().zip(&counted).map(|(v, k)| (v - value_mean, k - count_mean));
    let spread: f64 = pairs().map(|(_, k)| k * k).sum();
    if spread == 0.0 || n < 3.0 {
        return None;
    }
    let value = pairs().map(|(v, k)| v * k).sum::<f64>() / spread;
    let variance = pairs().map(|(v, k)| (v - value * k).powi(2)).sum::<f64>() / (n - 2.0);
    let is_grid = variance.sqrt() <= MOST_OFF_GRID * value;
    is_grid.then(|| {
        let of_bits = rectangular_u(HALF_BIT_RATIO * value);
        Estimate { value, u: (variance / spread).sqrt().hypot(of_bits), dof: n - 2.0, n: sorted.len() }
    })
}

/// Largest difference between neighbours in the middle half of the numbers.
fn widest_gap(sorted: &[f64]) -> Option<f64> {
    let quarter = sorted.len() / 4;
    let middle = &sorted[quarter..sorted.len() - quarter];
    let widest = middle.windows(2).map(|v| v[1] - v[0]).fold(0.0, f64::max);
    (widest > 0.0).then_some(widest)
}
