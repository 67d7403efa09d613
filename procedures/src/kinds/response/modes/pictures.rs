//! Pictures: responses of a point with the fit over them, stabilisation diagram, map of frequency over elevation; and what
//! all points show.

use analysis::frf::{C64, DB_PER_NEPER, Frf, Line};
use analysis::modal::DiagramPole;

use super::Keys;
use super::assign::{Expected, Place};
use super::fit::{self, Fitted, Responses, SENSORS};
use super::point::{PointModes, VisibleMode};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::response::excited::ELEVATION;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::trace::{Mark, Plot, Scale, Series, Style};

pub(super) fn conclude(keys: &Keys, _cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
    let entries = entries(points);
    let mut plots: Vec<Plot> = plot(keys, &entries).into_iter().chain(judged(keys, points)).collect();
    // One diagram shows how the modes were told from noise; the others are alike.
    let mut diagrams = 0;
    for plot in points.iter().flat_map(|p| &p.plots) {
        let is_diagram = plot.id.starts_with(DIAGRAM);
        diagrams += usize::from(is_diagram);
        if !is_diagram || diagrams == 1 {
            plots.push(plot.clone());
        }
    }
    let remarks = [missed(keys, points), unexpected(&entries), changed(keys, &entries)];
    Conclusion { plots, remarks: remarks.concat(), ..Conclusion::collected(points) }
}

fn listed(items: &[String]) -> String {
    items.join(", ")
}

fn degrees(rad: f64) -> String {
    Q::Angle.format(rad)
}

/// Expected, not found.
fn missed(keys: &Keys, points: &[PointResult]) -> Vec<String> {
    let mut all = Vec::new();
    for expected in &keys.expected {
        let of_mode = |p: &&PointResult| {
            p.inconclusive.is_none()
                && p.measurements.iter().any(|m| m.measurand == expected.measurand() && m.value.is_none())
        };
        let names: Vec<String> = points.iter().filter(of_mode).map(|p| p.point.clone()).collect();
        if !names.is_empty() {
            all.push(format!(
                "Mode {} was expected but is not visible at {}.",
                expected.mode,
                names.join("; ")
            ));
        }
    }
    all
}

/// Found, not expected.
fn unexpected(entries: &[Entry<'_>]) -> Vec<String> {
    let strange: Vec<String> = entries
        .iter()
        .filter(|e| e.mode.expected.is_none())
        .map(|e| {
            let VisibleMode { frequency_hz, gyro, encoder, .. } = e.mode;
            let at = degrees(e.elevation_rad);
            format!("{frequency_hz:.2} Hz at {at} (participation gyro {gyro:.3}, encoder {encoder:.3})")
        })
        .collect();
    if strange.is_empty() {
        Vec::new()
    } else {
        vec![format!("Found but not expected: {}.", listed(&strange))]
    }
}

/// Modes whose shape turns over from one elevation to the next: what carries one number may be two modes.
fn changed(keys: &Keys, entries: &[Entry<'_>]) -> Vec<String> {
    let mut all = Vec::new();
    for expected in keys.expected.iter().filter(|e| !e.gyro_only) {
        let is_own = |e: &&Entry<'_>| e.mode.expected == Some(expected.mode);
        let own: Vec<&Entry<'_>> = entries.iter().filter(is_own).collect();
        let turns = own.windows(2).filter(|pair| {
            let side = |e: &Entry<'_>| (e.mode.gyro * e.mode.encoder).signum();
            side(pair[0]) * side(pair[1]) < 0.0
        });
        all.extend(turns.map(|pair| {
            let [from, to] = [pair[0], pair[1]].map(|e| degrees(e.elevation_rad));
            format!(
                "The participation of mode {} in gyro and encoder changes its relative sign between {from} \
                 and {to}: modes may have crossed there.",
                expected.mode
            )
        }));
    }
    all
}

/// Expanded uncertainty in pictures: k = 2.
const MAP_COVERAGE: f64 = 2.0;
/// Nodes of an expected curve over the elevations measured.
const NODES: usize = 46;

/// A visible mode with the elevation at which it was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<'a> {
    pub(super) elevation_rad: f64,
    pub(super) mode: &'a VisibleMode,
}

/// All visible modes, in the order of the points.
fn entries(points: &[PointResult]) -> Vec<Entry<'_>> {
    let found = points.iter().filter_map(|point| point.reduced.get::<PointModes>());
    let entries = found.flat_map(|found| {
        let elevation_rad = found.elevation_rad;
        found.visible.iter().map(move |mode| Entry { elevation_rad, mode })
    });
    entries.collect()
}

