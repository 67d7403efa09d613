//! The open coarse track loop and its margins: what the tracker asks for over the command with the excitation, turned
//! round (modes.md, 6: injection at the velocity command).

use analysis::frf::Line;

use super::honest::Judged;
use super::point::Point;
use super::velocity::{self, Loop};
use crate::kinds::response::excited::Channel;
use crate::measurement::PointResult;

pub(super) const NAMES: &[&str] = &["track-bandwidth", "track-gain-margin", "track-phase-margin"];
/// PI controller, and the angle that the rate becomes.
const INTEGRATORS: u32 = 2;

pub(super) fn evaluate(point: &Point<'_>, result: &mut PointResult) {
    let turned = |lines: Vec<Line>| lines.into_iter().map(|l| Line { value: -l.value, ..l }).collect();
    let judged = point.response(Channel::Commanded, Channel::Asked);
    let judged = judged.map(|j| Judged { lines: turned(j.lines), hollow: turned(j.hollow), ..j });
    let track_loop = Loop {
        names: NAMES,
        title: "Open coarse track loop",
        integrators_count: INTEGRATORS,
        estimator: "track-margins/1",
    };
    velocity::evaluate_loop(&track_loop, point, judged, result);
}
