//! One point: whether the target was acquired, how long it was tracked, whether it stayed in sight, and its errors.

use analysis::estimate::Estimate;
use analysis::tracking::longest_dwell;

use super::keys::{ACQUIRE, Keys, Loops, SETTLE, TRACK, loops_of};
use super::record::{self, Event, Frames, Sight};
use super::{
    COARSE, DWELL, FINE, FINE_LOSSES, FINE_MISSING, GAP, LOSSES, MEASURANDS, MISSING, axis_errors, names_of,
};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::position::positioned::{asked, mean_rad};
use crate::log::{EndedBy, PointStatus, SegmentSpan, Window};
use crate::measurement::{Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{OpticsReason, Reason, TargetSeen};

const ESTIMATOR: &str = "track/1";
const COARSE_TOPIC: &str = "/coarse";
pub(super) const FINE_TOPIC: &str = "/fine";

/// A point as its measurements see it.
pub(super) struct Point<'a> {
    pub(super) keys: &'a Keys,
    pub(super) case: &'a Case,
    pub(super) window: &'a Window,
    pub(super) loops: Loops,
    /// Names of azimuth and elevation, to which the readings of the trackers belong.
    pub(super) axes: [&'a str; 2],
    /// From the first lock to the end of the track.
    pub(super) tracked_s: [f64; 2],
    /// The record; `None` if the point did not come so far.
    pub(super) record_s: Option<[f64; 2]>,
    conditions: Vec<Condition>,
    /// Why what needs the whole point says nothing.
    pub(super) cut: Option<Reason>,
}

/// Everything that a point says.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let nothing = PointResult::of(case);
    let axes = match axes.gimbal() {
        Ok(gimbal) => gimbal.names(),
        Err(lacking) => return PointResult { inconclusive: Some(lacking.into()), ..nothing },
    };
    let point = match Point::new(keys, case, window, axes) {
        Ok(point) => point,
        Err(reason) => {
            let mut measurements = without(case, axes, &reason);
            if let Some(acquire) = span_of(case, window, ACQUIRE) {
                let point = Point::acquiring(keys, case, window, axes, acquire, &reason);
                amend(&point, Some(acquire), &mut measurements);
            }
            return PointResult { measurements, inconclusive: Some(reason), ..nothing };
        }
    };
    match point.measure() {
        Ok(found) => PointResult { inconclusive: point.cut, ..found },
        Err(reason) => {
            let mut measurements = without(case, axes, &reason);
            amend(&point, None, &mut measurements);
            PointResult { measurements, inconclusive: Some(reason), ..nothing }
        }
    }
}

/// All that the point would have yielded, and why it does not.
fn without(case: &Case, axes: [&str; 2], reason: &Reason) -> Vec<Measurement> {
    let measurement = |name: &'static str| {
        let both = COARSE.contains(&name) || FINE.contains(&name);
        axes.into_iter().take(if both { 2 } else { 1 }).map(move |axis| Measurement {
            point: Some(case.point.clone()),
            conditions: asked(case),
            ..Measurement::inconclusive(name, axis, kind_of(name), ESTIMATOR, reason)
        })
    };
    names_of(loops_of(case)).into_iter().flat_map(measurement).collect()
}

/// Where a segment of this label ran.
fn span_of<'w>(case: &Case, window: &'w Window, label: &str) -> Option<&'w SegmentSpan> {
    let is = |s: &&SegmentSpan| case.segments.get(s.segment).is_some_and(|own| own.label == label);
    window.segments.iter().find(is)
}

/// Says that the target was not locked on, and what the trackers saw.
fn never(case: &Case, window: &Window) -> OpticsReason {
    let span = span_of(case, window, ACQUIRE);
    let seen = |topic, span: &SegmentSpan| match Frames::read(window, topic, [span.start_s, span.end_s]) {
        Ok(frames) => TargetSeen::Frames {
            topic,
            shown: frames.valid.iter().filter(|valid| **valid).count(),
            of: frames.valid.len() + frames.missing(),
        },
        Err(reason) => TargetSeen::Nothing(Box::new(reason)),
    };
    OpticsReason::NeverAcquired {
        seen: span.map(|span| [COARSE_TOPIC, FINE_TOPIC].map(|topic| seen(topic, span))),
    }
}