/// Frequencies found with error bars, over what was calculated or over their bands.
pub(super) fn plot(keys: &Keys, entries: &[Entry<'_>]) -> Option<Plot> {
    let degrees = |e: &Entry<'_>| e.elevation_rad.to_degrees();
    let low = entries.iter().map(degrees).fold(f64::INFINITY, f64::min).min(0.0);
    let high = entries.iter().map(degrees).fold(f64::NEG_INFINITY, f64::max).max(90.0);
    if entries.is_empty() {
        return None;
    }
    let x: Vec<f64> = (0..NODES).map(|k| low + (high - low) * k as f64 / (NODES - 1) as f64).collect();
    let mut series = Vec::new();
    for expected in &keys.expected {
        let ranges = x.iter().map(|deg| expected.range_hz(deg.to_radians()));
        let (middle, half): (Vec<f64>, Vec<f64>) =
            ranges.map(|[a, b]| (0.5 * (a + b), 0.5 * (b - a))).unzip();
        let series_of = |label: String, style| Series::new(label, style, x.clone(), middle.clone());
        series.push(match expected.place {
            Place::Curve(_) => series_of(format!("mode {} calculated", expected.mode), Style::Fit),
            Place::Band(_) => series_of(format!("mode {} expected", expected.mode), Style::Band).with_u(half),
        });
    }
    for mode in std::iter::once(None).chain(keys.expected.iter().map(|e| Some(e.mode))) {
        let own: Vec<&Entry<'_>> = entries.iter().filter(|e| e.mode.expected == mode).collect();
        if own.is_empty() {
            continue;
        }
        let (label, style) = match mode {
            None => ("not expected".to_owned(), Style::Excluded),
            Some(mode) => (format!("mode {mode}, U (k = 2)"), Style::Markers),
        };
        let at = own.iter().map(|e| degrees(e)).collect();
        let found = own.iter().map(|e| e.mode.frequency_hz).collect();
        let u = own.iter().map(|e| MAP_COVERAGE * e.mode.frequency_u_hz).collect();
        series.push(Series::new(label, style, at, found).with_u(u));
    }
    let elevation = Scale::linear("elevation", "deg");
    let hz = Scale::linear("frequency", "Hz");
    Some(Plot { series, ..Plot::new("mode-map", "Modes over elevation", elevation, hz) })
}

/// What each expected mode is judged by over elevation, with the limits of its requirement: departures from the
/// calculation, or frequencies where a band is expected.
pub(super) fn judged(keys: &Keys, points: &[PointResult]) -> Vec<Plot> {
    let departures = |expected: &Expected| {
        let measurand = expected.measurand();
        let kind = expected.kind();
        let mine = |p: &PointResult| {
            let m = p.measurements.iter().find(|m| m.measurand == measurand)?;
            let elevation_rad = m.conditions.iter().find(|c| c.name == ELEVATION)?.achieved?;
            let value = kind.to_display(m.value?);
            Some([Q::Angle.to_display(elevation_rad), value, MAP_COVERAGE * kind.to_display(m.u)])
        };
        let found: Vec<[f64; 3]> = points.iter().filter_map(mine).collect();
        let column = |c: usize| found.iter().map(|row| row[c]).collect::<Vec<f64>>();
        let y = match expected.place {
            Place::Curve(_) => Scale::linear("departure", kind.display_unit()),
            Place::Band(_) => Scale::linear("frequency", kind.display_unit()),
        };
        let series = Series::new("measured, U (k = 2)", Style::Markers, column(0), column(1));
        (!found.is_empty()).then(|| Plot {
            series: vec![series.with_u(column(2))],
            limits_of: Some(measurand.to_owned()),
            ..Plot::new(
                format!("{measurand}-over-elevation"),
                format!("Mode {}: {}", expected.mode, y.label),
                Scale::linear("elevation", Q::Angle.display_unit()),
                y,
            )
        })
    };
    keys.expected.iter().filter_map(departures).collect()
}

/// Abscissae and ordinates.
type Points = (Vec<f64>, Vec<f64>);

/// Expanded uncertainty in pictures: k = 2.
const COVERAGE: f64 = 2.0;
/// Points of a fitted curve.
const FIT_POINTS: usize = 400;

/// Id of every stabilisation diagram begins with this.
const DIAGRAM: &str = "stabilisation-";

fn frequency() -> Scale {
    Scale::logarithmic("frequency", "Hz")
}

fn slug(point: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '.') { c } else { '-' };
    point.chars().map(plain).collect()
}

/// All pictures of a point.
pub(super) fn of_point(
    point: &str,
    responses: &Responses,
    fitted: &Fitted,
    expected: &[Expected],
) -> Vec<Plot> {
    let marks = marks(fitted, expected);
    let mut plots = Vec::new();
    for sensor in 0..SENSORS.len() {
        plots.extend(bode(point, sensor, responses, fitted, &marks));
    }
    plots.push(diagram(point, fitted, &marks));
    plots
}

