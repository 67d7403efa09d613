//! How near L comes to −1: modulus margin and disk margin.

use super::curve::Curve;
use super::local::{Reading, WINNER, choose, curves};
use super::{C64, Line};

/// Points of the search around a line.
const POINTS: usize = 40;
/// Shrinkings of the golden section.
const SHRINKINGS: usize = 40;
/// Places with a distance up to this multiple of the least are looked at.
const RIVALS: f64 = 1.5;
/// Most places looked at.
const MOST_PLACES: usize = 4;

/// The least of a distance over frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Where, Hz.
    pub frequency_hz: f64,
    /// Least |1 + L|.
    pub value: f64,
    /// Standard uncertainty of `value`.
    pub u: f64,
}

/// The disk margin α of balanced skew (σ = 0): the loop stays stable for every factor (1 + δ/2)/(1 − δ/2) with complex
/// |δ| < α, α = min 2·|1 + L|/|1 − L| (Seiler, Packard & Gahinet 2020, eq. 13).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskMargin {
    /// α, and where; dimensionless, 0…∞.
    pub alpha: Nearest,
    /// Gain that may be added and taken away, alone: ±20·log₁₀((2 + α)/(2 − α)), dB; infinite from α = 2 on.
    pub gain_margin_db: f64,
    /// Standard uncertainty of `gain_margin_db`, dB; infinite with it.
    pub gain_margin_u_db: f64,
    /// Phase that may be added and taken away, alone: ±2·atan(α/2), rad.
    pub phase_margin_rad: f64,
    /// Standard uncertainty of `phase_margin_rad`, rad.
    pub phase_margin_u_rad: f64,
}

/// Least |1 + L|.
pub(super) fn modulus(lines: &[Line]) -> Nearest {
    least(lines, |l| (1.0 + l).norm(), |_| 1.0)
}

/// The disk margin.
pub(super) fn disk(lines: &[Line]) -> DiskMargin {
    // |dα/dL| = 4/|1 − L|².
    let alpha = least(lines, |l| 2.0 * (1.0 + l).norm() / (1.0 - l).norm(), |l| 4.0 / (1.0 - l).norm_sqr());
    let a = alpha.value;
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

/// Least of a real function of L with the size of its derivative by L. At the least the frequency does not count.
fn least(lines: &[Line], distance: impl Fn(C64) -> f64, slope: impl Fn(C64) -> f64) -> Nearest {
    let raw: Vec<f64> = lines.iter().map(|l| distance(l.value)).collect();
    let found = places(&raw).into_iter().filter_map(|k| {
        let range = [lines[k.saturating_sub(1)], lines[(k + 1).min(lines.len() - 1)]].map(|l| l.frequency_hz);
        let curves = curves(lines, lines[k].frequency_hz, true);
        let chosen = choose(curves.iter().map(|c| read(c, range, &distance, &slope)).collect(), WINNER)?;
        Some(Nearest { frequency_hz: chosen.ln_f.exp(), value: chosen.value, u: chosen.u })
    });
    let nearest = found.min_by(|a, b| a.value.total_cmp(&b.value));
    nearest.unwrap_or_else(|| {
        // No curve through any window: the line itself.
        let k = places(&raw)[0];
        let u = slope(lines[k].value) * (0.5 * lines[k].variance).sqrt();
        Nearest { frequency_hz: lines[k].frequency_hz, value: raw[k], u }
    })
}

/// Lines nearer than their neighbours, the nearest first. Between lines the locus may come nearer than on them, so rivals
/// some way off are looked at too.
fn places(raw: &[f64]) -> Vec<usize> {
    let beside = |k: usize| [raw[k.saturating_sub(1)], raw[(k + 1).min(raw.len() - 1)]];
    let mut places: Vec<usize> = (0..raw.len()).filter(|&k| beside(k).iter().all(|b| raw[k] <= *b)).collect();
    places.sort_by(|a, b| raw[*a].total_cmp(&raw[*b]));
    let limit = RIVALS * raw[places[0]];
    places.retain(|k| raw[*k] <= limit);
    places.truncate(MOST_PLACES);
    places
}

fn read(
    curve: &Curve,
    range: [f64; 2],
    distance: &impl Fn(C64) -> f64,
    slope: &impl Fn(C64) -> f64,
) -> Reading {
    let hz = minimum(range, |hz| distance(curve.value(hz)));
    let value = curve.value(hz);
    // Only the component towards −1 counts, and errors are circular: any component will do.
    let u = slope(value) * value.norm() * curve.errors(hz).gain.sqrt();
    let width = (range[1] / range[0]).ln();
    Reading { value: distance(value), u, ln_f: hz.ln(), u_ln_f: width, slope: curve.slope(hz) }
}

/// Where a function is least in a range: grid, then golden section.
fn minimum([from, to]: [f64; 2], of: impl Fn(f64) -> f64) -> f64 {
    let step = (to - from) / POINTS as f64;
    let values: Vec<f64> = (0..=POINTS).map(|i| of(from + step * i as f64)).collect();
    let best = (0..=POINTS).min_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
    let mut low = from + step * best.saturating_sub(1) as f64;
    let mut high = from + step * (best + 1).min(POINTS) as f64;
    let ratio = 0.5 * (5_f64.sqrt() - 1.0);
    for _ in 0..SHRINKINGS {
        let left = high - ratio * (high - low);
        let right = low + ratio * (high - low);
        if of(left) < of(right) { high = right } else { low = left }
    }
    0.5 * (low + high)
}
