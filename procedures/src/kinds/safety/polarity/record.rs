//! One point: what the log says of the paths from torque to encoder and gyro.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use analysis::estimate::Estimate;
use analysis::polarity::{RateResponse, compliance, compliance_cut_short, rate_response, small_motion};
use analysis::uncertainty::{Component, combine, rectangular_u};

use super::plan::{HIGHEST_ORDER, RAMP, SINE, SINE_PERIOD_S};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::log::{EndedBy, PointStatus, Rows, SegmentSpan, Window};
use crate::measurement::{Evidence, PointResult, Reduced};
use crate::missing::Missing;
use crate::reason::{Reason, SafetyReason};

/// Channels of the gyros.
const GYROS: [&str; 3] = ["rate_x_rad_per_s", "rate_y_rad_per_s", "rate_z_rad_per_s"];
/// Means over which gyro and encoder are compared.
const MEAN_S: f64 = 0.05;
/// End of the settling that goes into the record: where the axis stands before the first torque.
const LEAD_S: f64 = 0.3;
/// Largest share by which flexible modes let an axis seem heavier at the encoder: on each line J·c·ω²/(ω_n² − ω²) over all modes,
/// at 5.25 Hz up to 3.3 % with the modes of elevation (17 Hz) and 0.6 % with those of azimuth (42 Hz; modes.md), and a tenth more of units
/// whose modes are 5 % lower. Half of it is taken off, and is the half-width of a rectangular distribution.
const MODES_RATIO: f64 = 0.045;
/// What a contact that bears a load (cogging, unbalance) adds: it yields more in one direction, which no spring with a damper does.
/// Integrated LuGre contacts under loads up to 0.7 of their static friction seem heavier by up to 1 %. Half of it is taken off, too.
const LOAD_RATIO: f64 = 0.01;
/// What the angle may be late against the torque: the sensor, and the hold of a bus; 1 ms in the simulated director. The damping of the
/// contact then shows as inertia. Half of it is taken off, and is the half-width of a rectangular distribution.
const LATE_S: f64 = 2e-3;

/// What one point says.
pub(super) struct Record {
    /// Where every encoder says that its axis is, before the first torque, by name of the axis; also of a point that was
    /// refused.
    pub(super) at_rest_rad: BTreeMap<String, f64>,
    /// What was seen of the torque; `None` where it did not come to that.
    pub(super) seen: Option<Seen>,
}

/// What encoder and gyro show of a torque.
pub(super) struct Seen {
    /// Time that was evaluated, on the log's axis.
    pub(super) span_s: [f64; 2],
    /// Displacement per torque, rad/(N·m).
    pub(super) compliance: Estimate,
    /// Response of the gyros per rate of the encoder; `None` for an axis that no gyro sees.
    pub(super) gyro: Option<RateResponse>,
    /// Rows of the drive in the span.
    pub(super) rows: usize,
    /// Torque that acts over torque that is reported, by the encoder, where the periodic torque ran to its end.
    pub(super) scale: Option<Estimate>,
    /// The same by the gyros: errors of the encoder over a few µrad are not in it.
    pub(super) scale_by_gyro: Option<Estimate>,
    /// Whether a ramp came to the torque limit of this check and the axis had not moved far enough.
    pub(super) is_unbroken: bool,
}

/// Reduces one point, completed or not.
pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult::of(case);
    if window.status != PointStatus::Completed {
        // What followed the first trip is its consequence.
        let reason = match window.trips.first() {
            Some(trip) => SafetyReason::Tripped { trip: trip.clone() },
            None => SafetyReason::BrokenOff,
        };
        result.inconclusive = Some(reason.into());
    }
    let seen = match seen(case, window, axes) {
        Ok(seen) => Some(seen),
        Err(reason) => {
            result.inconclusive.get_or_insert(reason);
            None
        }
    };
    result.reduced = Reduced::to(Record { at_rest_rad: at_rest_rad(window, axes), seen });
    result
}

