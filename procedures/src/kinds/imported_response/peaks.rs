//! Resonances and anti-resonances of a response, between its lines.

use std::f64::consts::TAU;

use crate::analysis::frf::{C64, Frf, Line};
use crate::analysis::modal::{self, Mode};
use crate::analysis::rational::{self, Delay, RationalFit};

/// Lines that a local fit takes to either side of a peak.
const REACH: usize = 30;
/// Largest distance of a mode from the line of its peak, in lines.
const NEAR: f64 = 1.5;
/// Modes that a local fit may have.
const MOST_MODES: usize = 4;
/// Poles that a local rational function may have.
const MOST_POLES: usize = 8;

/// A mode of the lines around a peak.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Local {
    /// Undamped frequency, Hz.
    pub(super) frequency_hz: f64,
    /// Its standard uncertainty, Hz.
    pub(super) u_hz: f64,
    /// Damping ratio and its standard uncertainty, or why there is none.
    pub(super) damping: Result<[f64; 2], String>,
}

/// A maximum of the gain, or of its inverse.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Peak {
    /// Line of the extreme.
    pub(super) line: Line,
    /// Distance of the lines there, Hz.
    pub(super) spacing_hz: f64,
    /// The mode, or why none fits.
    pub(super) mode: Result<Local, String>,
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
fn mode(lines: &[Line], at_hz: f64) -> Result<Local, String> {
    let k = lines.partition_point(|l| l.frequency_hz < at_hz);
    let around = lines[k.saturating_sub(REACH)..(k + REACH + 1).min(lines.len())].to_vec();
    let steps = around.len().max(2) - 1;
    let spacing_hz = (around[around.len() - 1].frequency_hz - around[0].frequency_hz) / steps as f64;
    let near =
        |m: &Local| (m.frequency_hz - at_hz).abs() <= NEAR * spacing_hz && m.u_hz.is_finite() && m.u_hz > 0.0;
    let known = around.iter().all(|l| l.variance > 0.0);
    let found = if known { rational(&around, at_hz, &near) } else { None };
    let found = found.or_else(|| modal(around, at_hz, spacing_hz).filter(near));
    found.ok_or_else(|| format!("no mode fits within {NEAR} lines of {at_hz} Hz"))
}

/// The pair of poles nearest to a frequency, of a rational function with as few poles as the noise of the lines
/// justifies; where that has none, because a peak is narrower than the lines are apart, of the one with the smallest
/// misfit.
fn rational(around: &Frf, at_hz: f64, near: &impl Fn(&Local) -> bool) -> Option<Local> {
    let settings =
        |poles| rational::Settings { poles, terms: vec![0, 1], delay: Delay::Known(0.0), stable: false };
    let smooth = RationalFit::select(around, &settings(2), MOST_POLES).ok();
    if let Some(found) = smooth.and_then(|fit| pair(&fit, at_hz)).filter(near) {
        return Some(found);
    }
    let frfs = std::slice::from_ref(around);
    let fits = (2..=MOST_POLES).filter_map(|poles| RationalFit::new(frfs, &settings(poles)).ok());
    let with_pair = fits.filter_map(|fit| Some((fit.misfit_ratio(), pair(&fit, at_hz).filter(near)?)));
    with_pair.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, found)| found)
}

/// The pair of poles nearest to a frequency; its uncertainty grows with what the function misses.
fn pair(fit: &RationalFit, at_hz: f64) -> Option<Local> {
    let pairs = fit.poles.chunks_exact(2).enumerate().filter(|(_, p)| p[0].im > 0.0);
    let away = |p: &[C64]| (p[0].norm() / TAU - at_hz).abs();
    let (k, pair) = pairs.min_by(|(_, a), (_, b)| away(a).total_cmp(&away(b)))?;
    // Of s² + a·s + b: frequency √b, damping ratio a/(2√b).
    let (a, b) = (-2.0 * pair[0].re, pair[0].norm_sqr());
    let covariance = fit.covariance(0) * fit.misfit_ratio().max(1.0);
    let (aa, ab, bb) =
        (covariance[(2 * k, 2 * k)], covariance[(2 * k, 2 * k + 1)], covariance[(2 * k + 1, 2 * k + 1)]);
    let omega = b.sqrt();
    let (ratio, by_a, by_b) = (0.5 * a / omega, 0.5 / omega, -0.25 * a / (b * omega));
    let u = (by_a * by_a * aa + 2.0 * by_a * by_b * ab + by_b * by_b * bb).max(0.0).sqrt();
    Some(Local {
        frequency_hz: omega / TAU,
        u_hz: bb.max(0.0).sqrt() / (2.0 * omega * TAU),
        damping: if ratio > 2.0 * u {
            Ok([ratio, u])
        } else {
            Err(format!("damping not resolved: {ratio:.5} with a standard uncertainty of {u:.5}"))
        },
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
        damping: mode.damping.as_ref().map(|d| [d.ratio, d.u]).map_err(ToString::to_string),
    })
}
