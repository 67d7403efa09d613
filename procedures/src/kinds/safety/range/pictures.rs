//! Pictures: the travel with what was asked of the axis, and how it came to its limits.

use super::keys::Stage;
use super::plan::{self, BESIDE};
use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Condition, Fence};
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::Stimulus;
use crate::trace::{LimitLine, Mark, Note, Plot, Scale, Series, Style};

/// Points of one approach among several.
const APPROACH_POINTS: usize = 400;
/// What the picture of the approaches shows around the limit and the rest.
const SHOWN_DEG: [f64; 2] = [-3.0, 1.0];
const SHOWN_S: [f64; 2] = [-2.5, 1.0];
/// Less than this is read in µrad.
const SMALL_DEG: f64 = 0.02;

/// A limit that an axis was ordered past.
struct Approach<'a> {
    name: String,
    start_deg: f64,
    limit_deg: f64,
    target_deg: f64,
    ahead: f64,
    time_s: &'a [f64],
    angle_deg: &'a [f64],
}

/// All pictures of a procedure.
pub(super) fn pictures(cases: &[Case], points: &[PointResult], axes: &Axes) -> Vec<Plot> {
    let pairs = || cases.iter().zip(points);
    let mut plots: Vec<Plot> =
        pairs().filter_map(|(case, point)| course(case, point, axes.get(&case.axis)?)).collect();
    let approaches: Vec<Approach<'_>> =
        pairs().filter_map(|(case, point)| approach(case, point, axes)).collect();
    let limits = cases.first().and_then(|case| axes.get(&case.axis));
    if let (Some(limits), false) = (limits, approaches.is_empty()) {
        plots.extend([map(&approaches, limits), past(&approaches), overlay(&approaches)]);
    }
    plots
}

/// Angle over time of moves inside of all limits, with the limits that belong to them.
fn course(case: &Case, point: &PointResult, limits: &AxisLimits) -> Option<Plot> {
    let (ends, label) = match Stage::of(case)? {
        Stage::Ends => (limits.travel_rad, "end of travel"),
        Stage::FullSpeed => (limits.soft_limits_rad, "soft limit"),
        _ => return None,
    };
    let empty = || Series::new(case.axis.clone(), Style::Line, Vec::new(), Vec::new());
    let series = vec![point.reduced.get::<Series>().cloned().unwrap_or_else(empty)];
    let line = |end: f64| LimitLine {
        label: format!("{label} {}", Q::Angle.format(end)),
        y: Q::Angle.to_display(end),
        x: None,
    };
    let title = format!("Angle: {}", case.point);
    let plot = Plot::new(id(&case.point), title, Scale::linear("time", "s"), Scale::linear("angle", "deg"));
    Some(Plot { series, limits: ends.map(line).into(), ..plot })
}

fn id(point: &str) -> String {
    point.replace([' ', ',', '=', '/'], "-")
}

fn approach<'a>(case: &Case, point: &'a PointResult, axes: &Axes) -> Option<Approach<'a>> {
    let stage = Stage::of(case)?;
    let ahead = case.requested("velocity")?.signum();
    let fence = case.fence.as_ref()?;
    let side = |limits: &Fence, drive: bool| {
        let all = if drive { &limits.drive_rad } else { &limits.bench_rad };
        all.get(&case.axis).map(|[low, high]| if ahead > 0.0 { *high } else { *low })
    };
    let own = axes.gimbal_index(&case.axis).unwrap_or(0);
    let limit_rad = match stage {
        Stage::SoftBench => side(fence, false)?,
        Stage::SoftDrive => side(fence, true)?,
        Stage::Zone if !case.point.ends_with(BESIDE) => fence.zones.first()?.lower_rad[own],
        _ => return None,
    };
    let start_rad = *case.start_pose_rad.get(&case.axis)?;
    let segment = case.segments.iter().find(|s| s.label == plan::PAST)?;
    let target_rad = match (&segment.stimulus, &segment.until) {
        (Stimulus::Move { target_rad, .. }, _) => *target_rad,
        (_, Some(Condition::Displacement { above_rad })) => start_rad + ahead * above_rad,
        _ => return None,
    };
    let course = point.reduced.get::<Series>()?;
    let deg = |rad: f64| Q::Angle.to_display(rad);
    (!course.y.is_empty()).then(|| Approach {
        name: case.point.replace("velocity=", "").replace(" deg/s", "\u{a0}°/s").replace(" -", " −"),
        start_deg: deg(start_rad),
        limit_deg: deg(limit_rad),
        target_deg: deg(target_rad),
        ahead,
        time_s: &course.x,
        angle_deg: &course.y,
    })
}

