//! What of a record is no noise: quanta, drift.

use crate::least_squares::LinearFit;

/// Differences that are looked at for a quantum.
const MOST_DIFFERENCES: usize = 20_000;
/// A difference is a multiple of the quantum within this part of it.
const OFF_GRID: f64 = 0.05;
/// Share of the differences that must be.
const ON_GRID_SHARE: f64 = 0.99;
/// Blocks whose means show a drift.
const BLOCKS: usize = 16;

/// Step of the numbers of a record, in their unit: all differences are whole multiples of it. `None` where there is no
/// such step, or it cannot be told from noise.
pub fn quantum_of(values: &[f64]) -> Option<f64> {
    let steps: Vec<f64> =
        values.windows(2).take(MOST_DIFFERENCES).map(|v| (v[1] - v[0]).abs()).filter(|d| *d > 0.0).collect();
    let size = values.iter().take(MOST_DIFFERENCES).fold(0.0_f64, |most, v| most.max(v.abs()));
    // What is left of a number below this is rounding.
    let least =
        steps.iter().copied().filter(|d| *d > 4.0 * f64::EPSILON * size).fold(f64::INFINITY, f64::min);
    if !least.is_finite() || steps.len() < BLOCKS {
        return None;
    }
    let off = |d: &&f64| {
        let ratio = *d / least;
        (ratio - ratio.round()).abs() > OFF_GRID
    };
    let on_grid = steps.iter().filter(|d| !off(d)).count();
    // Neighbours on the grid that are far apart say nothing: noise has as many near a multiple by chance.
    let near = steps.iter().filter(|d| **d < 20.0 * least).count();
    let is_grid = on_grid as f64 >= ON_GRID_SHARE * steps.len() as f64 && near * 4 >= steps.len();
    is_grid.then_some(least)
}

/// A straight line through a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Slope, unit of the values per s.
    pub slope_per_s: f64,
    /// Standard uncertainty of `slope_per_s` from the scatter of 16 block means.
    pub u: f64,
}

impl Drift {
    /// Whether it is beyond what the scatter of the block means explains (5 u; a random walk may do that, too).
    pub fn is_significant(&self) -> bool {
        self.slope_per_s.abs() > 5.0 * self.u
    }
}

/// Drift of a record `period_s` apart: a line through the means of 16 blocks; `None` for a record shorter than that.
pub fn drift(values: &[f64], period_s: f64) -> Option<Drift> {
    let length = values.len() / BLOCKS;
    if length == 0 {
        return None;
    }
    let means: Vec<f64> =
        values.chunks_exact(length).take(BLOCKS).map(|b| b.iter().sum::<f64>() / length as f64).collect();
    let time: Vec<f64> = (0..BLOCKS).map(|k| (k * length) as f64 * period_s).collect();
    let line = LinearFit::new(&[vec![1.0; BLOCKS], time], &means, None).ok()?;
    Some(Drift { slope_per_s: line.coefficients[1], u: line.u(1) })
}