/// Every visible mode, with its number if it was expected.
fn marks(fitted: &Fitted, expected: &[Expected]) -> Vec<Mark> {
    let mark = |&k: &usize| {
        let hz = fitted.modal.modes[k].frequency_hz;
        let label = match fitted.pairs.iter().position(|pair| *pair == Some(k)) {
            Some(i) => format!("mode {}, {hz:.2} Hz", expected[i].mode),
            None => format!("{hz:.2} Hz, not expected"),
        };
        Mark { label, x: hz }
    };
    fitted.visible.iter().map(mark).collect()
}

/// Delay that is turned out of drawn phases, so that the structure shows: about that from torque to rate of a usual axis. It is the same
/// in all records. With the fitted delay of each, curves of two records would differ by more than their uncertainty.
const DRAWN_LATER_S: f64 = 3e-3;

fn bode(point: &str, sensor: usize, responses: &Responses, fitted: &Fitted, marks: &[Mark]) -> [Plot; 2] {
    let lines = &responses.sensors[sensor];
    let hollow = &responses.hollow[sensor];
    let name = SENSORS[sensor];
    let id = format!("{name}-{}", slug(point));
    let title = format!("Torque to rate of the {name}, {point}");
    let turned =
        |hz: f64, value: C64| value * C64::from_polar(1.0, std::f64::consts::TAU * hz * DRAWN_LATER_S);
    let phase = |hz: f64, value: C64| turned(hz, value).arg().to_degrees();
    let curve = curve(lines, fitted, sensor);
    let column = |all: &Frf, value: &dyn Fn(&Line) -> f64| -> Vec<f64> { all.iter().map(value).collect() };
    let hz = |l: &Line| l.frequency_hz;
    let fit_hz: Vec<f64> = curve.iter().map(|(hz, _)| *hz).collect();
    let series = |y: &dyn Fn(f64, C64) -> f64, u: &dyn Fn(&Line) -> f64| {
        let modelled = |l: &Line| y(l.frequency_hz, l.value);
        let mut all = vec![
            Series::new("measured, U (k = 2)", Style::Markers, column(lines, &hz), column(lines, &modelled))
                .with_u(column(lines, u)),
            Series::new("fit", Style::Fit, fit_hz.clone(), curve.iter().map(|(hz, v)| y(*hz, *v)).collect()),
        ];
        if !hollow.is_empty() {
            all.push(Series::new(
                "does not count",
                Style::Excluded,
                column(hollow, &hz),
                column(hollow, &modelled),
            ));
        }
        all
    };
    let gain = Plot {
        series: series(&|_, v| 20.0 * v.norm().log10(), &|l| COVERAGE * DB_PER_NEPER * l.relative_sd()),
        marks: marks.to_vec(),
        ..Plot::new(&id, &title, frequency(), Scale::linear("gain, dB re rad/s/(N*m)", "dB"))
    };
    let phase = Plot {
        series: series(&phase, &|l| COVERAGE * l.relative_sd().to_degrees()),
        ..Plot::new(
            format!("{id}-phase"),
            format!("{title}: phase, {:.0} ms of delay removed", 1e3 * DRAWN_LATER_S),
            frequency(),
            Scale::linear("phase", "deg"),
        )
    }
    .panel_of(&gain);
    [gain, phase]
}

/// The fit over the band of the lines.
fn curve(lines: &Frf, fitted: &Fitted, sensor: usize) -> Vec<(f64, C64)> {
    let (Some(first), Some(last)) = (lines.first(), lines.last()) else { return Vec::new() };
    let ratio = last.frequency_hz / first.frequency_hz;
    (0..FIT_POINTS)
        .map(|k| first.frequency_hz * ratio.powf(k as f64 / (FIT_POINTS - 1) as f64))
        .map(|hz| (hz, fit::response(fitted, sensor, hz)))
        .collect()
}

fn diagram(point: &str, fitted: &Fitted, marks: &[Mark]) -> Plot {
    let points = |wanted: &dyn Fn(&DiagramPole) -> bool| -> Points {
        let orders = &fitted.modal.diagram.orders;
        let all = orders.iter().flat_map(|o| o.poles.iter().map(move |p| (o.order as f64, p)));
        all.filter(|(_, p)| wanted(p)).map(|(order, p)| (p.frequency_hz, order)).unzip()
    };
    let classes: [(&str, Style, Points); 2] = [
        (
            "stable in frequency and damping",
            Style::Markers,
            points(&|p| p.stable_frequency && p.stable_damping),
        ),
        ("not stable", Style::Excluded, points(&|p| !(p.stable_frequency && p.stable_damping))),
    ];
    let series = classes.into_iter().filter(|(.., (x, _))| !x.is_empty());
    Plot {
        series: series.map(|(label, style, (x, y))| Series::new(label, style, x, y)).collect(),
        marks: marks.to_vec(),
        ..Plot::new(
            format!("{DIAGRAM}{}", slug(point)),
            format!("Stabilisation diagram, {point}"),
            Scale::linear("frequency", "Hz"),
            Scale::linear("order", ""),
        )
    }
}