impl Approach<'_> {
    /// How far past the limit it was, in the direction of the approach.
    fn past_deg(&self, angle_deg: f64) -> f64 {
        self.ahead * (angle_deg - self.limit_deg)
    }

    /// Index of the farthest angle: where it was stopped.
    fn farthest(&self) -> usize {
        let angle = |i: usize| self.ahead * self.angle_deg[i];
        (0..self.angle_deg.len()).fold(0, |best, i| if angle(i) > angle(best) { i } else { best })
    }
}

fn names(all: &[Approach<'_>]) -> Vec<String> {
    all.iter().map(|a| a.name.clone()).collect()
}

/// The travel with its limits; for every approach the way, the limit, what was ordered, where it ended.
fn map(all: &[Approach<'_>], limits: &AxisLimits) -> Plot {
    let rows: Vec<f64> = (1..=all.len()).map(|row| row as f64).collect();
    let reached = |a: &Approach<'_>| a.angle_deg[a.farthest()];
    let way = |(row, a): (&f64, &Approach<'_>)| {
        Series::new("path of the axis", Style::Line, vec![a.start_deg, reached(a)], vec![*row, *row])
    };
    let markers = |label: &str, value: &dyn Fn(&Approach<'_>) -> f64| {
        Series::new(label, Style::Markers, all.iter().map(value).collect(), rows.clone())
    };
    let mut series: Vec<Series> = rows.iter().zip(all).map(way).collect();
    series.extend([
        markers("limit", &|a| a.limit_deg),
        markers("ordered to", &|a| a.target_deg),
        markers("reached", &reached),
    ]);
    let mark = |label: &str, rad: f64| Mark { label: label.to_owned(), x: Q::Angle.to_display(rad) };
    let marks = [("end of travel", limits.travel_rad), ("soft limit", limits.soft_limits_rad)];
    let marks = marks.into_iter().flat_map(|(label, ends)| ends.map(|end| mark(label, end)));
    let plot = Plot::new(
        "soft-limits",
        "Travel, limits, orders past them",
        Scale::linear("angle", "deg"),
        Scale::default(),
    );
    Plot { series, marks: marks.collect(), rows: names(all), ..plot }
}

/// How far past its limit each approach came, with the number.
fn past(all: &[Approach<'_>]) -> Plot {
    let past: Vec<f64> = all.iter().map(|a| a.past_deg(a.angle_deg[a.farthest()])).collect();
    let rows: Vec<f64> = (1..=all.len()).map(|row| row as f64).collect();
    let note = |(x, row): (&f64, &f64)| Note { label: readable(*x), at: [*x, *row] };
    let notes = past.iter().zip(&rows).map(note).collect();
    let abscissa = Scale::linear("farthest past the limit (negative: short of it)", "deg");
    let plot =
        Plot::new("past-the-limit", "Stopping position relative to the limit", abscissa, Scale::default());
    Plot {
        series: vec![Series::new("farthest position", Style::Bars, past, rows)],
        marks: vec![Mark { label: "limit".to_owned(), x: 0.0 }],
        notes,
        rows: names(all),
        ..plot
    }
}

fn readable(deg: f64) -> String {
    let text = match deg.abs() < SMALL_DEG {
        true => format!("{:.2} µrad", 1e6 * deg.to_radians()),
        false => format!("{deg:.2}°"),
    };
    match text.strip_prefix('-') {
        Some(zero) if zero.starts_with("0.00 ") => zero.to_owned(),
        Some(size) => format!("−{size}"),
        None => text,
    }
}

/// The last degrees of all approaches, from the same limit and the same moment.
fn overlay(all: &[Approach<'_>]) -> Plot {
    let one = |a: &Approach<'_>| {
        let end_s = a.time_s[a.farthest()];
        let past = |angle: &f64| a.past_deg(*angle);
        let seen = |i: &usize| (SHOWN_S[0]..=SHOWN_S[1]).contains(&(a.time_s[*i] - end_s));
        let seen: Vec<usize> = (0..a.time_s.len()).filter(seen).collect();
        let time: Vec<f64> = seen.iter().map(|&i| a.time_s[i] - end_s).collect();
        let angle: Vec<f64> = seen.iter().map(|&i| past(&a.angle_deg[i])).filter(|p| p.is_finite()).collect();
        Series::thinned(a.name.clone(), Style::Line, [&time, &angle], APPROACH_POINTS)
    };
    let ordinate = Scale::linear("past the limit", "deg");
    let plot = Plot::new(
        "approaches",
        "Approaches to the limit",
        Scale::linear("time since the farthest position", "s"),
        ordinate,
    );
    Plot {
        series: all.iter().map(one).collect(),
        limits: vec![LimitLine { label: "limit".to_owned(), y: 0.0, x: None }],
        x_range: Some(SHOWN_S),
        y_range: Some(SHOWN_DEG),
        ..plot
    }
}
