//! One point.

use analysis::estimate::Estimate;

use super::frames::Frames;
use super::happenings::{self, Event};
use super::keys::{Keys, Loops};
use super::plan::{ACQUIRE, SETTLE, TRACK, loops_of};
use super::sight::Sight;
use super::{COARSE, FINE, MEASURANDS, axis_errors, dwell, loss, names_of, pictures, unacquired};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::position::positioned::conditions;
use crate::log::{EndedBy, PointStatus, SegmentSpan, Window};
use crate::measurement::{Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const ESTIMATOR: &str = "track/1";
pub(super) const COARSE_TOPIC: &str = "/coarse";
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
    /// Why what needs the whole point says nothing.
    pub(super) cut: Option<String>,
}

/// Everything that a point says.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let nothing = PointResult::of(case);
    let axes = match axes.gimbal() {
        Ok(gimbal) => gimbal.names(),
        Err(lacking) => return PointResult { inconclusive: Some(lacking.to_string()), ..nothing },
    };
    let point = match Point::new(keys, case, window, axes) {
        Ok(point) => point,
        Err(reason) => {
            let mut measurements = without(case, axes, &reason);
            if let Some(acquire) = span_of(case, window, ACQUIRE) {
                let point = Point::acquiring(keys, case, window, axes, acquire, &reason);
                unacquired::amend(&point, Some(acquire), &mut measurements);
            }
            return PointResult { measurements, inconclusive: Some(reason), ..nothing };
        }
    };
    match point.measure() {
        Ok(found) => PointResult { inconclusive: point.cut, ..found },
        Err(reason) => {
            let mut measurements = without(case, axes, &reason);
            unacquired::amend(&point, None, &mut measurements);
            PointResult { measurements, inconclusive: Some(reason), ..nothing }
        }
    }
}

/// All that the point would have yielded, and why it does not.
fn without(case: &Case, axes: [&str; 2], reason: &str) -> Vec<Measurement> {
    let measurement = |name: &'static str| {
        let both = COARSE.contains(&name) || FINE.contains(&name);
        axes.into_iter().take(if both { 2 } else { 1 }).map(move |axis| Measurement {
            point: Some(case.point.clone()),
            conditions: conditions(case),
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
fn never(case: &Case, window: &Window) -> String {
    let asked =
        "target never acquired: was it where the procedure says, and did it stand until it was tracked?";
    let Some(span) = span_of(case, window, ACQUIRE) else { return asked.to_owned() };
    let seen = |topic: &str| match Frames::read(window, topic, [span.start_s, span.end_s]) {
        Ok(frames) => {
            let shown = frames.valid.iter().filter(|valid| **valid).count();
            format!("{topic} showed it in {shown} of {} frames", frames.valid.len() + frames.missing())
        }
        Err(reason) => reason,
    };
    format!("{asked} {}; {}", seen(COARSE_TOPIC), seen(FINE_TOPIC))
}

pub(super) fn kind_of(name: &str) -> Q {
    MEASURANDS.iter().find(|m| m.name == name).map_or(Q::Count, |m| m.kind)
}

impl<'a> Point<'a> {
    fn new(keys: &'a Keys, case: &'a Case, window: &'a Window, axes: [&'a str; 2]) -> Result<Self, String> {
        let acquired = span_of(case, window, ACQUIRE).filter(|span| span.ended_by == EndedBy::Condition);
        let settle = span_of(case, window, SETTLE);
        let track = span_of(case, window, TRACK);
        let trips = || window.trips.join("; ");
        let cut = (window.status != PointStatus::Completed || track.is_none()).then(|| match trips() {
            none if none.is_empty() => "the point did not complete".to_owned(),
            trips => format!("the point was broken off ({trips})"),
        });
        let (Some(acquired), Some(last)) = (acquired, track.or(settle)) else {
            return Err(cut.filter(|_| !window.trips.is_empty()).unwrap_or_else(|| never(case, window)));
        };
        Ok(Self {
            keys,
            case,
            window,
            loops: loops_of(case),
            axes,
            tracked_s: [acquired.end_s, last.end_s],
            record_s: track.map(|span| [span.start_s, span.end_s]),
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
        reason: &str,
    ) -> Self {
        Self {
            keys,
            case,
            window,
            loops: loops_of(case),
            axes,
            tracked_s: [acquire.start_s, acquire.end_s],
            record_s: None,
            cut: Some(reason.to_owned()),
        }
    }

    fn measure(&self) -> Result<PointResult, String> {
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
            sight.as_ref().map_or_else(Vec::new, |sight| happenings::windows(self.keys, sight, axis))
        });
        let seen = Seen { sight: sight.as_ref(), windows: &windows };
        if let Some(frames) = coarse.as_ref().filter(|_| self.loops.coarse()) {
            result.measurements.extend(loss::coarse(self, frames, &windows));
            self.follow(COARSE_TOPIC, frames, &seen, &mut result);
        }
        if self.loops.fine() {
            let frames = Frames::read(self.window, FINE_TOPIC, self.tracked_s)?;
            result.measurements.push(loss::fine(self, &frames));
            result.measurements.push(dwell::measure(self, &frames));
            self.follow(FINE_TOPIC, &frames, &seen, &mut result);
        }
        Ok(result)
    }

    /// Errors and pictures of one tracker.
    fn follow(&self, topic: &'static str, frames: &Frames, seen: &Seen<'_>, result: &mut PointResult) {
        let losses = frames.losses(self.tracked_s[1]);
        let is_fine = topic == FINE_TOPIC;
        let errors = [0, 1].map(|axis| {
            let mut events = happenings::losses(&losses);
            if is_fine {
                events.extend(happenings::stroke_ends(self.window, axis, self.tracked_s));
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
        result.plots.extend(pictures::of(self, &errors, seen.sight));
    }

    /// What the target did that explains errors of an axis.
    fn of_target(&self, seen: &Seen<'_>, axis: usize) -> Vec<Event> {
        let Some(sight) = seen.sight else { return Vec::new() };
        let mut events = happenings::turns(self.keys, sight, axis);
        // A joint heaves.
        if let Some(rails) = self.keys.rails.as_ref().filter(|_| axis == 1) {
            events.extend(happenings::joints(self.keys, rails, sight));
        }
        events
    }

    /// A measurement of this point.
    pub(super) fn measurement(
        &self,
        name: &str,
        axis: &str,
        found: Result<Estimate, String>,
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
            conditions: conditions(self.case),
            evidence: vec![Evidence::new(channels, [t0_s, t1_s])],
            ..measured
        }
    }
}

/// What is known of the target's motion.
struct Seen<'a> {
    sight: Option<&'a Sight>,
    windows: &'a [Vec<[f64; 2]>; 2],
}
