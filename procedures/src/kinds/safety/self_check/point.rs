//! The stretch at rest: every channel that is in the log.

use std::ops::Range;

use analysis::estimate::Estimate;
use analysis::stillness::stillness;

use super::channels::{Alive, CLOCK, Clock, Watched, channels};
use super::keys::{Keys, REST};
use crate::axis::Axes;
use crate::case::Case;
use crate::drift;
use crate::log::{Rows, Window};
use crate::measurement::{Evidence, Measurement, PointResult};
use crate::reason::{Reason, SafetyReason};

const ESTIMATOR: &str = "self-check/1";
const BENCH: &str = "/bench";
/// Angle by the encoder of an axis.
const ANGLE: &str = "position_rad";

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult::of(case);
    let span = match window.segment(case, REST) {
        Ok(span) => span,
        Err(missing) => return PointResult { inconclusive: Some(missing.into()), ..result },
    };
    let during = [span.start_s, span.end_s];
    for watched in channels(axes) {
        if let Some(rows) = window.rows(&watched.topic) {
            result.measurements.extend(of_channel(&watched, rows, window, during));
        }
    }
    if let Some(rows) = window.rows(BENCH) {
        result.measurements.extend(of_clock(rows, during));
    }
    for measurement in &mut result.measurements {
        measurement.point = Some(case.point.clone());
        let allowed = keys.drift.iter().find(|(name, _)| *name == measurement.measurand);
        measurement.conditions =
            allowed.map(|&(_, most)| drift::allowed(most, measurement.kind)).into_iter().collect();
    }
    result
}

/// Mean and noise of a channel, or why not.
fn of_channel(watched: &Watched, rows: &Rows, window: &Window, during: [f64; 2]) -> Vec<Measurement> {
    let range = rows.range(during[0], during[1]);
    let read = values(watched, rows, window, &range)
        .and_then(|values| stillness(&rows.time_s[range.clone()], &values).map_err(Reason::from));
    let names = [(watched.offset, true), (watched.noise, false)];
    let channel = format!("{} {}", watched.topic, watched.channel);
    let one = |(name, mean): (Option<&'static str>, bool)| {
        let name = name?;
        let measurement = match &read {
            Ok(found) => {
                let estimate = if mean { found.mean } else { found.noise };
                Measurement::new(name, &watched.axis, watched.kind, Some(estimate), ESTIMATOR)
            }
            Err(reason) => Measurement::inconclusive(
                name,
                &watched.axis,
                watched.kind,
                ESTIMATOR,
                SafetyReason::OfChannel { channel: channel.clone(), reason: Box::new(reason.clone()) },
            ),
        };
        Some(Measurement { evidence: evidence(&channel, during), ..measurement })
    };
    names.into_iter().filter_map(one).collect()
}

/// Values of a channel while it is alive, less what is taken off.
fn values(watched: &Watched, rows: &Rows, window: &Window, range: &Range<usize>) -> Result<Vec<f64>, Reason> {
    let column =
        |name: &str| rows.column(name).ok_or_else(|| SafetyReason::NoChannel { channel: name.to_owned() });
    let own = &column(watched.channel)?[range.clone()];
    match watched.alive {
        Some(Alive::Counts(counter)) => {
            let counts = &column(counter)?[range.clone()];
            if counts.windows(2).all(|pair| pair[0] == pair[1]) {
                return Err(SafetyReason::NoMessage.into());
            }
        }
        Some(Alive::Is(flag)) if column(flag)?[range.clone()].iter().any(|&is| is != 1.0) => {
            return Err(SafetyReason::NothingInSight.into());
        }
        Some(Alive::Is(_)) | None => {}
    }
    let Some(topic) = &watched.less else { return Ok(own.to_vec()) };
    let other = window.rows(topic).and_then(|rows| Some((rows, rows.column(ANGLE)?)));
    let (other, values) =
        other.ok_or_else(|| SafetyReason::NoAngle { topic: topic.clone(), channel: ANGLE })?;
    let newest = |t: &f64| other.time_s.partition_point(|own| own <= t).checked_sub(1);
    let times = &rows.time_s[range.clone()];
    own.iter()
        .zip(times)
        .map(|(value, t)| newest(t).map(|k| value - values[k]))
        .collect::<Option<Vec<f64>>>()
        .ok_or_else(|| SafetyReason::BeginsLater { topic: topic.clone() }.into())
}

/// Missed periods and worst lateness.
fn of_clock(rows: &Rows, during: [f64; 2]) -> Vec<Measurement> {
    let range = rows.range(during[0], during[1]);
    let of = |&(clock, name, kind, channel): &(Clock, &str, _, &str)| {
        let values = &rows.column(channel)?[range.clone()];
        let value = match clock {
            Clock::Missed => values.iter().sum::<f64>(),
            Clock::Lateness => values.iter().copied().fold(0.0, f64::max),
        };
        let whole = value.is_finite() && !values.is_empty();
        let estimate = Estimate { value, u: 0.0, dof: f64::INFINITY, n: values.len() };
        let measurement = if whole {
            Measurement::new(name, "bench", kind, Some(estimate), ESTIMATOR)
        } else {
            Measurement::inconclusive(name, "bench", kind, ESTIMATOR, SafetyReason::NoRowsOrNumbers)
        };
        Some(Measurement { evidence: evidence(&format!("{BENCH} {channel}"), during), ..measurement })
    };
    CLOCK.iter().filter_map(of).collect()
}

fn evidence(channel: &str, [t0_s, t1_s]: [f64; 2]) -> Vec<Evidence> {
    vec![Evidence::new(vec![channel.to_owned()], [t0_s, t1_s])]
}
