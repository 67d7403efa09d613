//! Resonances and anti-resonances of a response, between its lines.

use crate::analysis::frf::{Frf, Line};
use crate::analysis::modal::{Mode, Settings, modes};

/// Lines that a local fit takes to either side of a peak.
const REACH: usize = 30;
/// Largest distance of a mode from the line of its peak, in lines.
const NEAR: f64 = 1.5;
/// Modes that a local fit may have.
const MOST_MODES: usize = 4;

/// A maximum of the gain, or of its inverse.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Peak {
    /// Line of the extreme.
    pub(super) line: Line,
    /// Distance of the lines there, Hz.
    pub(super) spacing_hz: f64,
    /// The mode, or why none fits.
    pub(super) mode: Result<Mode, String>,
}

/// Maxima inside a band that stand out by a share of the largest, ascending. Lines have to ascend; `known` says
/// whether their variances are.
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

/// The mode that the lines around a frequency show; of several near it the one with the largest residue.
fn mode(lines: &[Line], at_hz: f64) -> Result<Mode, String> {
    let k = lines.partition_point(|l| l.frequency_hz < at_hz);
    let around = lines[k.saturating_sub(REACH)..(k + REACH + 1).min(lines.len())].to_vec();
    let count = around.len().max(2);
    let spacing_hz = (around[around.len() - 1].frequency_hz - around[0].frequency_hz) / (count - 1) as f64;
    let settings = Settings { most_modes: MOST_MODES, ..Settings::default() };
    let found = modes(&[around], &settings).map_err(|e| e.to_string())?;
    let near = |m: &&Mode| (m.frequency_hz - at_hz).abs() <= NEAR * spacing_hz;
    let size = |m: &Mode| m.residues.first().map_or(0.0, |r| r.norm());
    let best = found.modes.iter().filter(near).max_by(|a, b| size(a).total_cmp(&size(b)));
    let finite = |m: &&Mode| m.frequency_hz.is_finite() && m.frequency_u_hz.is_finite();
    best.filter(finite).cloned().ok_or_else(|| format!("no mode fits within {NEAR} lines of {at_hz} Hz"))
}
