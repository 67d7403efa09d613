//! Pictures of a point.

use analysis::heating::Heating;

use super::measure::{Course, Point};
use super::{BUS_HIGH, CURRENTS, SINK_END};
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

/// Points of a fitted curve.
const CURVE_POINTS: u32 = 200;

fn id(point: &Point<'_>, what: &str) -> String {
    format!("{}-{what}", point.case.point.replace(' ', "-"))
}

/// Time since the first segment.
fn since(point: &Point<'_>, time_s: &[f64]) -> Vec<f64> {
    let start_s = point.window.segments.first().map_or(0.0, |s| s.start_s);
    time_s.iter().map(|t| t - start_s).collect()
}

fn line(label: &str, x: &[f64], y: &[f64]) -> Series {
    Series::thinned(label, Style::Line, [x, y], MAX_POINTS)
}

/// Current of an axis over time with its peak limit, and the RMS of each cycle with that limit below.
pub(super) fn current(
    point: &Point<'_>,
    axis: &str,
    index: usize,
    course: &Course<'_>,
    current_a: &[f64],
) -> Vec<Plot> {
    let title = format!("Current of {axis}: {}", point.case.point);
    let time = || Scale::linear("time", "s");
    let [rms, peak] = CURRENTS[index];
    let head = Plot {
        series: vec![line("current", &since(point, course.time_s), current_a)],
        limits_of: Some(peak.to_owned()),
        limits_of_magnitude: true,
        ..Plot::new(id(point, &format!("current-{axis}")), title, time(), Scale::linear("current", "A"))
    };
    let cycles = rms_of_cycles(point, course, current_a);
    if cycles.is_empty() {
        return vec![head];
    }
    let (x, y) = cycles.into_iter().unzip();
    let panel = Plot {
        series: vec![Series::new("RMS of each cycle", Style::Line, x, y)],
        limits_of: Some(rms.to_owned()),
        ..Plot::new(
            id(point, &format!("rms-{axis}")),
            "RMS of each cycle",
            time(),
            Scale::linear("RMS current", "A"),
        )
    };
    let panel = panel.panel_of(&head);
    vec![head, panel]
}

/// Root mean square of each whole cycle, at its beginning and at its end: a staircase.
fn rms_of_cycles(point: &Point<'_>, course: &Course<'_>, current_a: &[f64]) -> Vec<(f64, f64)> {
    let bounds = since(point, &point.bounds_s);
    let cycles = course.between(&point.bounds_s).into_iter().zip(bounds.windows(2));
    let stair = |(rows, ends): (std::ops::Range<usize>, &[f64])| {
        let values = current_a.get(rows).filter(|values| !values.is_empty())?;
        let mean = values.iter().map(|a| a * a).sum::<f64>() / values.len() as f64;
        Some([(ends[0], mean.sqrt()), (ends[1], mean.sqrt())])
    };
    cycles.filter_map(stair).flatten().collect()
}

/// Heat sink of an axis over time, with the fit.
pub(super) fn heat_sink(
    point: &Point<'_>,
    axis: &str,
    course: &Course<'_>,
    heating: Option<&Heating>,
) -> Option<Plot> {
    let degc = course.column("heat_sink_degc").ok()?;
    let time = since(point, course.time_s);
    let mut series = vec![line("heat sink", &time, degc)];
    let start_s = point.window.segments.first()?.start_s;
    if let Some(heating) = heating {
        let last = time.last().copied().unwrap_or(0.0);
        let x: Vec<f64> = (0..=CURVE_POINTS).map(|k| last * f64::from(k) / f64::from(CURVE_POINTS)).collect();
        let y = x.iter().map(|t| heating.at(t + start_s)).collect();
        series.push(Series::new("fit of the cycle means", Style::Fit, x, y));
    }
    let title = format!("Heat sink of {axis}: {}", point.case.point);
    let x = Scale::linear("time", "s");
    let y = Scale::linear("temperature", "degC");
    let plot = Plot::new(id(point, &format!("heat-sink-{axis}")), title, x, y);
    Some(Plot { series, limits_of: Some(SINK_END.to_owned()), ..plot })
}

/// Voltage of the DC link, and the supply's current below it.
pub(super) fn dc_link(
    point: &Point<'_>,
    time_s: &[f64],
    volts: &[f64],
    supply: Option<[&[f64]; 2]>,
) -> Vec<Plot> {
    let title = format!("DC link: {}", point.case.point);
    let time = || Scale::linear("time", "s");
    let head = Plot::new(id(point, "dc-link"), title, time(), Scale::linear("voltage", "V"));
    let series = vec![line("voltage", &since(point, time_s), volts)];
    let head = Plot { series, limits_of: Some(BUS_HIGH.to_owned()), ..head };
    let panel = supply.map(|[time_s, supply_a]| {
        let title = format!("Supply: {}", point.case.point);
        let plot = Plot::new(id(point, "supply"), title, time(), Scale::linear("supply current", "A"));
        let series = vec![line("current", &since(point, time_s), supply_a)];
        Plot { series, ..plot }.panel_of(&head)
    });
    std::iter::once(head).chain(panel).collect()
}
