//! Current and heat sink of one axis.

use analysis::estimate::Estimate;
use analysis::heating::{CycleMeans, Heating, extrapolate};
use analysis::load_cycle::{extremes, longest_above_s, rms};

use super::measure::{Found, Point, known};
use super::pictures;
use super::record::Course;
use super::{ABOVE, CURRENTS, SINK_END, SINK_TIME};
use crate::measurement::Measurement;

/// Resolution of the drive's temperature (0.1 K): standard uncertainty of a mean over a slow change.
const RESOLUTION_U_DEGC: f64 = 0.029;
/// A current that dips below its level for less than this has not left it: a tenth of a second is no pause for a winding.
const BRIDGE_S: f64 = 0.05;
/// The rows are no closer than this to a crossing of the level.
const CROSSING_U_S: f64 = 0.005;

/// Everything about one axis.
pub(super) fn measure(point: &Point<'_>, name: &str, index: usize) -> Found {
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
        let load = rms(current, &cycles, u_ratio).ok_or_else(|| "no whole cycle".to_owned())?;
        Ok(Estimate { value: load.value, u: load.u, dof: load.dof, n: load.n })
    });
    let peak = current.clone().and_then(|current| {
        let [low, high] = extremes(current).ok_or_else(|| "no samples".to_owned())?;
        let value = high.max(-low);
        Ok(known(value, u_ratio * value, current.len()))
    });
    let above = current.clone().and_then(|current| {
        let level = point.keys.continuous_a[index];
        let longest = longest_above_s(course.time_s, current, level, BRIDGE_S);
        Ok(known(longest.ok_or_else(|| "no samples".to_owned())?, CROSSING_U_S, current.len()))
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
    hottest_degc: Result<f64, String>,
    ripple_k: f64,
    fitted: Result<Heating, String>,
    n: usize,
}

fn heat_sink(point: &Point<'_>, course: &Course<'_>) -> Sink {
    let degc = course.column("heat_sink_degc");
    let hottest_degc = degc
        .clone()
        .and_then(|degc| extremes(degc).map(|[_, high]| high).ok_or_else(|| "no samples".to_owned()));
    let means = degc.map(|degc| CycleMeans::new(course.time_s, degc, &point.bounds_s));
    let ripple_k = means.as_ref().map_or(0.0, |means| means.ripple_k);
    let n = means.as_ref().map_or(0, |means| means.mean_degc.len());
    let fitted = point.whole(means).and_then(|means| {
        extrapolate(&means, RESOLUTION_U_DEGC, point.keys.longest_s).map_err(|error| error.to_string())
    });
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
        let short =
            "the record is too short, or the rise too small, to tell the time constant: run more cycles";
        let time = heating.time_constant_s.ok_or_else(|| short.to_owned())?;
        Ok(known(time.value, time.u, sink.n))
    });
    point.measurement(SINK_TIME, name, found, channels)
}
