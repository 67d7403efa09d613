//! Finding the lines of a spectrum that stand above noise, and their exact orders.

use std::f64::consts::{LN_2, TAU};

use nalgebra::Complex;

use super::branch::Background;
use super::{Branch, LEAST_SHARE, Settings};

/// Most harmonics that are looked for.
const MOST_PICKS: usize = 48;
/// Rounds of transform, picking and subtracting.
const MOST_ROUNDS: usize = 6;
/// Rounds of refinement of all orders.
const GAUSS_NEWTON_STEPS: usize = 4;
/// Power over mean noise power at which a line counts as seen: e^(−16) per line is 1e-7.
const SEEN: f64 = 16.0;

/// Orders of the plain transform.
pub(super) struct OrderGrid {
    /// Orders, from one step up.
    pub(super) orders: Vec<f64>,
    /// One over the span in turns.
    pub(super) step: f64,
    /// Index of the first order that is not unbalance, spring or their leftovers.
    first: usize,
}

/// A line that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pick {
    /// Order as estimated.
    pub(super) order: f64,
    /// Standard uncertainty of the order.
    pub(super) order_u: f64,
    /// Mean square of what no harmonic explains, that `order_u` rests on.
    pub(super) misfit: f64,
    /// Order at which its amplitude is taken.
    pub(super) at_order: f64,
}

impl OrderGrid {
    /// Orders up to the highest asked for and to half the points of the shortest branch.
    pub(super) fn new(branches: &[Branch], settings: &Settings) -> Option<Self> {
        let step = TAU / settings.span_rad;
        let nyquist = branches.iter().map(|b| TAU / b.spacing_rad() / 2.0).fold(f64::INFINITY, f64::min);
        let most = settings.most_order_per_rev.min(nyquist - step / 2.0);
        if !(step > 0.0 && most.is_finite()) {
            return None;
        }
        let count = (most / step * (1.0 + 1e-9)).floor();
        let first = if settings.full_turn { 1 } else { 2 };
        if count < first as f64 + 8.0 || count > 1e5 {
            return None;
        }
        Some(Self { orders: (1..=count as usize).map(|k| k as f64 * step).collect(), step, first })
    }

    /// Mean transform of several strokes, `C = 2/Σw · Σ w·y·e^(−i·order·θ)`; empty for none.
    pub(super) fn mean_transform(&self, branches: &[&Branch]) -> Vec<Complex<f64>> {
        let mut sum = vec![Complex::default(); if branches.is_empty() { 0 } else { self.orders.len() }];
        for branch in branches {
            let total: f64 = branch.weight.iter().sum();
            for ((angle, value), weight) in branch.angle_rad.iter().zip(&branch.value).zip(&branch.weight) {
                let turn = Complex::from_polar(1.0, -self.step * angle);
                let mut phasor = turn * (2.0 * value * weight / total / branches.len() as f64);
                for line in &mut sum {
                    *line += phasor;
                    phasor *= turn;
                }
            }
        }
        sum
    }
}

/// Lines above noise, largest first: transform, take all local peaks, fit them together, look again at the rest.
pub(super) fn pick(branches: &[Branch], settings: &Settings, grid: &OrderGrid) -> Option<Vec<Pick>> {
    let background = Background::of(settings);
    let mut picks: Vec<Pick> = Vec::new();
    let mut largest = 0.0_f64;
    for _ in 0..MOST_ROUNDS {
        let orders: Vec<f64> = picks.iter().map(|p| p.at_order).collect();
        let rest: Vec<Branch> =
            branches.iter().map(|b| b.without_harmonics(background, &orders)).collect::<Option<_>>()?;
        let power = power(&rest, grid);
        largest = largest.max(power.iter().skip(grid.first).copied().fold(0.0, f64::max));
        let threshold = (SEEN * floor(&power)).max((0.5 * LEAST_SHARE).powi(2) * largest);
        let mut peaks: Vec<usize> = (grid.first..power.len())
            .filter(|&k| power[k] > threshold && is_peak(&power, k, grid.first))
            .filter(|&k| orders.iter().all(|o| (o - grid.orders[k]).abs() > 0.75 * grid.step))
            .collect();
        peaks.sort_by(|&a, &b| power[b].total_cmp(&power[a]).then(a.cmp(&b)));
        peaks.truncate(MOST_PICKS - picks.len());
        if peaks.is_empty() {
            break;
        }
        let mut starts = orders;
        starts.extend(peaks.iter().map(|&k| grid.orders[k]));
        picks = refine(branches, &starts, settings, grid)?;
    }
    Some(picks)
}