fn at_rest_rad(window: &Window, axes: &Axes) -> BTreeMap<String, f64> {
    let first_s = window.segments.first().map_or(f64::INFINITY, |span| span.start_s);
    let angle_rad = |name: &str| Columns::read(window, name).ok().map(|drive| drive.angle_at(first_s));
    axes.names().filter_map(|name| Some((name.to_owned(), angle_rad(name)?))).collect()
}

fn seen(case: &Case, window: &Window, axes: &Axes) -> Result<Seen, Reason> {
    let limits = axes.limits(&case.axis)?;
    let drive = Columns::read(window, &case.axis)?;
    let label = |span: &SegmentSpan| case.segments.get(span.segment).map_or("", |s| s.label.as_str());
    let settled_s = window.segments.first().ok_or(SafetyReason::NothingCommanded)?.end_s;
    // The periodic torque is evaluated by itself.
    let slow = window.segments.iter().filter(|span| label(span) != SINE);
    let first_s = settled_s - LEAD_S;
    let last_s = slow.map(|span| span.end_s).fold(settled_s, f64::max);
    let rows = drive.rows.range(first_s, last_s);
    let is_whole = window.segments.len() == case.segments.len();
    let compliance = if is_whole {
        let [time, torque, angle] = drive.in_rows(&rows);
        compliance(time, torque, angle)
    } else {
        let [_, torque, angle] = drive.in_rows(&drive.rows.range(settled_s, last_s));
        compliance_cut_short(torque, angle, drive.angle_at(settled_s))
    };
    let has_gyro = axes.gimbal_index(&case.axis).is_some();
    let gyro = if has_gyro { Some(gyros(window, &drive, first_s, last_s)?) } else { None };
    let sine = window.segments.iter().find(|span| label(span) == SINE);
    let sine = sine.filter(|sine| sine.ended_by == EndedBy::Completed);
    let by_gyro = |sine| scale_by_gyro(window, &drive, sine, gyro.as_ref()?, limits);
    let unbroken = |span: &SegmentSpan| label(span).starts_with(RAMP) && span.ended_by == EndedBy::Timeout;
    Ok(Seen {
        span_s: [first_s, last_s],
        compliance: compliance.map_err(SafetyReason::TorqueAndEncoder)?,
        rows: rows.len(),
        scale: sine.and_then(|sine| scale(drive.in_rows(&drive.periodic(sine)), limits)),
        scale_by_gyro: sine.and_then(by_gyro),
        gyro,
        is_unbroken: window.segments.iter().any(unbroken),
    })
}

/// Torque scale from time, torque and angle under the periodic torque, by the inertia of the rig file.
fn scale([time, torque, angle]: [&[f64]; 3], limits: &AxisLimits) -> Option<Estimate> {
    let found = small_motion(time, torque, angle, (SINE_PERIOD_S, HIGHEST_ORDER)).ok()?;
    let shown = found.inertia_kg_m2;
    let late = 0.5 * LATE_S * found.damping_nm_s_per_rad;
    let inertia = (shown.value - late) / (1.0 + 0.5 * (MODES_RATIO + LOAD_RATIO));
    let value = limits.inertia_kg_m2 / inertia;
    let rectangular = |half_width_ratio: f64| Component::known(rectangular_u(half_width_ratio) * value.abs());
    let spread = combine(&[
        Component { u: shown.u * (value / inertia).abs(), dof: shown.dof },
        rectangular(0.5 * MODES_RATIO),
        rectangular(0.5 * LOAD_RATIO),
        rectangular(late / inertia),
    ]);
    Some(Estimate { value, u: spread.u, dof: spread.dof, n: shown.n })
}

/// The same with the angle that the gyros turned through in the direction in which they respond.
fn scale_by_gyro(
    window: &Window,
    drive: &Columns<'_>,
    sine: &SegmentSpan,
    response: &RateResponse,
    limits: &AxisLimits,
) -> Option<Estimate> {
    let imu = window.rows("/imu")?;
    let rows = imu.range(sine.start_s, sine.end_s);
    let rates = GYROS.map(|name| imu.channel(name).ok().map(|rates| &rates[rows.clone()]));
    let [x, y, ahead] = [rates[0]?, rates[1]?, rates[2]?];
    let [left, up] = [mixed(x, y, -1.0), mixed(x, y, 1.0)];
    let along = response.along.map(|along| along / response.size());
    let time = &imu.time_s[rows];
    // A row is the mean since the row before.
    let mut turned_rad = vec![0.0; time.len()];
    for k in 1..time.len() {
        let rate = along[0] * left[k] + along[1] * up[k] + along[2] * ahead[k];
        turned_rad[k] = turned_rad[k - 1] + rate * (time[k] - time[k - 1]);
    }
    let [at_s, torque, _] = drive.in_rows(&drive.periodic(sine));
    let angle: Option<Vec<f64>> = at_s.iter().map(|&at_s| between(time, &turned_rad, at_s)).collect();
    scale([at_s, torque, &angle?], limits)
}