fn kind_of(name: &str) -> Q {
    MEASURANDS.iter().find(|m| m.name == name).map_or(Q::Count, |m| m.kind)
}

impl<'a> Point<'a> {
    fn new(keys: &'a Keys, case: &'a Case, window: &'a Window, axes: [&'a str; 2]) -> Result<Self, Reason> {
        let acquired = span_of(case, window, ACQUIRE).filter(|span| span.ended_by == EndedBy::Condition);
        let settle = span_of(case, window, SETTLE);
        let track = span_of(case, window, TRACK);
        let cut = (window.status != PointStatus::Completed || track.is_none()).then(|| {
            let trips = window.trips.clone();
            if trips.is_empty() { OpticsReason::NotCompleted } else { OpticsReason::BrokenOff { trips } }
        });
        let cut = cut.map(Reason::from);
        let (Some(acquired), Some(last)) = (acquired, track.or(settle)) else {
            return Err(cut
                .filter(|_| !window.trips.is_empty())
                .unwrap_or_else(|| never(case, window).into()));
        };
        Ok(Self {
            keys,
            case,
            window,
            loops: loops_of(case),
            axes,
            tracked_s: [acquired.end_s, last.end_s],
            record_s: track.map(|span| [span.start_s, span.end_s]),
            conditions: conditions(case, window, axes, acquired.end_s),
            cut,
        })
    }

    /// A point that did not come beyond its acquisition.
    fn acquiring(
        keys: &'a Keys,
        case: &'a Case,
        window: &'a Window,
        axes: [&'a str; 2],
        acquire: &SegmentSpan,
        reason: &Reason,
    ) -> Self {
        Self {
            keys,
            case,
            window,
            loops: loops_of(case),
            axes,
            tracked_s: [acquire.start_s, acquire.end_s],
            record_s: None,
            conditions: conditions(case, window, axes, acquire.start_s),
            cut: Some(reason.to_owned()),
        }
    }

    fn measure(&self) -> Result<PointResult, Reason> {
        let mut result = PointResult { point: self.case.point.clone(), ..PointResult::default() };
        // A fine loop alone follows nothing that moves: the coarse camera may be covered.
        let coarse = match Frames::read(self.window, COARSE_TOPIC, self.tracked_s) {
            Err(reason) if self.loops.coarse() => return Err(reason),
            other => other.ok(),
        };
        let sight =
            coarse.as_ref().map(|frames| Sight::new(frames, self.window, self.axes, self.keys.bandwidth_hz));
        let sight = match sight {
            Some(Err(reason)) if self.loops.coarse() && self.cut.is_none() => return Err(reason),
            Some(Ok(sight)) => Some(sight),
            _ => None,
        };
        let windows = [0, 1].map(|axis| {
            sight.as_ref().map_or_else(Vec::new, |sight| record::windows(self.keys, sight, axis))
        });
        let seen = Seen { sight: sight.as_ref(), windows: &windows };
        if let Some(frames) = coarse.as_ref().filter(|_| self.loops.coarse()) {
            result.measurements.extend(coarse_losses(self, frames, &windows));
            self.follow(COARSE_TOPIC, frames, &seen, &mut result);
        }
        if self.loops.fine() {
            let frames = Frames::read(self.window, FINE_TOPIC, self.tracked_s)?;
            result.measurements.push(fine_losses(self, &frames));
            result.measurements.push(longest_dwell_of(self, &frames));
            result.measurements.push(missing_frames(self, FINE_MISSING, &frames, FINE_TOPIC));
            self.follow(FINE_TOPIC, &frames, &seen, &mut result);
        }
        Ok(result)
    }

    /// Errors and pictures of one tracker.
    fn follow(&self, topic: &'static str, frames: &Frames, seen: &Seen<'_>, result: &mut PointResult) {
        let losses = frames.losses(self.tracked_s[1]);
        let is_fine = topic == FINE_TOPIC;
        let errors = [0, 1].map(|axis| {
            let mut events = record::losses(&losses);
            if is_fine {
                events.extend(record::stroke_ends(self.window, axis, self.tracked_s));
            }
            let spoiled: Vec<[f64; 2]> =
                events.iter().filter(|_| is_fine).map(|e| [e.from_s, e.to_s]).collect();
            events.extend(self.of_target(seen, axis));
            axis_errors::Errors {
                topic,
                axis,
                name: self.axes[axis],
                frames,
                windows: &seen.windows[axis],
                spoiled,
                events,
            }
        });
        for errors in &errors {
            result.measurements.extend(axis_errors::measure(self, errors));
        }
        result.plots.extend(axis_errors::of(self, &errors, seen.sight));
    }

    /// What the target did that explains errors of an axis.
    fn of_target(&self, seen: &Seen<'_>, axis: usize) -> Vec<Event> {
        let Some(sight) = seen.sight else { return Vec::new() };
        let mut events = record::turns(self.keys, sight, axis);
        // A joint heaves.
        if let Some(rails) = self.keys.rails.as_ref().filter(|_| axis == 1) {
            events.extend(record::joints(self.keys, rails, sight));
        }
        events
    }

    /// A measurement of this point.
    pub(super) fn measurement(
        &self,
        name: &str,
        axis: &str,
        found: Result<Estimate, Reason>,
        topic: &str,
    ) -> Measurement {
        let measured = match found {
            Ok(estimate) => Measurement::new(name, axis, kind_of(name), Some(estimate), ESTIMATOR),
            Err(reason) => Measurement::inconclusive(name, axis, kind_of(name), ESTIMATOR, reason),
        };
        let [t0_s, t1_s] = self.record_s.unwrap_or(self.tracked_s);
        let channels = ["cross_elevation_rad", "elevation_rad", "lock", "counter"];
        let channels = channels.iter().map(|name| format!("{topic} {name}")).collect();
        Measurement {
            point: Some(self.case.point.clone()),
            conditions: self.conditions.clone(),
            evidence: vec![Evidence::new(channels, [t0_s, t1_s])],
            ..measured
        }
    }
}

