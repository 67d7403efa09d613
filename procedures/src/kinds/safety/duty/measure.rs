//! One point: current and heat sink of each axis, DC link by the drives and by clamps.

use std::ops::Range;

use analysis::estimate::Estimate;
use analysis::heating::{CycleMeans, Heating, extrapolate};
use analysis::load_cycle::{extremes, longest_above_s, rms};

use super::plan::{Keys, SEGMENTS_PER_CYCLE, names_of};
use super::{
    ABOVE, BUS_HIGH, BUS_LOW, CURRENTS, MEASURANDS, SHUNT, SINK_END, SINK_TIME, SUPPLY_PEAK, SUPPLY_RMS,
    pictures,
};
use crate::axis::Axes;
use crate::case::Case;
use crate::condition::MOVING_AXES;
use crate::log::{PointStatus, Rows, Window};
use crate::measurement::{Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind;
use crate::reason::{Reason, SafetyReason};
use crate::trace::Plot;

/// Rows of a topic while segments ran.
pub(super) struct Course<'a> {
    pub(super) time_s: &'a [f64],
    rows: &'a Rows,
    within: Range<usize>,
}

impl<'a> Course<'a> {
    /// The rows of a topic from the first segment's start to the last one's end.
    pub(super) fn of(window: &'a Window, topic: &str) -> Result<Self, Reason> {
        let rows = window.topic(topic)?;
        let [Some(first), Some(last)] = [window.segments.first(), window.segments.last()] else {
            return Err(SafetyReason::NoSegment.into());
        };
        let within = rows.range(first.start_s, last.end_s);
        if within.is_empty() {
            return Err(SafetyReason::NoRows { topic: topic.to_owned() }.into());
        }
        Ok(Self { time_s: &rows.time_s[within.clone()], rows, within })
    }

    /// A column of them; numbers only.
    pub(super) fn column(&self, channel: &str) -> Result<&'a [f64], Reason> {
        let topic = &self.rows.topic.name;
        let column = self.rows.channel(channel)?;
        let column = &column[self.within.clone()];
        match column.iter().all(|value| value.is_finite()) {
            true => Ok(column),
            false => {
                Err(SafetyReason::NotANumber { topic: topic.clone(), channel: channel.to_owned() }.into())
            }
        }
    }

    /// Rows between neighbouring instants.
    pub(super) fn between(&self, bounds_s: &[f64]) -> Vec<Range<usize>> {
        let place = |t_s: f64| self.time_s.partition_point(|&t| t < t_s);
        bounds_s.windows(2).map(|pair| place(pair[0])..place(pair[1])).collect()
    }
}

/// Instants at which cycles begin and end, of the cycles that are whole.
fn cycle_bounds_s(window: &Window) -> Vec<f64> {
    let mut bounds: Vec<f64> = Vec::new();
    for cycle in window.segments.chunks_exact(SEGMENTS_PER_CYCLE) {
        let start_s = cycle[0].start_s;
        let end_s = cycle[SEGMENTS_PER_CYCLE - 1].end_s;
        if bounds.is_empty() {
            bounds.push(start_s);
        }
        bounds.push(end_s);
    }
    if window.status != PointStatus::Completed && window.segments.len().is_multiple_of(SEGMENTS_PER_CYCLE) {
        // The last one was cut.
        bounds.pop();
    }
    if bounds.len() < 2 { Vec::new() } else { bounds }
}

const ESTIMATOR: &str = "duty/1";

/// What a part of the analysis gives.
#[derive(Default)]
pub(super) struct Found {
    pub(super) measurements: Vec<Measurement>,
    pub(super) plots: Vec<Plot>,
}

/// The point as its measurements see it.
pub(super) struct Point<'a> {
    pub(super) keys: &'a Keys,
    pub(super) case: &'a Case,
    pub(super) window: &'a Window,
    pub(super) bounds_s: Vec<f64>,
    /// How many axes move at once, asked for and reached.
    moving: Condition,
    /// Why what needs the whole point says nothing.
    pub(super) cut: Option<Reason>,
}

/// An axis that turns by less has not taken part: slews are tens of degrees.
const TAKES_PART_RAD: f64 = 0.05;

