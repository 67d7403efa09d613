//! One point.

use analysis::estimate::Estimate;

use super::keys::Keys;
use super::plan::names_of;
use super::record::cycle_bounds_s;
use super::{MEASURANDS, axis, dc_link};
use crate::axis::Axes;
use crate::case::Case;
use crate::log::{PointStatus, Window};
use crate::measurement::{Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind;
use crate::trace::Plot;

pub(super) const ESTIMATOR: &str = "duty/1";

/// What a part of the analysis gives.
#[derive(Default)]
pub(super) struct Found {
    pub(super) measurements: Vec<Measurement>,
    pub(super) plots: Vec<Plot>,
}

/// The point as its measurements see it.
pub(super) struct Point<'a> {
    pub(super) keys: &'a Keys,
    pub(super) case: &'a Case,
    pub(super) window: &'a Window,
    pub(super) bounds_s: Vec<f64>,
    /// Why what needs the whole point says nothing.
    pub(super) cut: Option<String>,
}

/// Everything that a point says.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let cut = (window.status != PointStatus::Completed).then(|| match window.trips.as_slice() {
        [] => "the point did not complete".to_owned(),
        trips => format!("the point did not complete ({})", trips.join("; ")),
    });
    let point = Point { keys, case, window, bounds_s: cycle_bounds_s(window), cut };
    let mut result = PointResult::of(case);
    let moved = case.moved_axes();
    let mut take = |found: Found| {
        result.measurements.extend(found.measurements);
        result.plots.extend(found.plots);
    };
    for (index, name) in names_of(&case.axis, axes).into_iter().enumerate() {
        if let Some(name) = name.filter(|name| moved.contains(name)) {
            take(axis::measure(&point, name, index));
        }
    }
    take(dc_link::measure(&point));
    result
}

impl Point<'_> {
    /// A measurement of this point.
    pub(super) fn measurement(
        &self,
        name: &str,
        axis: &str,
        found: Result<Estimate, String>,
        channels: &[String],
    ) -> Measurement {
        let kind = MEASURANDS.iter().find(|m| m.name == name).map_or(QuantityKind::Count, |m| m.kind);
        let measured = match found {
            Ok(estimate) => Measurement::new(name, axis, kind, Some(estimate), ESTIMATOR),
            Err(reason) => Measurement::inconclusive(name, axis, kind, ESTIMATOR, reason),
        };
        let flags = self.cut.iter().map(|_| "as far as the point came".to_owned()).collect();
        Measurement {
            point: Some(self.case.point.clone()),
            flags,
            evidence: self.evidence(channels),
            ..measured
        }
    }

    fn evidence(&self, channels: &[String]) -> Vec<Evidence> {
        let [Some(first), Some(last)] = [self.window.segments.first(), self.window.segments.last()] else {
            return Vec::new();
        };
        let channels = channels.to_vec();
        let file = String::new();
        vec![Evidence { file, channels, t0_s: first.start_s, t1_s: last.end_s }]
    }

    /// What needs the whole point, or why it says nothing.
    pub(super) fn whole<T>(&self, found: Result<T, String>) -> Result<T, String> {
        match &self.cut {
            Some(reason) => Err(reason.clone()),
            None => found,
        }
    }
}

/// An extreme: its uncertainty is known.
pub(super) fn known(value: f64, u: f64, n: usize) -> Estimate {
    Estimate { value, u, dof: f64::INFINITY, n }
}