/// Value at a time on straight lines between samples; beyond the first and the last that of the end.
fn between(time: &[f64], values: &[f64], at_s: f64) -> Option<f64> {
    let after = time.partition_point(|&t| t <= at_s);
    if after == 0 || after == time.len() {
        return values.get(after.saturating_sub(1)).copied();
    }
    let part = (at_s - time[after - 1]) / (time[after] - time[after - 1]);
    Some(values[after - 1] + part * (values[after] - values[after - 1]))
}

/// Rates across the line of sight from gyros at 45° about it (director.md §6): left = (x − y)/√2, up = (x + y)/√2.
fn mixed(x: &[f64], y: &[f64], sign: f64) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| FRAC_1_SQRT_2 * (x + sign * y)).collect()
}

/// Rates along left, up and ahead of the line of sight, against the encoder of the axis.
fn gyros(window: &Window, drive: &Columns<'_>, from_s: f64, to_s: f64) -> Result<RateResponse, Reason> {
    let imu = window.rows("/imu").ok_or(SafetyReason::NoGyro)?;
    let rows = imu.range(from_s, to_s);
    let column = |name: &str| -> Result<&[f64], Reason> { Ok(&imu.channel(name)?[rows.clone()]) };
    let [x, y, ahead] = [column(GYROS[0])?, column(GYROS[1])?, column(GYROS[2])?];
    let [left, up] = [mixed(x, y, -1.0), mixed(x, y, 1.0)];
    let time = &imu.time_s[rows.clone()];
    let angle: Vec<f64> = time.iter().map(|&t| drive.angle_at(t)).collect();
    rate_response(time, [&left, &up, ahead], &angle, MEAN_S)
        .map_err(|e| SafetyReason::GyroAndEncoder(e).into())
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
    fn read(window: &'a Window, axis: &str) -> Result<Self, Missing> {
        let rows = window.topic_with_rows(&format!("/{axis}"))?;
        let torque_nm = rows.channel("torque_nm")?;
        let angle_rad = rows.channel("position_rad")?;
        Ok(Self { rows, torque_nm, angle_rad })
    }

    fn in_rows(&self, rows: &Range<usize>) -> [&'a [f64]; 3] {
        [&self.rows.time_s[rows.clone()], &self.torque_nm[rows.clone()], &self.angle_rad[rows.clone()]]
    }

    /// Rows of the periodic torque without the period in which it fades in.
    fn periodic(&self, sine: &SegmentSpan) -> Range<usize> {
        self.rows.range(sine.start_s + SINE_PERIOD_S, sine.end_s)
    }

    /// Angle in the last row at or before a time.
    fn angle_at(&self, time_s: f64) -> f64 {
        let after = self.rows.time_s.partition_point(|&t| t <= time_s);
        self.angle_rad[after.saturating_sub(1)]
    }
}

/// Where the numbers of a point come from.
pub(super) fn evidence(axis: &str, has_gyro: bool, point: &PointResult) -> Vec<Evidence> {
    let seen = point.reduced.get::<Record>().and_then(|record| record.seen.as_ref());
    let Some(Seen { span_s, .. }) = seen else { return Vec::new() };
    let channels = ["position_rad", "torque_nm"].map(|name| format!("/{axis} {name}"));
    let gyros = ["x", "y", "z"].iter().filter(|_| has_gyro).map(|k| format!("/imu rate_{k}_rad_per_s"));
    vec![Evidence::new(channels.into_iter().chain(gyros).collect(), *span_s)]
}
