//! Cogging: torque (or current) over angle as a spectrum in orders per revolution.

use nalgebra::Complex;

use crate::uncertainty::{Component, within_and_between};

mod branch;
mod peak;
mod pick;

use branch::Background;
pub use branch::Branch;
pub use peak::{Line, Peak};
use pick::Pick;

#[cfg(test)]
mod tests;

/// Harmonics below this share of the largest are not reported.
pub const LEAST_SHARE: f64 = 0.02;
/// Lines on each side of a harmonic that tell the noise there.
const NEIGHBOURS: usize = 10;

/// What the spectrum must know of the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Length of the angle range that the branches cover, whole cogging periods or a full turn.
    pub span_rad: f64,
    /// The range closes on itself: orders are whole, unbalance is sin and cos, there is no spring.
    pub full_turn: bool,
    /// Highest order to look at.
    pub most_order_per_rev: f64,
    /// Width over which each value is a mean (0 for points): its known attenuation is undone.
    pub bin_width_rad: f64,
}

/// An amplitude with phase: `torque = amplitude·cos(order·θ + phase)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amplitude {
    /// Amplitude, in the unit of the values.
    pub amplitude: f64,
    /// Phase at angle 0.
    pub phase_rad: f64,
    /// Standard uncertainty of the amplitude (that of the phase is u / amplitude).
    pub u: f64,
    /// Degrees of freedom of u.
    pub dof: f64,
}

/// One harmonic that stands above noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Harmonic {
    /// Order as estimated, not rounded.
    pub order_per_rev: f64,
    /// Standard uncertainty of the order.
    pub order_u_per_rev: f64,
    /// Order at which the amplitudes are taken: the whole number nearest, where the estimate allows it (torque on a
    /// rigid rotor repeats every turn), else the estimate.
    pub at_order_per_rev: f64,
    /// Mean of both directions (of one, if there is only one): what reverses with friction is out.
    pub mean: Amplitude,
    /// Forward strokes alone.
    pub forward: Option<Amplitude>,
    /// Reverse strokes alone.
    pub reverse: Option<Amplitude>,
}

/// What another quantity has at the order of a harmonic.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beside {
    /// Complex amplitude `a·e^{iφ}` of `a·cos(order·θ + φ)`, mean of both directions.
    pub mean: Complex<f64>,
    /// Larger amplitude of a single direction: in the mean some of it may cancel.
    pub largest: f64,
}

/// The spectrum of both directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Orders of the plain transform, spaced by one over the span in turns.
    pub order_per_rev: Vec<f64>,
    /// Amplitude at each of these orders, mean of directions, unbalance and spring removed.
    pub amplitude: Vec<f64>,
    /// Harmonics of at least 2 % of the largest that stand above noise, by order.
    pub harmonics: Vec<Harmonic>,
    /// Middle of the angles of all strokes.
    pub middle_rad: f64,
}

impl Spectrum {
    /// Spectrum of the strokes; `None` if a branch is too short or does not vary.
    ///
    /// Each stroke is freed of unbalance and spring; lines of the transform over the whole periods that stand above
    /// noise are refined to their exact order and then fitted together by least squares, stroke by stroke, so no
    /// line leaks into another. Noise comes from the transform of what is left around each line, and from the
    /// scatter between strokes where it is larger.
    pub fn new(branches: &[Branch], settings: &Settings) -> Option<Self> {
        let grid = pick::OrderGrid::new(branches, settings)?;
        let clean: Vec<Branch> = branches
            .iter()
            .map(|b| b.without_harmonics(Background::of(settings), &[]))
            .collect::<Option<_>>()?;
        let raw = mean_of_directions(&clean, &grid);
        let picks = pick::pick(branches, settings, &grid)?;
        let orders: Vec<f64> = picks.iter().map(|p| p.at_order).collect();
        let residuals: Vec<Branch> = branches
            .iter()
            .map(|b| b.without_harmonics(Background::of(settings), &orders))
            .collect::<Option<_>>()?;
        let noise = Noise::new(&residuals, &grid);
        let fitted: Vec<Vec<Complex<f64>>> = branches
            .iter()
            .map(|b| b.amplitudes(Background::of(settings), &orders))
            .collect::<Option<_>>()?;
        let mut harmonics: Vec<Harmonic> = picks
            .iter()
            .enumerate()
            .map(|(k, pick)| harmonic(k, pick, branches, &fitted, &noise, &orders, settings))
            .collect();
        let largest = harmonics.iter().map(Harmonic::strength).fold(0.0, f64::max);
        harmonics.retain(|h| h.strength() >= LEAST_SHARE * largest);
        harmonics.sort_by(|a, b| a.at_order_per_rev.total_cmp(&b.at_order_per_rev));
        let amplitude = raw.iter().zip(&grid.orders).map(|(c, o)| c.norm() / smear(*o, settings)).collect();
        Some(Self { order_per_rev: grid.orders, amplitude, harmonics, middle_rad: middle_rad(branches) })
    }