/// The elevation of a point is that of its axis over this long before the target moves.
const START_S: f64 = 0.5;

/// The elevation at which the target starts is all that is asked of a point.
fn conditions(case: &Case, window: &Window, axes: [&str; 2], start_s: f64) -> Vec<Condition> {
    let elevation_rad = mean_rad(window, axes[1], [start_s - START_S, start_s]);
    Condition::reached(case, |_| elevation_rad)
}

/// What is known of the target's motion.
struct Seen<'a> {
    sight: Option<&'a Sight>,
    windows: &'a [Vec<[f64; 2]>; 2],
}

/// Puts what is known in the place of what is not; `acquire` where the point did not come beyond that.
fn amend(point: &Point<'_>, acquire: Option<&SegmentSpan>, measurements: &mut [Measurement]) {
    let dwell = acquire.and_then(|acquire| without_dwell(point, acquire));
    for found in [tripped_early(point), dwell].into_iter().flatten() {
        if let Some(place) = measurements.iter_mut().find(|m| m.measurand == found.measurand) {
            *place = found;
        }
    }
}

/// The dwell within the time for the acquisition, where the coarse tracker showed the target all the while and this time was
/// long enough for a dwell.
fn without_dwell(point: &Point<'_>, acquire: &SegmentSpan) -> Option<Measurement> {
    let window_s = point.keys.dwell_window_s;
    let timed_out = acquire.ended_by == EndedBy::Timeout && point.window.status == PointStatus::Completed;
    if !(point.loops.fine() && timed_out && acquire.end_s - acquire.start_s > window_s) {
        return None;
    }
    let there = [acquire.end_s - window_s, acquire.end_s];
    let coarse = Frames::read(point.window, COARSE_TOPIC, there).ok()?;
    if !coarse.losses(acquire.end_s).is_empty() {
        return None;
    }
    let fine = Frames::read(point.window, FINE_TOPIC, point.tracked_s).ok()?;
    let mut found = longest_dwell_of(point, &fine);
    found.inconclusive = None;
    found.flags.push("the fine loop never locked, although the coarse tracker showed the target".to_owned());
    Some(found)
}