/// Power of each line, mean over the directions.
fn power(branches: &[Branch], grid: &OrderGrid) -> Vec<f64> {
    let mut power = vec![0.0; grid.orders.len()];
    let sides: Vec<Vec<&Branch>> = [false, true]
        .map(|reverse| branches.iter().filter(|b| b.reverse == reverse).collect())
        .into_iter()
        .filter(|side: &Vec<&Branch>| !side.is_empty())
        .collect();
    for side in &sides {
        for (sum, line) in power.iter_mut().zip(grid.mean_transform(side)) {
            *sum += line.norm_sqr() / sides.len() as f64;
        }
    }
    power
}

/// Mean noise power of a line, from the median of all (ln 2 of the mean for the power of complex noise).
fn floor(power: &[f64]) -> f64 {
    let mut sorted = power.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2] / LN_2
}

fn is_peak(power: &[f64], k: usize, first: usize) -> bool {
    let left = if k > first { power[k - 1] } else { 0.0 };
    let right = power.get(k + 1).copied().unwrap_or(0.0);
    power[k] > left && power[k] >= right
}

/// Gauss–Newton on all orders, all strokes together: every round fits all amplitudes by least squares stroke by
/// stroke, then moves each order by what the residual says. Orders that run into a stronger one are dropped.
fn refine(branches: &[Branch], starts: &[f64], settings: &Settings, grid: &OrderGrid) -> Option<Vec<Pick>> {
    let mut orders = starts.to_vec();
    let mut sums = vec![Normal::default(); orders.len()];
    for _ in 0..if settings.full_turn { 1 } else { GAUSS_NEWTON_STEPS } {
        sums = normal(branches, &orders, settings)?;
        for ((order, sum), start) in orders.iter_mut().zip(&sums).zip(starts) {
            let step = if sum.curvature > 0.0 { sum.slope / sum.curvature } else { 0.0 };
            *order += step.clamp(-0.3 * grid.step, 0.3 * grid.step);
            *order = order.clamp(start - grid.step, start + grid.step);
        }
    }
    let mut picks: Vec<Pick> = Vec::new();
    for ((&order, sum), &start) in orders.iter().zip(&sums).zip(starts) {
        let order_u = if sum.curvature > 0.0 { (sum.misfit / sum.curvature).sqrt() } else { grid.step };
        let whole = if settings.full_turn { start.round() } else { order.round() };
        let near = settings.full_turn || (order - whole).abs() <= (3.0 * order_u).max(0.05 * grid.step);
        let at_order = if near { whole } else { order };
        if apart(&picks, at_order, grid) {
            picks.push(Pick { order, order_u, misfit: sum.misfit, at_order });
        }
    }
    Some(picks)
}

fn apart(picks: &[Pick], order: f64, grid: &OrderGrid) -> bool {
    picks.iter().all(|p| (p.at_order - order).abs() > 0.75 * grid.step)
}

/// Sums of the normal equation of one order.
#[derive(Clone, Copy, Default)]
struct Normal {
    slope: f64,
    curvature: f64,
    /// Mean square of the residual.
    misfit: f64,
}

fn normal(branches: &[Branch], orders: &[f64], settings: &Settings) -> Option<Vec<Normal>> {
    let background = Background::of(settings);
    let mut sums = vec![Normal::default(); orders.len()];
    for branch in branches {
        let waves = branch.amplitudes(background, orders)?;
        let rest = branch.without_harmonics(background, orders)?;
        let total = branch.weight.iter().sum::<f64>();
        let count = branch.weight.len() as f64;
        let centre = branch.angle_rad.iter().zip(&branch.weight).map(|(a, w)| a * w).sum::<f64>() / total;
        for ((order, wave), sum) in orders.iter().zip(&waves).zip(&mut sums) {
            for ((a, r), w) in rest.angle_rad.iter().zip(&rest.value).zip(&rest.weight) {
                let (sine, cosine) = (order * a).sin_cos();
                let derivative = -(a - centre) * (wave.re * sine + wave.im * cosine);
                let w = w * count / total;
                sum.slope += w * derivative * r;
                sum.curvature += w * derivative * derivative;
                sum.misfit += w * r * r / count / branches.len() as f64;
            }
        }
    }
    Some(sums)
}
