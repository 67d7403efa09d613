//! Kind `hysteresis`: strokes at constant velocity back and forth between the same limits.

use super::{Experiment, Kind, Measurand};
use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::table::{Field, TableReader};

mod branches;
mod cogging;
mod conclude;
mod curve;
mod dynamic;
mod gravity;
mod measurands;
mod numbers;
mod pictures;
mod plan;
mod point;
mod record;
mod static_map;
mod sweep;

#[cfg(test)]
pub(in crate::kinds) mod tests;

pub(super) use branches::{Branches, Strokes};
use sweep::Sweep;

/// The kind.
pub(super) struct Hysteresis;

const DOC: &str = include_str!("hysteresis/doc.md");

impl Kind for Hysteresis {
    fn name(&self) -> &'static str {
        "hysteresis"
    }

    fn doc(&self) -> &'static str {
        DOC
    }

    fn fields(&self) -> &'static [Field] {
        sweep::FIELDS
    }

    fn measurands(&self) -> &'static [Measurand] {
        measurands::ALL
    }

    fn read(&self, table: &mut TableReader<'_>) -> Option<Box<dyn Experiment>> {
        Some(Box::new(Sweep::read(table)?))
    }
}

impl Experiment for Sweep {
    fn yields(&self) -> Vec<&'static str> {
        measurands::of(self)
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        conclude::conclude(self, cases, points, axes)
    }
}
