//! Over all points.

use super::Keys;
use crate::axis::Axes;
use crate::case::Case;
use crate::measurement::{Conclusion, PointResult};

pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let _ = (keys, cases, axes);
    let measurements = points.iter().flat_map(|p| p.measurements.clone()).collect();
    let plots = points.iter().flat_map(|p| p.plots.clone()).collect();
    Conclusion { measurements, plots, ..Conclusion::default() }
}