/// 1 if an axis took part, 0 if not, by its encoder; `None` if nothing tells.
fn has_moved(window: &Window, axis: &str) -> Option<u32> {
    let course = Course::of(window, &format!("/{axis}")).ok()?;
    let [low, high] = extremes(course.column("position_rad").ok()?)?;
    Some(u32::from(high - low > TAKES_PART_RAD))
}

/// Everything that a point says.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let cut = (window.status != PointStatus::Completed)
        .then(|| SafetyReason::NotCompleted { trips: window.trips.clone() }.into());
    let moved = case.moved_axes();
    let reached = moved.iter().map(|axis| has_moved(window, axis)).sum::<Option<u32>>();
    // Plans of older recordings do not have it.
    let moving = Condition {
        name: MOVING_AXES.to_owned(),
        requested: moved.len() as f64,
        achieved: reached.map(f64::from),
        kind: QuantityKind::Count,
    };
    let point = Point { keys, case, window, bounds_s: cycle_bounds_s(window), moving, cut };
    let mut result = PointResult::of(case);
    let mut take = |found: Found| {
        result.measurements.extend(found.measurements);
        result.plots.extend(found.plots);
    };
    for (index, name) in names_of(&case.axis, axes).into_iter().enumerate() {
        if let Some(name) = name.filter(|name| moved.contains(name)) {
            take(measure_axis(&point, name, index));
        }
    }
    take(measure_dc_link(&point));
    result
}

impl Point<'_> {
    /// A measurement of this point.
    pub(super) fn measurement(
        &self,
        name: &str,
        axis: &str,
        found: Result<Estimate, Reason>,
        channels: &[String],
    ) -> Measurement {
        let kind = MEASURANDS.iter().find(|m| m.name == name).map_or(QuantityKind::Count, |m| m.kind);
        let measured = match found {
            Ok(estimate) => Measurement::new(name, axis, kind, Some(estimate), ESTIMATOR),
            Err(reason) => Measurement::inconclusive(name, axis, kind, ESTIMATOR, reason),
        };
        let flags = self.cut.iter().map(|_| "up to the end of the point".to_owned()).collect();
        Measurement {
            point: Some(self.case.point.clone()),
            conditions: vec![self.moving.clone()],
            flags,
            evidence: self.evidence(channels),
            ..measured
        }
    }

    fn evidence(&self, channels: &[String]) -> Vec<Evidence> {
        let [Some(first), Some(last)] = [self.window.segments.first(), self.window.segments.last()] else {
            return Vec::new();
        };
        let channels = channels.to_vec();
        let file = String::new();
        vec![Evidence { file, channels, t0_s: first.start_s, t1_s: last.end_s }]
    }

    /// What needs the whole point, or why it says nothing.
    pub(super) fn whole<T>(&self, found: Result<T, Reason>) -> Result<T, Reason> {
        match &self.cut {
            Some(reason) => Err(reason.clone()),
            None => found,
        }
    }
}

/// An extreme: its uncertainty is known.
pub(super) fn known(value: f64, u: f64, n: usize) -> Estimate {
    Estimate { value, u, dof: f64::INFINITY, n }
}

/// Resolution of the drive's temperature (0.1 K): standard uncertainty of a mean over a slow change.
const RESOLUTION_U_DEGC: f64 = 0.029;
/// A current that dips below its level for less than this has not left it: a tenth of a second is no pause for a winding.
const BRIDGE_S: f64 = 0.05;
/// The rows are no closer than this to a crossing of the level.
const CROSSING_U_S: f64 = 0.005;

/// Everything about one axis.
fn measure_axis(point: &Point<'_>, name: &str, index: usize) -> Found {
    let [rms_name, peak_name] = CURRENTS[index];
    let topic = format!("/{name}");
    let course = match Course::of(point.window, &topic) {
        Ok(course) => course,
        Err(reason) => {
            let none = |m| point.measurement(m, name, Err(reason.clone()), &[]);
            let all = [rms_name, peak_name, ABOVE, SINK_END, SINK_TIME];
            return Found { measurements: all.into_iter().map(none).collect(), plots: Vec::new() };
        }
    };
    let mut found = currents(point, name, index, &course);
    let sink = heat_sink(point, &course);
    let channels = [format!("{topic} heat_sink_degc")];
    found.measurements.push(sink_end(point, name, &sink, &channels));
    found.measurements.push(sink_time(point, name, &sink, &channels));
    found.plots.extend(pictures::heat_sink(point, name, &course, sink.fitted.as_ref().ok()));
    found
}

