//! What the points prove for procedures that close the fine loop: sign, size and axes of mirror and tracker.

use super::keys::Keys;
use super::point::SENSED;
use crate::case::Case;
use crate::kinds::frames::{MIRROR_AXES, SIGHT_GATE, moved_axis};
use crate::measurement::{PointResult, Proof};

/// Gains within a factor of two leave a fine loop stable; how near they must be is for a requirement to say.
const SIZE: [f64; 2] = [0.5, 2.0];
/// More of the motion than this in the other axis of the camera is a camera that is turned.
const TURNED: f64 = 0.5;

/// One sentence for each fault of each axis; no fault proves it.
pub(super) fn proof(keys: &Keys, cases: &[Case], points: &[PointResult]) -> Proof {
    let all: Vec<(&Case, &PointResult)> = cases.iter().zip(points).collect();
    let of_axis = |axis: usize| {
        let mut mine = all.iter().filter(|(case, _)| moved_axis(case) == Some(axis)).peekable();
        if mine.peek().is_none() {
            return Some(format!("mirror {} is not proven: no point moved it", MIRROR_AXES[axis]));
        }
        mine.find_map(|(_, point)| fault(keys, axis, point))
    };
    Proof { gate: SIGHT_GATE.to_owned(), faults: (0..MIRROR_AXES.len()).filter_map(of_axis).collect() }
}

fn fault(keys: &Keys, axis: usize, point: &PointResult) -> Option<String> {
    let (name, expected) = (MIRROR_AXES[axis], 1.0 / keys.gains_ratio[axis]);
    let Some(&[own, other]) = point.numbers.get(SENSED).map(Vec::as_slice) else {
        let why = point.inconclusive.as_deref().unwrap_or("it was not measured");
        return Some(format!("mirror {name} is not proven: {why}"));
    };
    if own.abs() < TURNED * expected.abs() && other.abs() > TURNED * expected.abs() {
        return Some(format!(
            "camera axes: tilt of the mirror in {name} moves the image by {other:+.3} in the other axis and by {own:+.3} in \
             its own, expected 0 and {expected:+.3}; camera turned, or its axes exchanged in the rig file"
        ));
    }
    let ratio = own / expected;
    if ratio < 0.0 {
        return Some(format!(
            "optical sign of {name}: the line of sight goes the wrong way, {own:+.3} per tilt of the mirror, expected \
             {expected:+.3}; a fold in the optics, or a sign of mirror or camera"
        ));
    }
    (!(SIZE[0]..=SIZE[1]).contains(&ratio)).then(|| {
        format!(
            "optical size of {name}: the line of sight goes by {own:+.3} per tilt of the mirror, expected {expected:+.3}; \
             optics of another magnification, or a scale of mirror or camera"
        )
    })
}
