//! One point: what the log says of the paths from torque to encoder and gyro.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use analysis::polarity::{RateResponse, compliance, compliance_cut_short, rate_response, torque_scale};

use super::plan::{RAMP, SINE, SINE_ORDERS, SINE_PERIOD_S};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::log::{EndedBy, PointStatus, Rows, SegmentSpan, Window};
use crate::measurement::{Evidence, PointResult};

/// Means over which gyro and encoder are compared.
const MEAN_S: f64 = 0.05;
/// End of the settling that goes into the record: where the axis stands before the first torque.
const LEAD_S: f64 = 0.3;
/// Relative standard uncertainty of the inertia in the rig file, with what flexible modes take off (5 Hz against 17 Hz and more).
const INERTIA_U_RATIO: f64 = 0.02;

/// Names of the numbers of a point: `[value, u]`, three responses, their u and n,
/// `[value, u, dof, n]`, a count, start and end.
pub(super) const COMPLIANCE: &str = "compliance";
pub(super) const GYRO: &str = "gyro";
/// Rows of an axis that no gyro sees.
pub(super) const ROWS: &str = "rows";
pub(super) const SCALE: &str = "scale";
pub(super) const UNBROKEN: &str = "unbroken";
pub(super) const TIMES: &str = "times";

/// Numbers of a point, by name.
type Numbers = BTreeMap<String, Vec<f64>>;

/// Reduces one point, completed or not.
pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    if window.status != PointStatus::Completed {
        // What followed the first trip is its consequence.
        let trip =
            window.trips.first().map_or("the point was broken off".to_owned(), |t| format!("tripped, {t}"));
        result.inconclusive = Some(trip);
    }
    result.numbers = at_rest(window, axes);
    match reduce(case, window, axes) {
        Ok(numbers) => result.numbers.extend(numbers),
        Err(reason) => {
            result.inconclusive.get_or_insert(reason);
        }
    }
    result
}

/// Where every encoder says that its axis is, before the first torque; also of a point that was refused.
fn at_rest(window: &Window, axes: &Axes) -> Numbers {
    let first_s = window.segments.first().map_or(f64::INFINITY, |span| span.start_s);
    let angle = |name: &str| Columns::of(window, name).ok().map(|drive| drive.angle_at(first_s));
    axes.names().filter_map(|name| Some((at_rest_of(name), vec![angle(name)?]))).collect()
}

/// Name of that number of an axis.
pub(super) fn at_rest_of(axis: &str) -> String {
    format!("at rest {axis}")
}

fn reduce(case: &Case, window: &Window, axes: &Axes) -> Result<Numbers, String> {
    let limits = axes.get(&case.axis).ok_or_else(|| format!("the log's rig has no axis `{}`", case.axis))?;
    let drive = Columns::of(window, &case.axis)?;
    let label = |span: &SegmentSpan| case.segments.get(span.segment).map_or("", |s| s.label.as_str());
    let settled_s = window.segments.first().ok_or("nothing was commanded")?.end_s;
    // The periodic torque is evaluated by itself.
    let slow = window.segments.iter().filter(|span| label(span) != SINE);
    let (first, last) = (settled_s - LEAD_S, slow.map(|span| span.end_s).fold(settled_s, f64::max));
    let mut numbers = Numbers::from([(TIMES.to_owned(), vec![first, last])]);
    let whole = window.segments.len() == case.segments.len();
    let gave = if whole {
        let [time, torque, angle] = drive.in_rows(&drive.rows.range(first, last));
        compliance(time, torque, angle)
    } else {
        let [_, torque, angle] = drive.in_rows(&drive.rows.range(settled_s, last));
        compliance_cut_short(torque, angle, drive.angle_at(settled_s))
    };
    let gave = gave.map_err(|e| format!("torque and encoder: {e}"))?;
    numbers.insert(COMPLIANCE.to_owned(), vec![gave.value, gave.u]);
    if axes.gimbal_index(&case.axis).is_some() {
        let gyro = gyros(window, &drive, first, last)?;
        let all = gyro.along.into_iter().chain(gyro.u).chain([gyro.n as f64]);
        numbers.insert(GYRO.to_owned(), all.collect());
    } else {
        let rows = drive.rows.range(first, last).len();
        numbers.insert(ROWS.to_owned(), vec![rows as f64]);
    }
    if let Some(found) =
        window.segments.iter().find(|s| label(s) == SINE).and_then(|s| scale(&drive, s, limits))
    {
        numbers.insert(SCALE.to_owned(), found.to_vec());
    }
    let unbroken = |span: &&SegmentSpan| label(span).starts_with(RAMP) && span.ended_by == EndedBy::Timeout;
    numbers.insert(UNBROKEN.to_owned(), vec![window.segments.iter().filter(unbroken).count() as f64]);
    Ok(numbers)
}

