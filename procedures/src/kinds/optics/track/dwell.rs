//! How long the fine track dwelt on its target.

use analysis::estimate::Estimate;
use analysis::tracking::longest_dwell;

use super::DWELL;
use super::frames::Frames;
use super::point::{FINE_TOPIC, Point};
use crate::measurement::Measurement;

/// The longest stretch from the first lock on, both axes at once.
pub(super) fn measure(point: &Point<'_>, frames: &Frames) -> Measurement {
    let shown = frames.shown(point.tracked_s);
    let pick = |values: &[f64]| -> Vec<f64> { shown.iter().map(|&k| values[k]).collect() };
    let time_s = pick(&frames.time_s);
    let [cross, elevation] = [pick(&frames.error_rad[0]), pick(&frames.error_rad[1])];
    let limit = point.keys.dwell_limit_rad;
    let window_s = point.keys.dwell_window_s;
    let found = longest_dwell(&time_s, [&cross, &elevation], limit, window_s, frames.gap_s());
    // Both ends are known to a frame.
    let u = frames.period_s / 6.0_f64.sqrt();
    let lasts_s = found.map_or(0.0, |dwell| dwell.lasts_s());
    let estimate = Estimate { value: lasts_s, u, dof: f64::INFINITY, n: shown.len() };
    let mut dwell = point.measurement(DWELL, &point.case.axis, Ok(estimate), FINE_TOPIC);
    dwell.flags.push("both axes at once".to_owned());
    dwell.flags.push(match found {
        Some(d) => format!("from {:.2} s after the first lock on", d.from_s - point.tracked_s[0]),
        None => format!("nowhere within {:.2} urad over {window_s} s", 1e6 * limit),
    });
    dwell.inconclusive = point.cut.clone();
    dwell
}