fn currents(point: &Point<'_>, name: &str, index: usize, course: &Course<'_>) -> Found {
    let [rms_name, peak_name] = CURRENTS[index];
    let u_ratio = point.keys.current_u_ratio;
    let channels = [format!("/{name} current_a")];
    let current = course.column("current_a");
    let root = current.clone().and_then(|current| {
        let cycles = course.between(&point.bounds_s);
        let load = rms(current, &cycles, u_ratio).ok_or(SafetyReason::NoCycle)?;
        Ok(Estimate { value: load.value, u: load.u, dof: load.dof, n: load.n })
    });
    let peak = current.clone().and_then(|current| {
        let [low, high] = extremes(current).ok_or(SafetyReason::NoSamples)?;
        let value = high.max(-low);
        Ok(known(value, u_ratio * value, current.len()))
    });
    let above = current.clone().and_then(|current| {
        let level = point.keys.continuous_a[index];
        let longest = longest_above_s(course.time_s, current, level, BRIDGE_S);
        Ok(known(longest.ok_or(SafetyReason::NoSamples)?, CROSSING_U_S, current.len()))
    });
    let measurements = vec![
        point.measurement(rms_name, name, point.whole(root), &channels),
        point.measurement(peak_name, name, peak, &channels),
        point.measurement(ABOVE, name, above, &channels),
    ];
    Found {
        measurements,
        plots: current
            .map_or_else(|_| Vec::new(), |current| pictures::current(point, name, index, course, current)),
    }
}

/// Temperature of the heat sink, as far as it came and where it goes.
struct Sink {
    hottest_degc: Result<f64, Reason>,
    ripple_k: f64,
    fitted: Result<Heating, Reason>,
    n: usize,
}

fn heat_sink(point: &Point<'_>, course: &Course<'_>) -> Sink {
    let degc = course.column("heat_sink_degc");
    let hottest_degc = degc
        .clone()
        .and_then(|degc| extremes(degc).map(|[_, high]| high).ok_or_else(|| SafetyReason::NoSamples.into()));
    let means = degc.map(|degc| CycleMeans::new(course.time_s, degc, &point.bounds_s));
    let ripple_k = means.as_ref().map_or(0.0, |means| means.ripple_k);
    let n = means.as_ref().map_or(0, |means| means.mean_degc.len());
    let fitted = point
        .whole(means)
        .and_then(|means| extrapolate(&means, RESOLUTION_U_DEGC, point.keys.longest_s).map_err(Reason::from));
    Sink { hottest_degc, ripple_k, fitted, n }
}

fn sink_end(point: &Point<'_>, name: &str, sink: &Sink, channels: &[String]) -> Measurement {
    let sensor_u = point.keys.temperature_u_degc;
    let found = match (&sink.fitted, &sink.hottest_degc) {
        (Ok(heating), _) => {
            let end = heating.end_degc;
            Ok(known(end.value + sink.ripple_k, end.u.hypot(sensor_u), sink.n))
        }
        // A point that was cut says how hot it got: without end it would have become hotter still.
        (Err(_), Ok(hottest)) if point.cut.is_some() => Ok(known(*hottest, sensor_u, 1)),
        (Err(reason), _) => Err(reason.clone()),
    };
    let mut measurement = point.measurement(SINK_END, name, found, channels);
    if sink.fitted.as_ref().is_ok_and(|heating| heating.time_constant_s.is_none()) {
        let covered = "time constant not determined: the uncertainty covers all up to the longest";
        measurement.flags.push(covered.to_owned());
    }
    measurement
}

fn sink_time(point: &Point<'_>, name: &str, sink: &Sink, channels: &[String]) -> Measurement {
    let found = sink.fitted.clone().and_then(|heating| {
        let time = heating.time_constant_s.ok_or(SafetyReason::ShortRecord)?;
        Ok(known(time.value, time.u, sink.n))
    });
    point.measurement(SINK_TIME, name, found, channels)
}

const SUPPLY: &str = "/supply";
const VOLTAGE: &str = "bus_v";

