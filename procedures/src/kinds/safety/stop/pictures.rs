//! Pictures: angles and times of the stops against what was computed, and the rate after the cause.

use crate::case::Case;
use crate::log::{StopRecord, Window};
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;
use crate::trace::{Mark, Plot, Scale, Series, Style};

/// Points of one course among several.
const COURSE_POINTS: usize = 400;
/// Time before the cause and after the end of a stop that is shown.
const AROUND_S: f64 = 0.3;

/// What the pictures need of a point.
pub(super) struct Shown {
    reached_deg: f64,
    computed_deg: f64,
    took_s: f64,
    /// Time that the stop was computed to take at the most; `None` without torque.
    computed_s: Option<f64>,
    /// Rate over the time since the cause, thinned.
    course: Option<Series>,
}

impl Shown {
    pub(super) fn new(case: &Case, window: &Window, stop: &StopRecord) -> Self {
        Self {
            reached_deg: Q::Angle.to_display(stop.reached_angle_rad),
            computed_deg: Q::Angle.to_display(stop.computed_angle_rad),
            took_s: stop.took_s,
            computed_s: stop.computed_s,
            course: course(case, window, stop),
        }
    }
}

/// A stop with the name of its row.
struct Row<'a> {
    name: String,
    stop: &'a Shown,
}

/// The rate from shortly before the cause, which ended the last segment, to shortly after standstill.
fn course(case: &Case, window: &Window, stop: &StopRecord) -> Option<Series> {
    let rows = window.rows(&format!("/{}", case.axis))?;
    let cause_s = window.segments.last()?.end_s;
    let seen = rows.range(cause_s - AROUND_S, cause_s + stop.took_s + AROUND_S);
    let rate: Vec<f64> = rows
        .column("velocity_rad_per_s")?
        .get(seen.clone())?
        .iter()
        .map(|r| Q::AngularVelocity.to_display(*r))
        .collect();
    let since: Vec<f64> = rows.time_s.get(seen)?.iter().map(|t| t - cause_s).collect();
    Some(Series::thinned(case.axis.clone(), Style::Line, [&since, &rate], COURSE_POINTS))
}

/// All pictures of a procedure.
pub(super) fn pictures(points: &[PointResult]) -> Vec<Plot> {
    let rows: Vec<Row<'_>> = points
        .iter()
        .filter_map(|point| Some(Row { name: name(&point.point), stop: point.reduced.get()? }))
        .collect();
    if rows.is_empty() {
        return Vec::new();
    }
    let angles = Plot::new(
        "stop-angles",
        "Angles of the stops against the computed ones",
        Scale::linear("angle from the cause to standstill", "deg"),
        Scale::default(),
    );
    let times = Plot::new(
        "stop-times",
        "Times of the stops against the computed ones",
        Scale::linear("time from the cause to standstill", "s"),
        Scale::default(),
    );
    vec![
        bars(angles, &rows, |stop| stop.reached_deg, |stop| Some(stop.computed_deg)),
        bars(times, &rows, |stop| stop.took_s, |stop| stop.computed_s),
        rates(&rows),
    ]
}

/// A row a stop: what was reached as a bar, what was computed as a marker.
fn bars(
    plot: Plot,
    rows: &[Row<'_>],
    reached: impl Fn(&Shown) -> f64,
    computed: impl Fn(&Shown) -> Option<f64>,
) -> Plot {
    let heights: Vec<f64> = (1..=rows.len()).map(|row| row as f64).collect();
    let reached = rows.iter().map(|row| reached(row.stop)).collect();
    let marked = rows.iter().zip(&heights).filter_map(|(row, height)| Some((computed(row.stop)?, *height)));
    let (computed, computed_heights): (Vec<f64>, Vec<f64>) = marked.unzip();
    let mut series = vec![Series::new("reached", Style::Bars, reached, heights)];
    if !computed.is_empty() {
        series.push(Series::new("computed upper bound", Style::Markers, computed, computed_heights));
    }
    Plot { series, rows: rows.iter().map(|row| row.name.clone()).collect(), ..plot }
}

fn name(point: &str) -> String {
    point.replace("velocity=", "").replace(" deg/s", "\u{a0}°/s").replace(" -", " −")
}

fn rates(rows: &[Row<'_>]) -> Plot {
    let course = |row: &Row<'_>| Some(Series { label: row.name.clone(), ..row.stop.course.clone()? });
    let shown = Q::AngularVelocity.display_unit();
    let plot = Plot::new(
        "stop-rates",
        "Rate after the cause of the stop",
        Scale::linear("time since the cause", "s"),
        Scale::linear("rate", shown),
    );
    let marks = vec![Mark { label: "cause".to_owned(), x: 0.0 }];
    Plot { series: rows.iter().filter_map(course).collect(), marks, ..plot }
}
