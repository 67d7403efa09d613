//! One point: torque over angle, by the gauge or by the current.

use std::f64::consts::TAU;

use analysis::derivative::Differentiator;
use analysis::plateau::{longest_steady, mean_velocity_rad_per_s};
use analysis::stillness::stillness;

use super::ESTIMATOR;
use super::keys::Keys;
use super::plan::{LEAST_PERIODS, PULL, ZERO};
use super::{MEASURANDS, PULLED};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::kinds::hysteresis::Branches;
use crate::log::{Rows, SegmentSpan, Window};
use crate::measurement::{Measurement, PointResult};

/// Topic and channel of the gauge.
pub(super) const TOPIC: &str = "/force";
pub(super) const CHANNEL: &str = "force_n";

/// Names of numbers.
pub(super) const ANGLE: &str = "angle_rad";
pub(super) const TORQUE: &str = "torque_nm";
pub(super) const FALLING: &str = "falling_nm";
/// Of a pull: rate, standard uncertainty of the torque from the gauge's zero. Of the driven point: rate, that of the drive's
/// quantum.
pub(super) const FIGURES: &str = "figures";
/// Begin and end on the log's time axis.
pub(super) const SPAN: &str = "span_s";

/// Pulled: rate within this of what was asked for.
const STEADY_RATIO: f64 = 0.1;
/// Part of a cogging period over which a rate is a mean.
const RATE_SHARE: f64 = 0.25;
/// Acceleration is followed up to this frequency: the cogging of a slow pull is below 1 Hz.
const FLAT_HZ: f64 = 5.0;
/// A gauge whose zero wanders by more than this share of the largest pull is being pulled at.
const ZERO_SHARE: f64 = 0.02;

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    let numbers = match axes.get(&case.axis) {
        None => Err(format!("the log's rig has no axis `{}`", case.axis)),
        Some(limits) if case.pull.is_some() => pulled(keys, case, window, limits),
        Some(limits) => driven(case, window, limits),
    };
    match numbers {
        Ok(numbers) => {
            result.numbers = numbers.into_iter().map(|(name, values)| (name.to_owned(), values)).collect();
        }
        Err(reason) => {
            let kind = MEASURANDS.iter().find(|m| m.name == PULLED).map(|m| m.kind);
            let none = kind.map(|kind| Measurement {
                point: Some(case.point.clone()),
                ..Measurement::inconclusive(PULLED, &case.axis, kind, ESTIMATOR, &reason)
            });
            result.measurements.extend(none);
            result.inconclusive = Some(reason);
        }
    }
    result
}

type Numbers = Vec<(&'static str, Vec<f64>)>;

fn driven(case: &Case, window: &Window, limits: &AxisLimits) -> Result<Numbers, String> {
    let branches = Branches::read(case, window, limits).map_err(|nothing| nothing.reason)?;
    let [growing, falling] = branches.torque_nm;
    let span = branches.evidence.first().map_or([0.0; 2], |e| [e.t0_s, e.t1_s]);
    Ok(vec![
        (ANGLE, branches.angle_rad),
        (TORQUE, growing),
        (FALLING, falling),
        (FIGURES, vec![branches.achieved_rad_per_s, branches.quantum_u_nm]),
        (SPAN, span.to_vec()),
    ])
}

fn span<'a>(case: &Case, window: &'a Window, label: &str) -> Result<&'a SegmentSpan, String> {
    let index = case.segments.iter().position(|segment| segment.label == label);
    let found = window.segments.iter().find(|span| Some(span.segment) == index);
    found.ok_or_else(|| format!("the segment `{label}` did not run"))
}

fn rows<'a>(window: &'a Window, topic: &str, channel: &str) -> Result<(&'a Rows, &'a [f64]), String> {
    let rows = window.rows(topic).ok_or_else(|| format!("the log has no topic {topic}"))?;
    let column = rows.column(channel).ok_or_else(|| format!("{topic} has no channel {channel}"))?;
    Ok((rows, column))
}

fn pulled(keys: &Keys, case: &Case, window: &Window, limits: &AxisLimits) -> Result<Numbers, String> {
    let (gauge, force_n) =
        rows(window, TOPIC, CHANNEL).map_err(|reason| format!("{reason}: the rig needs a force gauge"))?;
    let (before, during) = (span(case, window, ZERO)?, span(case, window, PULL)?);
    let rest = gauge.range(before.start_s, before.end_s);
    let zero = stillness(&gauge.time_s[rest.clone()], &force_n[rest]).map_err(|e| format!("zero: {e}"))?;
    let lasts_s = before.end_s - before.start_s;
    let wanders_n = zero.noise.value + zero.drift_per_s.value.abs() * lasts_s;
    if keys.arm_m * wanders_n > ZERO_SHARE * keys.pull_nm {
        return Err("the gauge was pulled at before its zero was read".to_owned());
    }
    let (axis, angle) = rows(window, &format!("/{}", case.axis), "position_rad")?;
    let range = axis.range(during.start_s, during.end_s);
    let (time, angle) = (&axis.time_s[range.clone()], &angle[range]);
    let rate_hz = even_rate_hz(time).ok_or("rows are missing in the pull, or time does not advance")?;
    let wanted = case.requested("velocity").ok_or("the point names no velocity")?;
    let period_rad = TAU / limits.cogging_orders_per_rev;
    let count = (RATE_SHARE * period_rad / wanted.abs() * rate_hz).round() as usize;
    let steady = longest_steady(angle, rate_hz, wanted, count, STEADY_RATIO);
    let covered = match &angle[steady.clone()] {
        [first, .., last] => (last - first).abs(),
        _ => 0.0,
    };
    if covered < LEAST_PERIODS * period_rad {
        return Err(format!(
            "nobody pulled the axis within 10 % of the velocity over {LEAST_PERIODS} cogging periods"
        ));
    }
    let acceleration = Differentiator::new(rate_hz, FLAT_HZ.min(rate_hz / 16.0))
        .and_then(|d| d.acceleration(angle))
        .ok_or("the pull is too short, or its log too slow, for an acceleration")?;
    let newest = |t: f64| gauge.time_s.partition_point(|own| *own <= t).checked_sub(1);
    let torque = steady.clone().map(|k| {
        let force = force_n[newest(time[k])?] - zero.mean.value;
        Some(keys.arm_m * force * wanted.signum() - limits.inertia_kg_m2 * acceleration[k])
    });
    let torque: Option<Vec<f64>> = torque.collect();
    let torque = torque.filter(|t| t.iter().all(|nm| nm.is_finite())).ok_or("the gauge shows no numbers")?;
    let achieved = mean_velocity_rad_per_s(&angle[steady.clone()], rate_hz).abs();
    Ok(vec![
        (SPAN, vec![time[steady.start], time[steady.end - 1]]),
        (ANGLE, angle[steady].to_vec()),
        (TORQUE, torque),
        (FIGURES, vec![achieved, keys.arm_m * zero.mean.u]),
    ])
}

/// Rows per second, if none is missing.
fn even_rate_hz(time_s: &[f64]) -> Option<f64> {
    let period = (time_s.last()? - time_s.first()?) / (time_s.len().max(2) - 1) as f64;
    let even = time_s.windows(2).all(|pair| pair[1] > pair[0] && pair[1] - pair[0] < 1.5 * period);
    (period > 0.0 && even).then(|| 1.0 / period)
}
