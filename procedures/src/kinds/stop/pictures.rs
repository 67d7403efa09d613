//! Pictures: angles and times of the stops against what was computed, and the rate after the cause.

use crate::case::Case;
use crate::log::{StopRecord, Window};
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;
use crate::trace::{Mark, Plot, Scale, Series, Style};

/// Numbers of a point: reached and computed, and the course of the rate since the cause.
const ANGLES_DEG: &str = "angles-deg";
const TIMES_S: &str = "times-s";
const SINCE_S: &str = "since-the-cause-s";
const RATE: &str = "rate-deg-per-s";
/// Points that the course had before it was thinned.
const COURSE_OF: &str = "course-of";

/// Points of one course among several.
const COURSE_POINTS: usize = 400;
/// Time before the cause and after the end of a stop that is shown.
const AROUND_S: f64 = 0.3;

/// What the pictures need of a point: reached and, where there is one, computed.
pub(super) fn take(result: &mut PointResult, case: &Case, window: &Window, stop: &StopRecord) {
    let angles = [stop.reached_angle_rad, stop.computed_angle_rad].map(|rad| Q::Angle.to_display(rad));
    let times = [Some(stop.took_s), stop.computed_s];
    result.numbers.insert(ANGLES_DEG.to_owned(), angles.into());
    result.numbers.insert(TIMES_S.to_owned(), times.into_iter().flatten().collect());
    let Some(course) = course(case, window, stop) else { return };
    result.numbers.insert(COURSE_OF.to_owned(), vec![course.whole() as f64]);
    result.numbers.insert(SINCE_S.to_owned(), course.x);
    result.numbers.insert(RATE.to_owned(), course.y);
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
pub(super) fn of(points: &[PointResult]) -> Vec<Plot> {
    let known: Vec<&PointResult> = points.iter().filter(|p| p.numbers.contains_key(ANGLES_DEG)).collect();
    if known.is_empty() {
        return Vec::new();
    }
    let angles = against(
        &known,
        ANGLES_DEG,
        ("stop-angles", "Angles of the stops against the computed"),
        ("angle from the cause to standstill", "deg"),
    );
    let times = against(
        &known,
        TIMES_S,
        ("stop-times", "Times of the stops against the computed"),
        ("time from the cause to standstill", "s"),
    );
    vec![angles, times, rates(&known)]
}

/// A row a stop: what was reached as a bar, what was computed as a marker.
fn against(
    points: &[&PointResult],
    numbers: &str,
    (id, title): (&str, &str),
    (label, unit): (&str, &str),
) -> Plot {
    let of = |index: usize| -> (Vec<f64>, Vec<f64>) {
        let value =
            |(row, p): (usize, &&PointResult)| Some((*p.numbers.get(numbers)?.get(index)?, (row + 1) as f64));
        points.iter().enumerate().filter_map(value).unzip()
    };
    let ((reached, reached_at), (computed, computed_at)) = (of(0), of(1));
    let mut series = vec![Series::new("reached", Style::Bars, reached, reached_at)];
    if !computed.is_empty() {
        series.push(Series::new("computed: the most it may take", Style::Markers, computed, computed_at));
    }
    let plot = Plot::new(id, title, Scale::linear(label, unit), Scale::default());
    Plot { series, rows: points.iter().map(|p| name(p)).collect(), ..plot }
}

fn name(point: &PointResult) -> String {
    point.point.replace("velocity=", "").replace(" deg/s", "\u{a0}°/s").replace(" -", " −")
}

fn rates(points: &[&PointResult]) -> Plot {
    let course = |p: &&PointResult| {
        let (x, y) = (p.numbers.get(SINCE_S)?, p.numbers.get(RATE)?);
        let whole = p.numbers.get(COURSE_OF).and_then(|n| n.first()).map(|n| *n as usize);
        Some(Series::new(name(p), Style::Line, x.clone(), y.clone()).drawn_from(whole.unwrap_or(x.len())))
    };
    let shown = Q::AngularVelocity.display_unit();
    let plot = Plot::new(
        "stop-rates",
        "Rate after the cause of the stop",
        Scale::linear("time since the cause", "s"),
        Scale::linear("rate", shown),
    );
    let marks = vec![Mark { label: "cause".to_owned(), x: 0.0 }];
    Plot { series: points.iter().filter_map(course).collect(), marks, ..plot }
}