/// Everything about supply, shunt and voltage. They belong to no axis; the point's own stands for them.
fn measure_dc_link(point: &Point<'_>) -> Found {
    let axis = &point.case.axis;
    let drive = Course::of(point.window, &format!("/{axis}"));
    let volts = drive.as_ref().map_err(Clone::clone).and_then(|drive| drive.column(VOLTAGE));
    let span = volts.clone().and_then(|volts| extremes(volts).ok_or_else(|| SafetyReason::NoSamples.into()));
    let count = volts.as_ref().map_or(0, |volts| volts.len());
    let of_bus = |end: usize| {
        let channels = [format!("/{axis} {VOLTAGE}")];
        let found = span.clone().map(|span| known(span[end], point.keys.voltage_u_v, count));
        (found, channels)
    };
    let mut all = Found::default();
    for (name, end) in [(BUS_LOW, 0), (BUS_HIGH, 1)] {
        let (found, channels) = of_bus(end);
        all.measurements.push(point.measurement(name, axis, found, &channels));
    }
    let clamps = Clamps::of(point, drive.as_ref().ok());
    let channel = |name: &str| [format!("{SUPPLY} {name}")];
    let (root, peak, power) = match &clamps {
        Ok(clamps) => (clamps.rms(point), clamps.peak(point), clamps.shunt_power(point, volts)),
        Err(reason) => (Err(reason.clone()), Err(reason.clone()), Err(reason.clone())),
    };
    all.measurements.push(point.measurement(SUPPLY_RMS, axis, point.whole(root), &channel("supply_a")));
    all.measurements.push(point.measurement(SUPPLY_PEAK, axis, peak, &channel("supply_a")));
    all.measurements.push(point.measurement(SHUNT, axis, power, &channel("shunt_a")));
    if let (Ok(drive), Ok(volts)) =
        (&drive, drive.as_ref().map_err(Clone::clone).and_then(|d| d.column(VOLTAGE)))
    {
        all.plots.extend(pictures::dc_link(
            point,
            drive.time_s,
            volts,
            clamps.ok().map(|c| [c.course.time_s, c.supply_a]),
        ));
    }
    all
}

/// Currents in the leads.
struct Clamps<'a> {
    course: Course<'a>,
    supply_a: &'a [f64],
    shunt_a: &'a [f64],
    drive_time_s: &'a [f64],
}

impl<'a> Clamps<'a> {
    fn of(point: &'a Point<'_>, drive: Option<&Course<'a>>) -> Result<Self, Reason> {
        let course = Course::of(point.window, SUPPLY)
            .map_err(|reason| SafetyReason::NoClamps { reason: Box::new(reason) })?;
        let supply_a = course.column("supply_a")?;
        let shunt_a = course.column("shunt_a")?;
        Ok(Self { course, supply_a, shunt_a, drive_time_s: drive.map_or(&[], |drive| drive.time_s) })
    }

    fn rms(&self, point: &Point<'_>) -> Result<Estimate, Reason> {
        let cycles = self.course.between(&point.bounds_s);
        let load = rms(self.supply_a, &cycles, point.keys.current_u_ratio);
        let load = load.ok_or(SafetyReason::NoCycle)?;
        Ok(Estimate { value: load.value, u: load.u, dof: load.dof, n: load.n })
    }

    fn peak(&self, point: &Point<'_>) -> Result<Estimate, Reason> {
        let [_, high] = extremes(self.supply_a).ok_or(SafetyReason::NoSamples)?;
        Ok(known(high, point.keys.current_u_ratio * high.abs(), self.supply_a.len()))
    }

    /// Largest product of the clamp's current and the voltage at that instant.
    fn shunt_power(&self, point: &Point<'_>, volts: Result<&[f64], Reason>) -> Result<Estimate, Reason> {
        let volts = volts?;
        let row = |t_s: f64| {
            let next = self.drive_time_s.partition_point(|&t| t < t_s).min(volts.len() - 1);
            volts[next]
        };
        let power = self
            .course
            .time_s
            .iter()
            .zip(self.shunt_a)
            .map(|(&t_s, &current_a)| (current_a * row(t_s), row(t_s)));
        let most = power.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|_| !volts.is_empty());
        let (value, volts_there) = most.ok_or(SafetyReason::NoSamples)?;
        let u_ratio = point.keys.current_u_ratio.hypot(point.keys.voltage_u_v / volts_there.abs().max(1.0));
        Ok(known(value, u_ratio * value.abs(), self.shunt_a.len()))
    }
}