/// The longest stretch from the first lock on, both axes at once.
pub(super) fn longest_dwell_of(point: &Point<'_>, frames: &Frames) -> Measurement {
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
        None => format!("never within {:.2} urad over {window_s} s", 1e6 * limit),
    });
    dwell.inconclusive = point.cut.as_ref().map(Reason::to_string);
    dwell
}

/// Name of the interlock that ends a point whose target was lost.
const INTERLOCK: &str = "tracker lost";

/// Losses of the coarse tracker from the first lock on. None in a record without a jump or reversal is no verdict.
pub(super) fn coarse_losses(
    point: &Point<'_>,
    frames: &Frames,
    windows: &[Vec<[f64; 2]>; 2],
) -> [Measurement; 3] {
    let stretches = frames.losses(point.tracked_s[1]);
    let tripped = tripped(point);
    let count = stretches.len().max(usize::from(tripped));
    let mut losses = counted(point, LOSSES, count, frames.time_s.len(), COARSE_TOPIC);
    losses.flags.extend(stretches.iter().map(|[from_s, to_s]| {
        let since_s = from_s - point.tracked_s[0];
        format!("lost for {:.2} s, {since_s:.2} s after the first lock", to_s - from_s)
    }));
    if tripped {
        losses.flags.push(format!("ended by interlock `{INTERLOCK}`"));
    }
    let challenges: usize = windows.iter().map(Vec::len).sum();
    losses.flags.push(format!("{challenges} jumps or reversals of the target"));
    if count == 0 {
        let untested = (challenges == 0).then(|| OpticsReason::NotChallenged.to_string());
        losses.inconclusive = point.cut.as_ref().map(Reason::to_string).or(untested);
    }
    let u = frames.period_s / 6.0_f64.sqrt();
    let estimate = Estimate { value: frames.longest_gap_s(), u, dof: f64::INFINITY, n: frames.time_s.len() };
    let mut gap = point.measurement(GAP, &point.case.axis, Ok(estimate), COARSE_TOPIC);
    gap.flags.push(format!("{} frames never arrived", frames.missing()));
    [losses, gap, missing_frames(point, MISSING, frames, COARSE_TOPIC)]
}

/// Share of the frames that never came; with the period, where they are missing in turn.
fn missing_frames(point: &Point<'_>, name: &str, frames: &Frames, topic: &str) -> Measurement {
    let value = frames.missing() as f64 / frames.made() as f64;
    let estimate = Estimate { value, u: 0.0, dof: f64::INFINITY, n: frames.made() };
    let mut missing = point.measurement(name, &point.case.axis, Ok(estimate), topic);
    missing.flags.push(format!("{} of {} frames", frames.missing(), frames.made()));
    missing.flags.extend(frames.missing_every().map(|frames| format!("one frame in {frames}, regularly")));
    missing
}

/// The loss that ended a point which was too short for anything else.
fn tripped_early(point: &Point<'_>) -> Option<Measurement> {
    let lost = point.loops.coarse() && tripped(point);
    lost.then(|| {
        let mut losses = counted(point, LOSSES, 1, 1, COARSE_TOPIC);
        losses.flags.push(format!("immediately after it was seen; ended by interlock `{INTERLOCK}`"));
        losses
    })
}

fn tripped(point: &Point<'_>) -> bool {
    point.window.trips.iter().any(|trip| trip.starts_with(INTERLOCK))
}

/// Losses of the fine tracker: beyond the mirror's stroke its field is left, and that is no loss of the target.
pub(super) fn fine_losses(point: &Point<'_>, frames: &Frames) -> Measurement {
    let count = frames.losses(point.tracked_s[1]).len();
    counted(point, FINE_LOSSES, count, frames.time_s.len(), FINE_TOPIC)
}

fn counted(point: &Point<'_>, name: &str, count: usize, n: usize, topic: &str) -> Measurement {
    let estimate = Estimate { value: count as f64, u: 0.0, dof: f64::INFINITY, n };
    point.measurement(name, &point.case.axis, Ok(estimate), topic)
}
