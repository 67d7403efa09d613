//! Kind `hysteresis`: strokes at constant velocity back and forth between the same limits.

use super::{Experiment, Kind};
use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::table::TableReader;

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

pub(super) const KIND: Kind = Kind {
    name: "hysteresis",
    doc: include_str!("hysteresis/doc.md"),
    fields: sweep::FIELDS,
    measurands: measurands::ALL,
    read,
};

fn read(table: &mut TableReader<'_>) -> Option<Box<dyn Experiment>> {
    Some(Box::new(Sweep::read(table)?))
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
