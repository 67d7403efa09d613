//! Resonances and anti-resonances of a response, between its lines.

use std::f64::consts::TAU;

use analysis::frf::{C64, Frf, Line};
use analysis::modal::{self, Mode};
use analysis::rational::{self, Delay, RationalFit};
use nalgebra::{Matrix3, Vector3};

use crate::reason::{Reason, ResponseReason};

/// Lines that a local fit takes to either side of a peak.
const REACH: usize = 30;
/// Largest distance of a mode from the line of its peak, in lines.
const NEAR: f64 = 1.5;
/// Modes that a local fit may have.
const MOST_MODES: usize = 4;
/// Poles that a local rational function may have.
const MOST_POLES: usize = 8;

/// Largest misfit, of noise, of a rational function that describes the lines.
const MOST_MISFIT: f64 = 3.0;
/// Lines to either side of a peak that are enough where none does.
const NEXT: usize = 2;

/// A mode of the lines around a peak.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Local {
    /// Undamped frequency, Hz.
    pub(super) frequency_hz: f64,
    /// Standard uncertainty of `frequency_hz`, Hz.
    pub(super) u_hz: f64,
    /// Damping ratio and its standard uncertainty, or why there is none.
    pub(super) damping: Result<[f64; 2], Reason>,
}

/// A maximum of the gain, or of its inverse.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Peak {
    /// Line of the extreme.
    pub(super) line: Line,
    /// Distance of the lines there, Hz.
    pub(super) spacing_hz: f64,
    /// The mode, or why none fits.
    pub(super) mode: Result<Local, Reason>,
}

/// Maxima inside a band that stand out by a share of the largest, ascending, as the lines have to.
pub(super) fn maxima(lines: &[Line], band_hz: [f64; 2], least_prominence: f64) -> Vec<Peak> {
    let inside: Frf = lines
        .iter()
        .filter(|l| l.frequency_hz >= band_hz[0] && l.frequency_hz <= band_hz[1])
        .copied()
        .collect();
    let gains: Vec<f64> = inside.iter().map(|l| l.value.norm()).collect();
    let largest = gains.iter().copied().fold(0.0, f64::max);
    (1..gains.len().saturating_sub(1))
        .filter(|&k| gains[k] > gains[k - 1] && gains[k] >= gains[k + 1])
        .filter(|&k| prominence(&gains, k) >= least_prominence * largest)
        .map(|k| Peak {
            line: inside[k],
            spacing_hz: 0.5 * (inside[k + 1].frequency_hz - inside[k - 1].frequency_hz),
            mode: mode(lines, inside[k].frequency_hz),
        })
        .collect()
}

/// The response upside down: its maxima are the minima of the gain.
pub(super) fn inverse(lines: &[Line]) -> Frf {
    let of =
        |l: &Line| Line { value: l.value.inv(), variance: l.variance / l.value.norm_sqr().powi(2), ..*l };
    lines.iter().filter(|l| l.value.norm() > 0.0).map(of).collect()
}

/// Height above the higher of the lowest points on the way to something higher (or to the end) on either side.
fn prominence(gains: &[f64], peak: usize) -> f64 {
    let height = gains[peak];
    let lowest =
        |side: &mut dyn Iterator<Item = f64>| side.take_while(|g| *g <= height).fold(height, f64::min);
    let left = lowest(&mut gains[..peak].iter().rev().copied());
    let right = lowest(&mut gains[peak + 1..].iter().copied());
    height - left.max(right)
}

/// The mode that the lines around a frequency show.
fn mode(lines: &[Line], at_hz: f64) -> Result<Local, Reason> {
    let k = lines.partition_point(|l| l.frequency_hz < at_hz);
    let around = lines[k.saturating_sub(REACH)..(k + REACH + 1).min(lines.len())].to_vec();
    let steps = around.len().max(2) - 1;
    let spacing_hz = (around[around.len() - 1].frequency_hz - around[0].frequency_hz) / steps as f64;
    let near =
        |m: &Local| (m.frequency_hz - at_hz).abs() <= NEAR * spacing_hz && m.u_hz.is_finite() && m.u_hz > 0.0;
    let known = around.iter().all(|l| l.variance > 0.0);
    let found = if known { rational(&around, at_hz, &near) } else { None };
    let found = if known {
        found.or_else(|| nearest_lines(lines, k).filter(near))
    } else {
        modal(around, at_hz, spacing_hz).filter(near)
    };
    found.ok_or_else(|| ResponseReason::NoMode { lines: NEAR, at_hz }.into())
}

/// The pair of poles nearest to a frequency, of a rational function that describes the lines to their noise: one with
/// as few poles as that justifies; where it has none there, because a peak is narrower than the lines are apart, the
/// one with the smallest misfit.
fn rational(around: &Frf, at_hz: f64, near: &impl Fn(&Local) -> bool) -> Option<Local> {
    let settings =
        |poles| rational::Settings { poles, terms: vec![0, 1], delay: Delay::Known(0.0), stable: false };
    let holds = |fit: &RationalFit| fit.misfit_ratio() <= MOST_MISFIT;
    let smooth = RationalFit::select(around, &settings(2), MOST_POLES).ok().filter(holds);
    if let Some(found) = smooth.and_then(|fit| pair(&fit, at_hz)).filter(near) {
        return Some(found);
    }
    let frfs = std::slice::from_ref(around);
    let fits = (2..=MOST_POLES).filter_map(|poles| RationalFit::new(frfs, &settings(poles)).ok());
    let with_pair =
        fits.filter(holds).filter_map(|fit| Some((fit.misfit_ratio(), pair(&fit, at_hz).filter(near)?)));
    with_pair.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, found)| found)
}

