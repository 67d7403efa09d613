//! Which window and which form of curve the data support around a frequency, and what the choice may cost.
//!
//! Curves of several forms are fitted to windows of growing size. Those whose residuals fit the variances stay; of these
//! the one counts that says it knows the number best, unless one that knows less contradicts it (Lepski, *Theory Probab.
//! Appl.* 35, 454, 1990). What the others differ in beyond their noise is a systematic component of the uncertainty.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::Line;
use super::curve::{Curve, Shape};
use crate::frf::unwrapped_rad;

/// Lines of a window.
const WINDOWS: [usize; 9] = [6, 8, 11, 15, 20, 27, 36, 48, 64];
/// A window reaches this far either way, as a ratio of frequencies: what a mode farther away bends is less than the noise of
/// a line, but not of a number that sixty lines have a part in.
const REACH_RATIO: f64 = 3.0;
/// Lines within that reach from which on it holds.
const ENOUGH: usize = 11;
/// Forms tried on each.
const SHAPES: [Shape; 22] = [
    Shape::LogPolynomial { terms: 2 },
    Shape::LogPolynomial { terms: 3 },
    Shape::LogPolynomial { terms: 4 },
    Shape::LogPolynomial { terms: 5 },
    Shape::Rational { above: 1, below: 1 },
    Shape::Rational { above: 2, below: 1 },
    Shape::Rational { above: 2, below: 2 },
    Shape::Rational { above: 3, below: 2 },
    Shape::Rational { above: 3, below: 3 },
    Shape::Rational { above: 4, below: 3 },
    Shape::Rational { above: 4, below: 4 },
    Shape::Physical { above: 2, below: 0 },
    Shape::Physical { above: 2, below: 1 },
    Shape::Physical { above: 3, below: 1 },
    Shape::Physical { above: 3, below: 2 },
    Shape::Physical { above: 4, below: 3 },
    Shape::Physical { above: 5, below: 5 },
    Shape::Delayed { above: 1, below: 0 },
    Shape::Delayed { above: 2, below: 0 },
    Shape::Delayed { above: 2, below: 1 },
    Shape::Delayed { above: 2, below: 2 },
    Shape::Delayed { above: 3, below: 2 },
];
/// Least probability of the residuals of a curve that is kept.
const LEAST_PROBABILITY: f64 = 0.1;
/// Part of the curves that is kept where variances do not judge them: the closest ones.
const CLOSEST_PART: usize = 8;
/// Curves of a window whose criterion is worse than that of a closer one by more have next to no support (Burnham & Anderson,
/// *Model Selection and Multimodel Inference*, 2nd ed., §2.6).
const UNSUPPORTED: f64 = 7.0;
/// Standard deviations of a difference that contradict.
const CONTRADICTION: f64 = 2.8;
/// Least part of the variance that two estimates differ by, as they never share all lines and all terms.
const OWN_PART: f64 = 0.02;
/// Factor on the variance of the chosen reading: of many curves, the one is taken that says it knows best, and part of
/// why it says so is the noise of its own variance. Most forms fit beside a 0 dB crossing, fewer where the phase turns. With
/// them 95 % intervals cover as the example `recovery_margins` prints over 20 loops and grids.
pub(super) const WINNER_OF_MANY: f64 = 1.3;
/// Factor for the best curve where fewer compete.
pub(super) const WINNER: f64 = 1.12;
/// Uncertainties up to this multiple of the chosen one take part in the systematic component.
const COMPARED: f64 = 3.0;

/// A number read from a curve, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    /// The number.
    pub(super) value: f64,
    /// Standard uncertainty of `value`.
    pub(super) u: f64,
    /// ln of the frequency it was read at.
    pub(super) ln_f: f64,
    /// Standard uncertainty of that.
    pub(super) u_ln_f: f64,
    /// dln L/dln f there.
    pub(super) slope: super::C64,
}

/// Curves around a frequency that the data support, never empty unless nothing can be fitted; with `circular` only those
/// whose errors are circular in the complex plane.
pub(super) fn curves(lines: &[Line], centre_hz: f64, circular: bool) -> Vec<Curve> {
    let lines = within_reach(lines, centre_hz);
    let exact = lines.iter().all(|l| l.variance <= 0.0);
    let after = lines.partition_point(|l| l.frequency_hz < centre_hz);
    let mut all: Vec<(f64, Curve)> = Vec::new();
    let mut last = 0;
    for size in WINDOWS {
        let size = size.min(lines.len());
        if size == last {
            break;
        }
        last = size;
        let from = after.saturating_sub(size / 2).min(lines.len() - size);
        let fitted = window(&lines[from..from + size], centre_hz, exact, circular);
        let supported = |f: &Fitted| exact || !fitted.iter().any(|better| better.outdoes(f));
        let supported: Vec<bool> = fitted.iter().map(supported).collect();
        let kept = fitted.into_iter().zip(supported).filter(|(_, supported)| *supported);
        all.extend(kept.map(|(f, _)| (f.probability, f.curve)));
    }
    let judged: Vec<Curve> =
        all.iter().filter(|(p, _)| !exact && *p > LEAST_PROBABILITY).map(|(_, c)| c.clone()).collect();
    if !judged.is_empty() {
        return judged;
    }
    // No variances to judge by, or none that any curve meets: the closest, with the spread of their own residuals.
    all.sort_by(|a, b| a.1.scale.total_cmp(&b.1.scale));
    all.truncate((all.len() / CLOSEST_PART).max(3));
    all.into_iter().map(|(_, curve)| curve).collect()
}

