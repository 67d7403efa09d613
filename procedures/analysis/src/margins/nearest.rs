//! How near the open loop L comes to −1: modulus margin and disk margin.

use super::curve::Curve;
use super::local::{Reading, WINNER, choose, curves};
use super::{C64, Line};

/// Grid intervals of the search for the minimum around a line.
const POINTS: usize = 40;
/// Iterations of the golden-section search.
const SHRINKINGS: usize = 40;
/// Local minima up to this multiple of the least one are examined.
const RIVALS: f64 = 1.5;
/// Most local minima that are examined.
const MOST_PLACES: usize = 4;

/// Minimum over frequency of a distance of L from −1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Frequency of the minimum, Hz.
    pub frequency_hz: f64,
    /// The minimum, dimensionless: |1 + L| for the modulus margin, α for the disk margin.
    pub value: f64,
    /// Standard uncertainty of `value`.
    pub u: f64,
}

/// The disk margin α of balanced skew (σ = 0): the loop stays stable for every factor (1 + δ/2)/(1 − δ/2) with complex
/// |δ| < α, α = min 2·|1 + L|/|1 − L| (Seiler, Packard & Gahinet 2020, eq. 13).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskMargin {
    /// α, dimensionless, 0…∞, with its frequency.
    pub alpha: Nearest,
    /// Gain margin up and down, at unchanged phase: ±20·log₁₀((2 + α)/(2 − α)), dB; infinite from α = 2 on.
    pub gain_margin_db: f64,
    /// Standard uncertainty of `gain_margin_db`, dB; infinite where the margin is.
    pub gain_margin_u_db: f64,
    /// Phase margin in both directions, at unchanged gain: ±2·atan(α/2), rad.
    pub phase_margin_rad: f64,
    /// Standard uncertainty of `phase_margin_rad`, rad.
    pub phase_margin_u_rad: f64,
}

/// Modulus margin: the least |1 + L|, the reciprocal of the largest sensitivity.
pub(super) fn modulus(lines: &[Line]) -> Nearest {
    least(lines, |l| (1.0 + l).norm(), |_| 1.0)
}

/// The disk margin.
pub(super) fn disk(lines: &[Line]) -> DiskMargin {
    let distance = |l: C64| 2.0 * (1.0 + l).norm() / (1.0 - l).norm();
    // |dα/dL|.
    let slope = |l: C64| 4.0 / (1.0 - l).norm_sqr();
    let alpha = least(lines, distance, slope);
    let a = alpha.value;
    // From a natural logarithm to dB.
    let db = 20.0 * std::f64::consts::LOG10_E;
    let bounded = a < 2.0;
    DiskMargin {
        alpha,
        gain_margin_db: if bounded { db * ((2.0 + a) / (2.0 - a)).ln() } else { f64::INFINITY },
        gain_margin_u_db: if bounded { db * 4.0 / (4.0 - a * a) * alpha.u } else { f64::INFINITY },
        phase_margin_rad: 2.0 * (a / 2.0).atan(),
        phase_margin_u_rad: 4.0 / (4.0 + a * a) * alpha.u,
    }
}

/// Minimum over frequency of `distance`, a real function of L; `slope` is the absolute value of its derivative by L.
///
/// The uncertainty of the frequency does not enter that of the minimum: at a minimum the derivative by frequency is zero.
fn least(lines: &[Line], distance: impl Fn(C64) -> f64, slope: impl Fn(C64) -> f64) -> Nearest {
    let raw: Vec<f64> = lines.iter().map(|l| distance(l.value)).collect();
    let found = places(&raw).into_iter().filter_map(|k| {
        // From the line before to the line after.
        let range = [lines[k.saturating_sub(1)], lines[(k + 1).min(lines.len() - 1)]].map(|l| l.frequency_hz);
        let curves = curves(lines, lines[k].frequency_hz, true);
        let chosen = choose(curves.iter().map(|c| read(c, range, &distance, &slope)).collect(), WINNER)?;
        Some(Nearest { frequency_hz: chosen.ln_f.exp(), value: chosen.value, u: chosen.u })
    });
    let nearest = found.min_by(|a, b| a.value.total_cmp(&b.value));
    nearest.unwrap_or_else(|| {
        // No curve could be fitted anywhere: the nearest line itself, with the variance of one of its two components.
        let k = places(&raw)[0];
        let u = slope(lines[k].value) * (0.5 * lines[k].variance).sqrt();
        Nearest { frequency_hz: lines[k].frequency_hz, value: raw[k], u }
    })
}

/// Indices of the lines at local minima of the distance, the nearest line first.
///
/// Between lines the locus may come nearer to −1 than on them. So local minima up to [`RIVALS`] times the least are kept.
fn places(raw: &[f64]) -> Vec<usize> {
    let neighbours = |k: usize| [raw[k.saturating_sub(1)], raw[(k + 1).min(raw.len() - 1)]];
    let is_minimum = |k: &usize| neighbours(*k).iter().all(|neighbour| raw[*k] <= *neighbour);
    let mut places: Vec<usize> = (0..raw.len()).filter(is_minimum).collect();
    places.sort_by(|a, b| raw[*a].total_cmp(&raw[*b]));
    let limit = RIVALS * raw[places[0]];
    places.retain(|k| raw[*k] <= limit);
    places.truncate(MOST_PLACES);
    places
}

/// Minimum of `distance` on one fitted curve between two frequencies, Hz.
fn read(
    curve: &Curve,
    range: [f64; 2],
    distance: &impl Fn(C64) -> f64,
    slope: &impl Fn(C64) -> f64,
) -> Reading {
    let hz = minimum(range, |hz| distance(curve.value(hz)));
    let value = curve.value(hz);
    // Only the component of the error of L along the gradient of the distance counts. The error is circular, so every
    // component has the same variance: |L|² times that of ln|L|.
    let u = slope(value) * value.norm() * curve.errors(hz).gain.sqrt();
    let width = (range[1] / range[0]).ln();
    Reading { value: distance(value), u, ln_f: hz.ln(), u_ln_f: width, slope: curve.slope(hz) }
}

/// Argument at which a function is least in a range: a grid finds the interval, a golden-section search the place in it.
fn minimum([from, to]: [f64; 2], function: impl Fn(f64) -> f64) -> f64 {
    let step = (to - from) / POINTS as f64;
    let values: Vec<f64> = (0..=POINTS).map(|i| function(from + step * i as f64)).collect();
    let best = (0..=POINTS).min_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
    let mut low = from + step * best.saturating_sub(1) as f64;
    let mut high = from + step * (best + 1).min(POINTS) as f64;
    let ratio = 0.5 * (5_f64.sqrt() - 1.0);
    for _ in 0..SHRINKINGS {
        let left = high - ratio * (high - low);
        let right = low + ratio * (high - low);
        if function(left) < function(right) { high = right } else { low = left }
    }
    0.5 * (low + high)
}
