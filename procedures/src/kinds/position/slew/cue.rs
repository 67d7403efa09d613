//! How slews end: overshoot and settling, repeats of the same slew averaged.

use analysis::step::{StepError, StepResponse, StepSettings, step_response};

use super::plan::{REST, SLEW};
use crate::case::Case;
use crate::kinds::position::positioned::{FLOOR_RAD, Record};
use crate::log::{SegmentSpan, Window};

/// Settled is what stays this near to its final place (POS-ACC).
pub(super) const BAND_RAD: f64 = 75e-6;
/// The final place is the mean over this last time.
const TAIL_S: f64 = 0.5;

/// The end of a slew.
pub(super) struct End {
    /// Number of its cue.
    pub(super) cue: usize,
    /// Overshoot and noise; `None` if it did not settle.
    pub(super) response: Option<StepResponse>,
    /// From the planned end of the move; a lower bound if it did not settle.
    pub(super) settling_s: f64,
    pub(super) settling_u_s: f64,
    /// Time since the planned end, and place less cue, of the first repeat: for the picture.
    pub(super) course: [Vec<f64>; 2],
}

/// The ends of all slews of a point, by cue.
pub(super) fn ends(case: &Case, window: &Window, record: &Record<'_>) -> Result<Vec<End>, String> {
    let mut all = Vec::new();
    for cue in 0.. {
        let slews = Record::spans(case, window, &format!("{SLEW} {cue}"));
        let rests = Record::spans(case, window, &format!("{REST} {cue}"));
        if slews.is_empty() && cue > 0 {
            break;
        }
        if !slews.is_empty() {
            all.push(end(case, record, cue, &slews, &rests)?);
        }
    }
    if all.is_empty() { Err("no slew was recorded".to_owned()) } else { Ok(all) }
}

fn end(
    case: &Case,
    record: &Record<'_>,
    cue: usize,
    slews: &[&SegmentSpan],
    rests: &[&SegmentSpan],
) -> Result<End, String> {
    let whole: Vec<(&SegmentSpan, f64)> =
        slews.iter().zip(rests).map(|(slew, rest)| (*slew, rest.end_s - slew.start_s)).collect();
    let shortest_s = whole.iter().map(|(_, lasts_s)| *lasts_s).fold(f64::INFINITY, f64::min);
    let (first, _) = whole.first().ok_or_else(|| format!("no rest after the slew to cue {cue}"))?;
    let stimulus = &case.segments[first.segment].stimulus;
    let planned_s = stimulus.duration_s(first.start_position_rad).ok_or("a slew without a planned end")?;
    let target = stimulus.at(first.start_position_rad, planned_s).position_rad;
    let count = record.range(first.start_s, first.start_s + shortest_s).len().saturating_sub(2);
    let grid: Vec<f64> = (0..count).map(|k| shortest_s * k as f64 / (count + 1) as f64).collect();
    let height = target - first.start_position_rad;
    let mut repeats = Vec::new();
    for (slew, _) in &whole {
        let places = record.places_rad(grid.iter().map(|t| slew.start_s + t));
        let places = places.ok_or_else(|| format!("rows are missing in the slew to cue {cue}"))?;
        repeats.push(places.iter().map(|p| p - first.start_position_rad).collect::<Vec<f64>>());
    }
    let settings = StepSettings { band_ratio: BAND_RAD / height.abs(), tail_s: TAIL_S, floor: FLOOR_RAD };
    let all: Vec<&[f64]> = repeats.iter().map(Vec::as_slice).collect();
    let after = grid.partition_point(|t| *t < planned_s - 0.2);
    let course = [
        grid[after..].iter().map(|t| t - planned_s).collect(),
        repeats[0][after..].iter().map(|v| v - height).collect(),
    ];
    match step_response(&grid, &all, height, &settings) {
        Ok(found) => Ok(End {
            cue,
            settling_s: (found.settling_s - planned_s).max(0.0),
            settling_u_s: found.settling_u_s,
            response: Some(found),
            course,
        }),
        Err(StepError::NotSettled { seconds }) => {
            Ok(End { cue, response: None, settling_s: seconds - planned_s, settling_u_s: 0.0, course })
        }
        Err(error) => Err(format!("slew to cue {cue}: {error}")),
    }
}