/// Lines not too far away, where those are enough.
fn within_reach(lines: &[Line], centre_hz: f64) -> &[Line] {
    let below = lines.partition_point(|l| l.frequency_hz * REACH_RATIO < centre_hz);
    let above = lines.partition_point(|l| l.frequency_hz <= centre_hz * REACH_RATIO);
    if above - below >= ENOUGH { &lines[below..above] } else { lines }
}

/// A curve with what speaks for it.
struct Fitted {
    curve: Curve,
    /// Of residuals as large as its.
    probability: f64,
    /// Squared residuals over their variances.
    squares: f64,
    /// Akaike's: twice those and twice the real coefficients.
    criterion: f64,
}

impl Fitted {
    /// Whether it leaves another one next to no support: by what the other leaves, not by the coefficients that it has, which
    /// cost it its certainty anyway.
    fn outdoes(&self, other: &Self) -> bool {
        self.squares < other.squares && self.criterion + UNSUPPORTED < other.criterion
    }
}

/// All forms on one window.
fn window(lines: &[Line], centre_hz: f64, exact: bool, circular: bool) -> Vec<Fitted> {
    let phase = unwrapped_rad(lines);
    let sd: Vec<f64> = lines.iter().map(|l| if exact { l.value.norm() } else { l.variance.sqrt() }).collect();
    // Harmonic mean: few degrees of freedom anywhere count.
    let freedom = lines.len() as f64 / lines.iter().map(|l| 1.0 / l.dof.max(1e-3)).sum::<f64>();
    SHAPES
        .iter()
        .filter(|shape| !circular || !shape.is_real())
        .filter(|shape| shape.coefficients() + 2.0 <= lines.len() as f64)
        .filter_map(|&shape| Curve::new(shape, centre_hz, lines, &phase, &sd).map(|c| (shape, c)))
        .map(|(shape, curve)| {
            let count = lines.len() as f64;
            let coefficients = shape.coefficients();
            let squares = curve.chi2 / expected_square(freedom);
            let (probability, curve) = judge(curve, count - coefficients, freedom, exact);
            Fitted { curve, probability, squares, criterion: 2.0 * squares + 4.0 * coefficients }
        })
        .collect()
}

/// Mean of F(2, 2d), what a squared residual over a variance of d degrees of freedom is distributed by.
fn expected_square(freedom: f64) -> f64 {
    let d = freedom.max(2.5);
    if d.is_finite() { d / (d - 1.0) } else { 1.0 }
}

/// Probability of the residuals; sets the factor on the curve's variance.
///
/// A squared residual over a variance of d degrees of freedom follows F(2, 2d): mean d/(d − 1), relative variance d/(d − 2)
/// times that of χ²; an inverse-variance mean of such weights has d/(d − 2) of the variance it claims.
fn judge(mut curve: Curve, spare: f64, freedom: f64, exact: bool) -> (f64, Curve) {
    let d = freedom.max(2.5);
    let mean = expected_square(freedom);
    let widening = if d.is_finite() { d / (d - 2.0) } else { 1.0 };
    let excess = curve.chi2 / (mean * spare);
    let dof = 2.0 * spare / widening;
    let probability = ChiSquared::new(dof).map_or(0.0, |chi2| chi2.sf(excess * dof));
    let poor = exact || probability <= LEAST_PROBABILITY;
    curve.scale = if poor { (if exact { 0.0 } else { widening }).max(excess * widening) } else { widening };
    (probability, curve)
}

/// The reading that counts, with what the choice of a curve may cost in `u` and `u_ln_f`; `winner` is one of the factors above.
pub(super) fn choose(mut readings: Vec<Reading>, winner: f64) -> Option<Reading> {
    readings.retain(|r| r.value.is_finite() && r.u.is_finite() && r.u_ln_f.is_finite() && r.ln_f.is_finite());
    readings.sort_by(|a, b| a.u.total_cmp(&b.u));
    let agreed = (0..readings.len()).find(|&k| {
        let one = &readings[k];
        readings[k + 1..].iter().all(|other| !contradicts(one, other))
    })?;
    let chosen = readings[agreed];
    let near = || readings.iter().filter(|r| r.u <= COMPARED * chosen.u && **r != chosen);
    let count = near().count().max(1) as f64;
    let value: f64 = near().map(|r| excess(r.value - chosen.value, r.u, chosen.u)).sum();
    let ln_f: f64 = near().map(|r| excess(r.ln_f - chosen.ln_f, r.u_ln_f, chosen.u_ln_f)).sum();
    Some(Reading {
        u: (winner * chosen.u.powi(2) + (value / count).max(0.0)).sqrt(),
        u_ln_f: (winner * chosen.u_ln_f.powi(2) + (ln_f / count).max(0.0)).sqrt(),
        ..chosen
    })
}

/// Square of a difference beyond what noise explains: estimates from nested data differ by the difference of their
/// variances (Hausman, *Econometrica* 46, 1251, 1978).
fn excess(difference: f64, u: f64, other: f64) -> f64 {
    difference * difference - (u * u - other * other).abs()
}

fn contradicts(one: &Reading, other: &Reading) -> bool {
    let beyond = |difference: f64, u: f64, more: f64| {
        let own = (more * more - u * u).max(OWN_PART * u * u);
        difference * difference > CONTRADICTION * CONTRADICTION * own
    };
    let comparable = other.u <= 4.0 * one.u;
    comparable
        && (beyond(one.value - other.value, one.u, other.u)
            || beyond(one.ln_f - other.ln_f, one.u_ln_f, other.u_ln_f))
}
