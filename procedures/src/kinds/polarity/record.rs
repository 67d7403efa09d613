//! One point: what the log says of the paths from torque to encoder and gyro.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use super::plan::RAMP;
use crate::analysis::polarity::{RateResponse, compliance, rate_response, torque_scale};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::log::{EndedBy, Rows, SegmentSpan, Window};
use crate::measurement::{Evidence, PointResult};

/// Means over which gyro and encoder are compared.
const MEAN_S: f64 = 0.05;
/// Stretch before the torque is switched off, and the longest after it.
const BEFORE_S: f64 = 0.06;
const AFTER_S: f64 = 0.08;
/// The switch is this early at the latest for a fit.
const LEAST_AFTER_S: f64 = 0.03;
/// Relative standard uncertainty of the inertia in the rig file, with what flexible modes add to it.
const INERTIA_U_RATIO: f64 = 0.02;

/// Names of the numbers of a point: `[value, u]`, three responses and their u, `[value, u, dof, n]` per ramp, a count.
pub(super) const COMPLIANCE: &str = "compliance";
pub(super) const GYRO: &str = "gyro";
pub(super) const SCALE: &str = "scale";
pub(super) const UNBROKEN: &str = "unbroken";
pub(super) const TIMES: &str = "times";

/// Numbers of a point, by name.
type Numbers = BTreeMap<String, Vec<f64>>;

/// Reduces one point, completed or not.
pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    match reduce(case, window, axes) {
        Ok(numbers) => result.numbers = numbers,
        Err(reason) => result.inconclusive = Some(reason),
    }
    result
}

fn reduce(case: &Case, window: &Window, axes: &Axes) -> Result<Numbers, String> {
    let limits = axes.get(&case.axis).ok_or_else(|| format!("the log's rig has no axis `{}`", case.axis))?;
    let drive = Columns::of(window, &case.axis)?;
    let (first, last) = match (window.segments.first(), window.segments.last()) {
        (Some(first), Some(last)) => (first.start_s, last.end_s),
        _ => return Err("nothing was commanded".to_owned()),
    };
    let rows = drive.rows.range(first, last);
    let mut numbers = Numbers::from([(TIMES.to_owned(), vec![first, last])]);
    let [time, torque, angle] = drive.in_rows(&rows);
    let gave = compliance(time, torque, angle).map_err(|e| format!("torque and encoder: {e}"))?;
    numbers.insert(COMPLIANCE.to_owned(), vec![gave.value, gave.u]);
    let gyro = gyros(window, &drive, first, last)?;
    let all = gyro.along.into_iter().chain(gyro.u).chain([gyro.n as f64]);
    numbers.insert(GYRO.to_owned(), all.collect());
    ramps(case, window, &drive, limits, &mut numbers);
    Ok(numbers)
}

/// What every ramp that ended as it should says of the torque; how many did not end by motion.
fn ramps(case: &Case, window: &Window, drive: &Columns<'_>, limits: &AxisLimits, numbers: &mut Numbers) {
    let (mut scales, mut unbroken) = (Vec::new(), 0.0);
    for (index, _) in case.segments.iter().enumerate().filter(|(_, s)| s.label.starts_with(RAMP)) {
        let find = |wanted: usize| window.segments.iter().find(|s| s.segment == wanted);
        let (Some(ramp), Some(coast)) = (find(index), find(index + 1)) else { continue };
        if ramp.ended_by == EndedBy::Timeout {
            unbroken += 1.0;
        }
        if let Some(scale) = scale(drive, ramp, coast, limits) {
            scales.extend(scale);
        }
    }
    numbers.insert(SCALE.to_owned(), scales);
    numbers.insert(UNBROKEN.to_owned(), vec![unbroken]);
}

/// Torque scale from the end of a ramp: `[value, u, dof, n]`.
fn scale(
    drive: &Columns<'_>,
    ramp: &SegmentSpan,
    coast: &SegmentSpan,
    limits: &AxisLimits,
) -> Option<[f64; 4]> {
    let off_s = ramp.end_s;
    let before = drive.rows.range((off_s - BEFORE_S).max(ramp.start_s), off_s);
    let after = drive.rows.range(off_s, (off_s + AFTER_S).min(coast.end_s));
    let to = drive.turns_round(&before, &after);
    let rows = before.start..to;
    let [time, torque, angle] = drive.in_rows(&rows);
    if time.last()? - off_s < LEAST_AFTER_S {
        return None;
    }
    let found = torque_scale(time, torque, angle, limits.inertia_kg_m2).ok()?;
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
pub(super) fn direction(axis: &str, elevation_rad: f64) -> [f64; 3] {
    let (sin, cos) = elevation_rad.sin_cos();
    if axis == "el" { [-1.0, 0.0, 0.0] } else { [0.0, cos, sin] }
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

    /// The first row after the switch from which on the axis turns back, or the end of `after`.
    fn turns_round(&self, before: &Range<usize>, after: &Range<usize>) -> usize {
        let angle = self.angle_rad;
        let (Some(start), Some(off)) = (angle.get(before.start), angle.get(after.start)) else {
            return after.end;
        };
        let onwards = (off - start).signum();
        let mut furthest = after.start;
        for row in after.clone() {
            if (angle[row] - angle[furthest]) * onwards > 0.0 {
                furthest = row;
            }
        }
        furthest
    }
}

/// Where the numbers of a point come from.
pub(super) fn evidence(axis: &str, point: &PointResult) -> Vec<Evidence> {
    let Some(&[t0_s, t1_s]) = point.numbers.get(TIMES).map(Vec::as_slice) else { return Vec::new() };
    let channels = ["position_rad", "torque_nm"].map(|name| format!("/{axis} {name}"));
    let gyros = ["x", "y", "z"].map(|k| format!("/imu rate_{k}_rad_per_s"));
    vec![Evidence { file: String::new(), channels: channels.into_iter().chain(gyros).collect(), t0_s, t1_s }]
}
