//! Measurements of a point.

use analysis::estimate::Estimate;

use super::keys::Stage;
use crate::case::Case;
use crate::log::Window;
use crate::measurement::{Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const ESTIMATOR: &str = "latency/1";

/// A point without numbers, and why.
pub(super) fn without(case: &Case, stage: Stage, reason: &str) -> PointResult {
    let all: Vec<_> = stage.measurands().iter().map(|name| (*name, Q::Time)).collect();
    PointResult::without(case, &all, ESTIMATOR, reason).under(&conditions(case, None))
}

/// A time of a point, at the level that its record holds, V peak to peak.
pub(super) fn measurement(
    name: &str,
    case: &Case,
    level_v: Option<f64>,
    estimate: Estimate,
    flags: Vec<String>,
) -> Measurement {
    Measurement {
        point: Some(case.point.clone()),
        conditions: conditions(case, level_v),
        flags,
        ..Measurement::new(name, &case.axis, Q::Time, Some(estimate), ESTIMATOR)
    }
}

/// The level is all that is asked of a point.
fn conditions(case: &Case, level_v: Option<f64>) -> Vec<Condition> {
    Condition::reached(case, |_| level_v)
}

/// Where a number comes from.
pub(super) fn evidence(window: &Window, topic: &str, channels: &[&str]) -> Vec<Evidence> {
    let times = window.rows(topic).map(|rows| rows.time_s.as_slice());
    let Some((&[t0_s, ..], &[.., t1_s])) = times.map(|t| (t, t)) else { return Vec::new() };
    let channels = channels.iter().map(|channel| format!("{topic} {channel}")).collect();
    vec![Evidence::new(channels, [t0_s, t1_s])]
}

/// Microseconds, for people.
pub(super) fn us(s: f64) -> f64 {
    1e6 * s
}
