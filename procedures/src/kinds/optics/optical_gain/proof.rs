//! What the points prove for procedures that close the fine loop: sign, size and axes of mirror and tracker.

use super::keys::Keys;
use super::point::Sensed;
use crate::case::Case;
use crate::kinds::optics::frames::{MIRROR_AXES, SIGHT_GATE, moved_axis};
use crate::measurement::{PointResult, Proof};

/// Gains within a factor of two leave a fine loop stable; how near they must be is for a requirement to say.
const SIZE: [f64; 2] = [0.5, 2.0];
/// More of the motion than this in the other axis of the camera is a camera that is turned.
const TURNED: f64 = 0.5;

/// One sentence for each fault of each axis; no fault proves it. Where an axis was not seen at all there is no proof, and a
/// remark says why.
pub(super) fn proof(keys: &Keys, cases: &[Case], points: &[PointResult]) -> (Option<Proof>, Vec<String>) {
    let all: Vec<(&Case, &PointResult)> = cases.iter().zip(points).collect();
    let mut faults = Vec::new();
    let mut unproven = Vec::new();
    for (axis, name) in MIRROR_AXES.iter().enumerate() {
        let mine: Vec<&PointResult> =
            all.iter().filter(|(case, _)| moved_axis(case) == Some(axis)).map(|(_, point)| *point).collect();
        faults.extend(mine.iter().find_map(|point| fault(keys, axis, point)));
        let unsure =
            |point: &PointResult| point.inconclusive.is_some() || point.reduced.get::<Sensed>().is_none();
        let missing = mine.iter().find(|point| unsure(point));
        let why = missing.map(|point| point.inconclusive.as_deref().unwrap_or("it was not measured"));
        let why = if mine.is_empty() { Some("no point moved it") } else { why };
        unproven.extend(why.map(|why| format!("sign of mirror {name} is not proven: {why}")));
    }
    let is_known = !faults.is_empty() || unproven.is_empty();
    (is_known.then(|| Proof { gate: SIGHT_GATE.to_owned(), faults }), unproven)
}

fn fault(keys: &Keys, axis: usize, point: &PointResult) -> Option<String> {
    let name = MIRROR_AXES[axis];
    let expected = 1.0 / keys.gains_ratio[axis];
    let &Sensed { own, other, .. } = point.reduced.get()?;
    if own.abs() < TURNED * expected.abs() && other.abs() > TURNED * expected.abs() {
        return Some(format!(
            "camera axes: tilt of the mirror in {name} moves the image by {other:+.3} in the other axis and by {own:+.3} in \
             its own, expected 0 and {expected:+.3}; camera turned, or its axes exchanged in the rig file"
        ));
    }
    let ratio = own / expected;
    // The sign of what hardly moves is that of its noise.
    if !(SIZE[0]..=SIZE[1]).contains(&ratio.abs()) {
        return Some(format!(
            "optical size of {name}: the line of sight goes by {own:+.3} per tilt of the mirror, expected {expected:+.3}; \
             mirror without drive, optics of another magnification, or a scale of mirror or camera"
        ));
    }
    (ratio < 0.0).then(|| {
        format!(
            "optical sign of {name}: the line of sight goes the wrong way, {own:+.3} per tilt of the mirror, expected \
             {expected:+.3}; a fold in the optics, or a sign of mirror or camera"
        )
    })
}