/// Torque scale from the periodic torque, without the period in which it fades in: `[value, u, dof, n]`.
fn scale(drive: &Columns<'_>, sine: &SegmentSpan, limits: &AxisLimits) -> Option<[f64; 4]> {
    if sine.ended_by != EndedBy::Completed {
        return None;
    }
    let [time, torque, angle] = drive.in_rows(&drive.rows.range(sine.start_s + SINE_PERIOD_S, sine.end_s));
    let period = (SINE_PERIOD_S, &SINE_ORDERS[..]);
    let found = torque_scale(time, torque, angle, limits.inertia_kg_m2, period).ok()?;
    let u = found.u.hypot(INERTIA_U_RATIO * found.value).hypot(limits.torque_constant_u_ratio * found.value);
    Some([found.value, u, found.dof, found.n as f64])
}

/// Rates along left, up and ahead of the line of sight, against the encoder of the axis.
fn gyros(window: &Window, drive: &Columns<'_>, from_s: f64, to_s: f64) -> Result<RateResponse, String> {
    let imu = window.rows("/imu").ok_or("the log has no topic /imu: no gyro to check the encoders with")?;
    let rows = imu.range(from_s, to_s);
    let column = |name: &str| -> Result<&[f64], String> {
        let column = imu.column(name).ok_or_else(|| format!("/imu has no channel {name}"))?;
        Ok(&column[rows.clone()])
    };
    let x = column("rate_x_rad_per_s")?;
    let y = column("rate_y_rad_per_s")?;
    let ahead = column("rate_z_rad_per_s")?;
    // X and Y stand at 45° about the line of sight (director.md §6): left = (x − y)/√2, up = (x + y)/√2.
    let mixed =
        |sign: f64| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| FRAC_1_SQRT_2 * (x + sign * y)).collect() };
    let (left, up) = (mixed(-1.0), mixed(1.0));
    let time = &imu.time_s[rows.clone()];
    let angle: Vec<f64> = time.iter().map(|&t| drive.angle_at(t)).collect();
    rate_response(time, [&left, &up, ahead], &angle, MEAN_S).map_err(|e| format!("gyro and encoder: {e}"))
}

/// Directions of a positive rate about azimuth and elevation in left, up, ahead (director.md §6: a positive rate about
/// `left` turns the line of sight down).
pub(super) fn direction(is_elevation: bool, elevation_rad: f64) -> [f64; 3] {
    let (sin, cos) = elevation_rad.sin_cos();
    if is_elevation { [-1.0, 0.0, 0.0] } else { [0.0, cos, sin] }
}

/// Channels of a drive.
struct Columns<'a> {
    rows: &'a Rows,
    torque_nm: &'a [f64],
    angle_rad: &'a [f64],
}

impl<'a> Columns<'a> {
    fn of(window: &'a Window, axis: &str) -> Result<Self, String> {
        let topic = format!("/{axis}");
        let rows = window.rows(&topic).ok_or_else(|| format!("the log has no topic {topic}"))?;
        let column = |name: &str| rows.column(name).ok_or_else(|| format!("{topic} has no channel {name}"));
        let (torque_nm, angle_rad) = (column("torque_nm")?, column("position_rad")?);
        if rows.time_s.is_empty() {
            return Err(format!("{topic} has no rows"));
        }
        Ok(Self { rows, torque_nm, angle_rad })
    }

    fn in_rows(&self, rows: &Range<usize>) -> [&'a [f64]; 3] {
        [&self.rows.time_s[rows.clone()], &self.torque_nm[rows.clone()], &self.angle_rad[rows.clone()]]
    }

    /// Angle in the last row at or before a time.
    fn angle_at(&self, time_s: f64) -> f64 {
        let after = self.rows.time_s.partition_point(|&t| t <= time_s);
        self.angle_rad[after.saturating_sub(1)]
    }
}

/// Where the numbers of a point come from.
pub(super) fn evidence(axis: &str, has_gyro: bool, point: &PointResult) -> Vec<Evidence> {
    let Some(&[t0_s, t1_s]) = point.numbers.get(TIMES).map(Vec::as_slice) else { return Vec::new() };
    let channels = ["position_rad", "torque_nm"].map(|name| format!("/{axis} {name}"));
    let gyros = ["x", "y", "z"].iter().filter(|_| has_gyro).map(|k| format!("/imu rate_{k}_rad_per_s"));
    vec![Evidence { file: String::new(), channels: channels.into_iter().chain(gyros).collect(), t0_s, t1_s }]
}
