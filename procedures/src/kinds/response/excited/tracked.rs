//! An axis that slides because it tracks a target that sweeps.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::course::Course;
use super::plan::approach;
use crate::axis::Axes;
use crate::case::{Bounds, Case, Condition, Mode, Segment};
use crate::log::{EndedBy, SegmentSpan, Window};
use crate::target::{Target, TargetCourse};

/// From here the axis comes to its target.
pub(super) const APPROACH_RAD: f64 = 1.0 * PI / 180.0;
/// Label of the segment in which the tracker takes the target up.
pub(in crate::kinds) const ACQUIRE: &str = "acquire";
/// The tracker must have had its target for so long.
const LOCKED_S: f64 = 0.5;
/// Longest wait for that.
const ACQUIRE_S: f64 = 8.0;
/// Power-up, and the rest that ends the approach.
const POWER_UP_S: f64 = 4.0;
/// What the point's bounds leave beyond the sweep: errors of a turn-round are below half a degree.
const BOUND_RAD: f64 = 2.0 * PI / 180.0;
/// And beyond target rate and excitation.
const BOUND_RATIO: f64 = 1.6;
/// Excitations grow by this near the crossover of the velocity loop.
const RESONANCE: f64 = 1.5;
/// Rates from this share of the planned one on belong to a sweep, not to a turn-round.
const STEADY_SHARE: f64 = 0.8;
/// Mean over which a rate is told from its excitation.
const SMOOTHING_S: f64 = 0.5;
/// A turn-round that is done by hand may begin more gently than planned.
const UNSEEN_RATIO: f64 = 1.25;

/// To the middle of the sweep, then until the target is there.
pub(super) fn acquire(course: &Course) -> [Segment; 2] {
    let middle_rad = 0.5 * (course.ends_rad[0] + course.ends_rad[1]);
    let until = Some(Condition::Locked { for_s: LOCKED_S });
    // From a degree away, whatever the sweep: four seconds are enough.
    let approach = Segment { at_most_s: 4.0, ..approach(middle_rad, course) };
    [approach, Segment { until, ..Segment::hold(ACQUIRE, Mode::Track, ACQUIRE_S) }]
}

/// What holds the axis, and the target, which stands in the middle at first and then sweeps in elevation or in azimuth.
pub(super) fn behind(
    in_elevation: bool,
    course: &Course,
    peak_rad_per_s: f64,
    turn_s: f64,
) -> (Bounds, Target) {
    let [low, high] = course.ends_rad;
    let rate = course.velocity_rad_per_s;
    let bounds = Bounds {
        displacement_rad: 0.5 * (high - low) + APPROACH_RAD + BOUND_RAD,
        speed_rad_per_s: BOUND_RATIO * (rate + RESONANCE * peak_rad_per_s),
    };
    let sweep = TargetCourse::Sweep {
        azimuth_rad_per_s: if in_elevation { 0.0 } else { rate },
        elevation_rad_per_s: if in_elevation { rate } else { 0.0 },
        leg_s: course.stroke_s,
        turn_s,
    };
    (bounds, Target { course: sweep, azimuth_rad: 0.0, elevation_rad: 0.0, stands_s: 0.0 })
}

/// Puts the target of a point where its axes will stand, until they do.
pub(super) fn bring(case: &mut Case, pose: &BTreeMap<String, f64>, axes: &Axes) {
    let Ok(gimbal) = axes.gimbal() else { return };
    let [azimuth_rad, elevation_rad] = gimbal.names().map(|name| pose.get(name).copied().unwrap_or(0.0));
    let approach_s: f64 = case.segments.iter().take(1).map(|s| s.at_most_s).sum();
    if let Some(target) = &mut case.target {
        (target.azimuth_rad, target.elevation_rad) = (azimuth_rad, elevation_rad);
        target.stands_s = POWER_UP_S + approach_s;
    }
}

/// Why a point has no windows, if its target was not found.
pub(super) fn not_found(case: &Case, window: &Window) -> Option<String> {
    let timeout = |span: &&SegmentSpan| {
        let segment = case.segments.get(span.segment);
        span.ended_by == EndedBy::Timeout && segment.is_some_and(|s| s.label == ACQUIRE)
    };
    window.segments.iter().find(timeout)?;
    Some(
        "target never acquired: was it where the procedure says, and moving only once it was tracked?"
            .to_owned(),
    )
}

/// Rows at which windows of `length` begin between two rows: where the rate has been that of the sweep for long enough. The
/// target turns round when it likes; the record says when.
pub(super) fn steady(
    rate: &[f64],
    rows: std::ops::Range<usize>,
    length: usize,
    course: &Course,
) -> Vec<usize> {
    let rate_hz = length as f64 / course.window_s;
    let in_rows = |s: f64| (s * rate_hz).round() as usize;
    // Until a turn-round shows in the mean, it has lasted for so long.
    let unseen = in_rows(UNSEEN_RATIO * (1.0 - STEADY_SHARE) * course.ramp_s() + 0.5 * SMOOTHING_S);
    let settle = in_rows(course.first_s - course.ramp_s());
    let mut starts = Vec::new();
    for stretch in fast(rate, rows, STEADY_SHARE * course.velocity_rad_per_s, in_rows(SMOOTHING_S)) {
        let first = stretch.start + unseen + settle;
        let last = stretch.end.saturating_sub(unseen);
        let windows = last.saturating_sub(first) / length;
        starts.extend((0..windows).map(|k| first + k * length));
    }
    starts
}

/// Stretches in which the mean of a rate over so many rows is at least this, either way.
fn fast(rate: &[f64], rows: std::ops::Range<usize>, least: f64, over: usize) -> Vec<std::ops::Range<usize>> {
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    sums.extend(rate.iter().map(|value| {
        sum += value;
        sum
    }));
    let mean = |row: usize| {
        let from = row.saturating_sub(over / 2);
        let to = (row + over / 2 + 1).min(rate.len());
        (sums[to] - sums[from]) / (to - from).max(1) as f64
    };
    let mut stretches = Vec::new();
    let mut begun = None;
    let end = rows.end.min(rate.len());
    for row in rows.start..end {
        let is_fast = mean(row).abs() >= least;
        match begun {
            None if is_fast => begun = Some(row),
            Some(from) if !is_fast => {
                stretches.push(from..row);
                begun = None;
            }
            _ => {}
        }
    }
    stretches.extend(begun.map(|from| from..end));
    stretches
}