    /// What another quantity of the same strokes has at the order of each harmonic; `None` if a branch is too short.
    pub fn beside(&self, branches: &[Branch], settings: &Settings) -> Option<Vec<Beside>> {
        let orders: Vec<f64> = self.harmonics.iter().map(|h| h.at_order_per_rev).collect();
        let mut forward = Vec::new();
        let mut reverse = Vec::new();
        for branch in branches {
            let lines = branch.amplitudes(Background::of(settings), &orders)?;
            if branch.reverse { reverse.push(lines) } else { forward.push(lines) }
        }
        let line = |(k, order): (usize, &f64)| {
            let [forward, reverse] =
                [&forward, &reverse].map(|strokes| strokes.iter().map(|s| s[k]).collect::<Vec<_>>());
            let gain = smear(*order, settings);
            let single = [mean_of_strokes(&forward, &[]), mean_of_strokes(&[], &reverse)].map(|c| c.norm());
            Beside {
                mean: mean_of_strokes(&forward, &reverse) / gain,
                largest: single[0].max(single[1]) / gain,
            }
        };
        Some(orders.iter().enumerate().map(line).collect())
    }

    /// The largest harmonic with an order in `range`; the lowest of equals.
    pub fn largest_in(&self, range: std::ops::Range<f64>) -> Option<&Harmonic> {
        let inside = self.harmonics.iter().filter(|h| range.contains(&h.at_order_per_rev));
        inside.reduce(|a, b| if b.mean.amplitude > a.mean.amplitude { b } else { a })
    }
}

impl Amplitude {
    /// The amplitude less a part of it, with the same uncertainty.
    #[must_use]
    pub fn less(&self, part: Complex<f64>) -> Self {
        let left = Complex::from_polar(self.amplitude, self.phase_rad) - part;
        Self { amplitude: left.norm(), phase_rad: left.arg(), ..*self }
    }
}

impl Harmonic {
    /// Largest amplitude of mean and single directions.
    fn strength(&self) -> f64 {
        let single = [self.forward, self.reverse].into_iter().flatten().map(|a| a.amplitude);
        single.fold(self.mean.amplitude, f64::max)
    }
}

fn middle_rad(branches: &[Branch]) -> f64 {
    let angles = || branches.iter().flat_map(|b| b.angle_rad.iter().copied());
    0.5 * (angles().fold(f64::INFINITY, f64::min) + angles().fold(f64::NEG_INFINITY, f64::max))
}

/// Noise of the transform around each order, by direction and for their mean.
struct Noise<'a> {
    grid: &'a pick::OrderGrid,
    mean: Vec<Complex<f64>>,
    forward: Vec<Complex<f64>>,
    reverse: Vec<Complex<f64>>,
}

impl<'a> Noise<'a> {
    fn new(residuals: &[Branch], grid: &'a pick::OrderGrid) -> Self {
        let spectrum = |reverse: bool| {
            let side: Vec<&Branch> = residuals.iter().filter(|b| b.reverse == reverse).collect();
            grid.mean_transform(&side)
        };
        let forward = spectrum(false);
        let reverse = spectrum(true);
        Self { grid, mean: halves(&forward, &reverse), forward, reverse }
    }

    /// Standard uncertainty of an amplitude near `order`, from the nearest lines that carry no harmonic.
    fn near(&self, lines: &[Complex<f64>], order: f64, found: &[f64]) -> Component {
        let mut free: Vec<(f64, f64)> = self
            .grid
            .orders
            .iter()
            .zip(lines)
            .filter(|(o, _)| found.iter().all(|f| (f - **o).abs() > 0.75 * self.grid.step))
            .map(|(o, c)| ((o - order).abs(), c.norm_sqr()))
            .collect();
        free.sort_by(|a, b| a.0.total_cmp(&b.0));
        free.truncate(2 * NEIGHBOURS);
        if free.is_empty() {
            return Component { u: 0.0, dof: 0.0 };
        }
        let power = free.iter().map(|(_, p)| p).sum::<f64>() / free.len() as f64;
        Component { u: (power / 2.0).sqrt(), dof: 2.0 * free.len() as f64 }
    }
}