/// The root of 1/G from the lines next to a peak alone, for structures that no rational function describes to the
/// noise of the lines because they distort: 1/G = c₀ + c₁·x + c₂·x², x in lines from the peak, weighted by the lines'
/// variances; the root x is a complex frequency whose imaginary part is the damping. Its uncertainty comes from the
/// residual, and is not below the line spacing over √12: what distortion does to neighbouring lines is no noise.
fn nearest_lines(lines: &[Line], peak: usize) -> Option<Local> {
    let low = peak.checked_sub(NEXT)?;
    let high = peak + NEXT;
    let middle_hz = lines.get(peak)?.frequency_hz;
    let used = lines.get(low..=high)?;
    let spacing_hz = (used[2 * NEXT].frequency_hz - used[0].frequency_hz) / (2 * NEXT) as f64;
    let mut normal = Matrix3::<C64>::zeros();
    let mut right = Vector3::<C64>::zeros();
    let row = |l: &Line| {
        let x = (l.frequency_hz - middle_hz) / spacing_hz;
        (Vector3::new(1.0, x, x * x).map(|v| C64::new(v, 0.0)), l.value.norm_sqr().powi(2) / l.variance)
    };
    for line in used {
        let (powers, weight) = row(line);
        normal += powers * powers.transpose() * C64::new(weight, 0.0);
        right += powers * (line.value.inv() * weight);
    }
    let inverse = normal.try_inverse()?;
    let c = inverse * right;
    let rest = |l: &Line| {
        let (powers, weight) = row(l);
        (powers.dot(&c) - l.value.inv()).norm_sqr() * weight
    };
    let misfit = used.iter().map(rest).sum::<f64>() / (2 * NEXT - 2) as f64;
    // The smaller root of the quadratic, without cancellation.
    let half = (c[1] * c[1] - c[0] * c[2] * 4.0).sqrt();
    let under = if (c[1] + half).norm() > (c[1] - half).norm() { c[1] + half } else { c[1] - half };
    let x = c[0] * -2.0 / under;
    let powers = Vector3::new(C64::new(1.0, 0.0), x, x * x);
    let variance = (powers.dotc(&(inverse * powers))).re / (c[1] + c[2] * x * 2.0).norm_sqr();
    let root_u_hz = (0.5 * variance * misfit.max(1.0)).sqrt() * spacing_hz;
    let root_hz = x * spacing_hz + middle_hz;
    let ratio = root_hz.im / root_hz.norm();
    let u = root_u_hz / root_hz.norm();
    Some(Local {
        frequency_hz: root_hz.norm(),
        u_hz: root_u_hz.max(spacing_hz / 12_f64.sqrt()),
        damping: resolved(ratio, u),
    })
}

fn resolved(ratio: f64, u: f64) -> Result<[f64; 2], Reason> {
    if ratio > 2.0 * u { Ok([ratio, u]) } else { Err(ResponseReason::DampingUnresolved { ratio, u }.into()) }
}

/// The pair of poles nearest to a frequency; its uncertainty grows with what the function misses.
fn pair(fit: &RationalFit, at_hz: f64) -> Option<Local> {
    let pairs = fit.poles.chunks_exact(2).enumerate().filter(|(_, p)| p[0].im > 0.0);
    let away = |p: &[C64]| (p[0].norm() / TAU - at_hz).abs();
    let (k, pair) = pairs.min_by(|(_, a), (_, b)| away(a).total_cmp(&away(b)))?;
    // Of s² + a·s + b: frequency √b, damping ratio a/(2√b).
    let a = -2.0 * pair[0].re;
    let b = pair[0].norm_sqr();
    let covariance = fit.covariance(0) * fit.misfit_ratio().max(1.0);
    let aa = covariance[(2 * k, 2 * k)];
    let ab = covariance[(2 * k, 2 * k + 1)];
    let bb = covariance[(2 * k + 1, 2 * k + 1)];
    let omega = b.sqrt();
    let ratio = 0.5 * a / omega;
    let by_a = 0.5 / omega;
    let by_b = -0.25 * a / (b * omega);
    let u = (by_a * by_a * aa + 2.0 * by_a * by_b * ab + by_b * by_b * bb).max(0.0).sqrt();
    Some(Local {
        frequency_hz: omega / TAU,
        u_hz: bb.max(0.0).sqrt() / (2.0 * omega * TAU),
        damping: resolved(ratio, u),
    })
}

/// The mode with the largest residue near a frequency, noise taken from the residual.
fn modal(around: Frf, at_hz: f64, spacing_hz: f64) -> Option<Local> {
    let settings = modal::Settings { most_modes: MOST_MODES, ..modal::Settings::default() };
    let found = modal::modes(&[around], &settings).ok()?;
    let size = |m: &Mode| m.residues.first().map_or(0.0, |r| r.norm());
    let near = found.modes.iter().filter(|m| (m.frequency_hz - at_hz).abs() <= NEAR * spacing_hz);
    let mode = near.max_by(|a, b| size(a).total_cmp(&size(b)))?;
    Some(Local {
        frequency_hz: mode.frequency_hz,
        u_hz: mode.frequency_u_hz,
        damping: mode.damping.as_ref().map(|d| [d.ratio, d.u]).map_err(|e| (*e).into()),
    })
}
