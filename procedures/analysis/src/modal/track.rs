//! Modes followed from pose to pose.

use super::super::frf::C64;
use super::assign::assign;
use super::{Modal, Mode};

/// Relative step of frequency between neighbouring poses that counts like a residue that has nothing in common.
const FREQUENCY_STEP: f64 = 0.05;
/// Cost of leaving a mode unpaired; two modes are never paired above twice that.
const ALONE: f64 = 0.75;

/// A mode at one pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Index of the pose.
    pub row: usize,
    /// Index of the mode there.
    pub mode: usize,
}

/// One mode over the poses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Track {
    /// In ascending rows, each row at most once; a row may be missing.
    pub steps: Vec<Step>,
}

/// Follows modes over poses by continuity of frequency (extrapolated along the track) and of residues.
///
/// Neighbouring poses are paired for the least total of |Δf|/(5 % of f) + 1 − Re(r·r'*)/(|r||r'|) over all modes;
/// a pair above 1.5 is two modes. A track may miss one pose. Tracks begin in order of pose and frequency.
pub fn track(rows: &[Modal]) -> Vec<Track> {
    let mut tracks: Vec<Track> = Vec::new();
    for (row, modal) in rows.iter().enumerate() {
        let open: Vec<usize> =
            (0..tracks.len()).filter(|t| tracks[*t].steps.last().is_some_and(|s| s.row + 2 >= row)).collect();
        let n = open.len();
        let m = modal.modes.len();
        // Each track and each mode may also stay alone: a square of both, with places for those.
        let mut cost = vec![vec![0.0; n + m]; n + m];
        for (i, line) in cost.iter_mut().enumerate() {
            for (k, cell) in line.iter_mut().enumerate() {
                *cell = match (i < n, k < m) {
                    (true, true) => distance(&tracks[open[i]], rows, row, &modal.modes[k]),
                    (true, false) | (false, true) => ALONE,
                    (false, false) => 0.0,
                };
            }
        }
        let columns = assign(&cost);
        let mut taken = vec![false; m];
        for (i, t) in open.iter().enumerate() {
            let mode = columns[i];
            if mode < m && cost[i][mode] < 2.0 * ALONE {
                taken[mode] = true;
                tracks[*t].steps.push(Step { row, mode });
            }
        }
        let new = (0..m).filter(|k| !taken[*k]);
        tracks.extend(new.map(|mode| Track { steps: vec![Step { row, mode }] }));
    }
    tracks
}

/// How far a mode is from where a track leads.
fn distance(track: &Track, rows: &[Modal], row: usize, mode: &Mode) -> f64 {
    let at = |step: &Step| &rows[step.row].modes[step.mode];
    let mut last = track.steps.iter().rev();
    let Some(step) = last.next() else { return f64::MAX };
    let near = at(step);
    let slope_hz = last
        .next()
        .map_or(0.0, |before| (near.frequency_hz - at(before).frequency_hz) / (step.row - before.row) as f64);
    let expected_hz = near.frequency_hz + slope_hz * (row - step.row) as f64;
    let frequency = (mode.frequency_hz - expected_hz).abs() / (FREQUENCY_STEP * near.frequency_hz);
    frequency + 1.0 - likeness(&near.residues, &mode.residues)
}

/// Cosine of the angle between two residue vectors, −1…1: sign counts, so that also of one response it tells apart
/// a mode in phase from one against it.
fn likeness(one: &[C64], other: &[C64]) -> f64 {
    let dot: f64 = one.iter().zip(other).map(|(x, y)| (x * y.conj()).re).sum();
    let size = |r: &[C64]| r.iter().map(C64::norm_sqr).sum::<f64>().sqrt();
    let product = size(one) * size(other);
    if product > 0.0 { dot / product } else { 0.0 }
}
