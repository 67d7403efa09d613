//! One stop: what the bench wrote down of it.

use analysis::estimate::Estimate;

use super::keys::Way;
use super::pictures::Shown;
use super::{ANGLE, ANGLE_RATIO, MEASURANDS, ROOM, TIME, TIME_RATIO};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::log::{StopRecord, Window};
use crate::measurement::{Condition, Evidence, Measurement, PointResult, Reduced};
use crate::quantity::QuantityKind;
use crate::reason::{Reason, SafetyReason};

const ESTIMATOR: &str = "stop/3";

/// What a point says, or why not.
pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let stop = match stop_of(case, window) {
        Ok(stop) => stop,
        Err(reason) => {
            let all: Vec<_> = MEASURANDS.iter().map(|m| (m.name, m.kind)).collect();
            return PointResult::without(case, &all, ESTIMATOR, reason);
        }
    };
    PointResult {
        measurements: measurements(case, window, stop, axes),
        reduced: Reduced::to(Shown::new(case, window, stop)),
        ..PointResult::of(case)
    }
}

fn stop_of<'a>(case: &Case, window: &'a Window) -> Result<&'a StopRecord, Reason> {
    let way = Way::of(case).ok_or_else(|| SafetyReason::NoManner { point: case.point.clone() })?;
    let stop = window.stops.iter().find(|stop| stop.axis == case.axis);
    let stop = stop.ok_or_else(|| SafetyReason::NoStop { axis: case.axis.clone() })?;
    if stop.manner != way.manner() {
        return Err(SafetyReason::OtherManner { asked: way.manner(), found: stop.manner }.into());
    }
    if !stop.standstill {
        return Err(SafetyReason::NoStandstill.into());
    }
    let numbers =
        [stop.reached_angle_rad, stop.computed_angle_rad, stop.took_s, stop.from_rad_per_s, stop.room_rad];
    if numbers.iter().any(|number| !number.is_finite()) || stop.computed_angle_rad <= 0.0 {
        return Err(SafetyReason::StopNoNumber.into());
    }
    Ok(stop)
}

fn measurements(case: &Case, window: &Window, stop: &StopRecord, axes: &Axes) -> Vec<Measurement> {
    let limits = axes.get(&case.axis);
    let quantum_rad = limits.map_or(0.0, |limits| limits.encoder_quantum_rad);
    let tick_s = limits.map_or(0.0, AxisLimits::tick_s);
    // What begins a stop is noticed at a tick: another stop begins anywhere within one.
    let u_angle_rad = quantum_rad.hypot(stop.from_rad_per_s * tick_s / 12.0_f64.sqrt());
    let over = |value: f64, computed: f64| if computed > 0.0 { Some(value / computed) } else { None };
    let angle = over(stop.reached_angle_rad, stop.computed_angle_rad);
    let time = stop.computed_s.and_then(|computed_s| over(stop.took_s, computed_s));
    let slower = [angle, time].into_iter().flatten().any(|ratio| ratio > 1.0);
    let all = [
        (ANGLE, Some(stop.reached_angle_rad), u_angle_rad),
        (TIME, Some(stop.took_s), tick_s),
        (ANGLE_RATIO, angle, u_angle_rad / stop.computed_angle_rad),
        (TIME_RATIO, time, tick_s / stop.computed_s.unwrap_or(f64::INFINITY)),
        (ROOM, Some(stop.room_rad), u_angle_rad),
    ];
    all.into_iter()
        .map(|(name, value, u)| {
            let kind = MEASURANDS.iter().find(|m| m.name == name).map_or(QuantityKind::Ratio, |m| m.kind);
            let estimate = value.map(|value| Estimate { value, u, dof: f64::INFINITY, n: 1 });
            let mut measurement = Measurement::new(name, &case.axis, kind, estimate, ESTIMATOR);
            if value.is_none() {
                measurement.inconclusive = Some("without torque no time is computed".to_owned());
            }
            if slower {
                measurement.flags.push("MORE THAN COMPUTED".to_owned());
            }
            Measurement {
                point: Some(case.point.clone()),
                conditions: Condition::reached(case, |_| Some(stop.from_rad_per_s)),
                evidence: evidence(case, window),
                ..measurement
            }
        })
        .collect()
}

fn evidence(case: &Case, window: &Window) -> Vec<Evidence> {
    let topic = format!("/{}", case.axis);
    let times = window.rows(&topic).map_or(&[][..], |rows| &rows.time_s);
    let [Some(&t0_s), Some(&t1_s)] = [times.first(), times.last()] else { return Vec::new() };
    let channels = vec![format!("{topic} position_rad"), format!("{topic} velocity_rad_per_s")];
    vec![Evidence::new(channels, [t0_s, t1_s])]
}