/// Transform of the mean of all strokes of each direction, then of both directions.
fn mean_of_directions(branches: &[Branch], grid: &pick::OrderGrid) -> Vec<Complex<f64>> {
    Noise::new(branches, grid).mean
}

/// Half the sum of two directions; one alone where the other is missing.
fn halves(forward: &[Complex<f64>], reverse: &[Complex<f64>]) -> Vec<Complex<f64>> {
    match (forward.is_empty(), reverse.is_empty()) {
        (true, _) => reverse.to_vec(),
        (_, true) => forward.to_vec(),
        _ => forward.iter().zip(reverse).map(|(f, r)| (f + r) / 2.0).collect(),
    }
}

/// Attenuation of an order by the mean over a bin, sin x / x.
fn smear(order: f64, settings: &Settings) -> f64 {
    let x = order * settings.bin_width_rad / 2.0;
    if x.abs() < 1e-9 { 1.0 } else { x.sin() / x }
}

fn harmonic(
    k: usize,
    pick: &Pick,
    branches: &[Branch],
    fitted: &[Vec<Complex<f64>>],
    noise: &Noise<'_>,
    found: &[f64],
    settings: &Settings,
) -> Harmonic {
    let spectrum = |reverse: bool| -> Vec<Complex<f64>> {
        branches.iter().zip(fitted).filter(|(b, _)| b.reverse == reverse).map(|(_, f)| f[k]).collect()
    };
    let forward = spectrum(false);
    let reverse = spectrum(true);
    let pairs = halves(&forward, &reverse);
    let gain = smear(pick.at_order, settings);
    let amplitude = |repeats: &[Complex<f64>], lines: &[Complex<f64>]| {
        (!repeats.is_empty()).then(|| amplitude(repeats, noise.near(lines, pick.at_order, found), gain))
    };
    let floor = noise.near(&noise.mean, pick.at_order, found);
    // White noise σ on n values gives a line of the transform u = σ·√(2/n): this is σ as it acts near the line.
    let values: usize = branches.iter().map(|b| b.value.len()).sum();
    let acting = floor.u * floor.u * values as f64 / 2.0;
    let coloured = if pick.misfit > 0.0 { (acting / pick.misfit).sqrt() } else { 1.0 };
    Harmonic {
        order_per_rev: pick.order,
        order_u_per_rev: pick.order_u * coloured,
        at_order_per_rev: pick.at_order,
        mean: mean_amplitude(&forward, &reverse, &pairs, floor, gain),
        forward: amplitude(&forward, &noise.forward),
        reverse: amplitude(&reverse, &noise.reverse),
    }
}

/// Mean of both directions with all strokes in it; the scatter is that of the pairs.
fn mean_amplitude(
    forward: &[Complex<f64>],
    reverse: &[Complex<f64>],
    pairs: &[Complex<f64>],
    within: Component,
    gain: f64,
) -> Amplitude {
    let spread = amplitude(pairs, within, gain);
    let mean = mean_of_strokes(forward, reverse);
    Amplitude { amplitude: mean.norm() / gain, phase_rad: mean.arg(), ..spread }
}

/// Half the sum of what the strokes of each direction show on average.
fn mean_of_strokes(forward: &[Complex<f64>], reverse: &[Complex<f64>]) -> Complex<f64> {
    let average = |c: &[Complex<f64>]| -> Vec<Complex<f64>> {
        if c.is_empty() { Vec::new() } else { vec![c.iter().sum::<Complex<f64>>() / c.len() as f64] }
    };
    halves(&average(forward), &average(reverse)).first().copied().unwrap_or_default()
}

/// Mean of the repeats' complex amplitudes, its noise, and their scatter (2·(n − 1) degrees of freedom).
fn amplitude(repeats: &[Complex<f64>], within: Component, gain: f64) -> Amplitude {
    let n = repeats.len() as f64;
    let mean = repeats.iter().sum::<Complex<f64>>() / n;
    let spread = if repeats.len() > 1 {
        let power: f64 = repeats.iter().map(|c| (c - mean).norm_sqr()).sum();
        let between = Component { u: (power / (2.0 * (n - 1.0)) / n).sqrt(), dof: 2.0 * (n - 1.0) };
        within_and_between(within, between)
    } else {
        within
    };
    Amplitude { amplitude: mean.norm() / gain, phase_rad: mean.arg(), u: spread.u / gain, dof: spread.dof }
}
