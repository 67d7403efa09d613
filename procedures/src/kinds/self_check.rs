//! Kind `self-check`: every channel of the bench while nothing moves, before and after the unit.

use super::{Experiment, Kind, Measurand};
use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::table::{Field, TableReader};

mod channels;
mod keys;
mod plan;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

/// See [`DOC`].
pub(super) struct SelfCheck;

const DOC: &str = include_str!("self_check/doc.md");

impl Kind for SelfCheck {
    fn name(&self) -> &'static str {
        crate::drift::KIND
    }

    fn doc(&self) -> &'static str {
        DOC
    }

    fn fields(&self) -> &'static [Field] {
        keys::FIELDS
    }

    fn measurands(&self) -> &'static [Measurand] {
        channels::MEASURANDS
    }

    fn read(&self, table: &mut TableReader<'_>) -> Option<Box<dyn Experiment>> {
        Keys::read(table).map(|keys| Box::new(keys) as Box<dyn Experiment>)
    }
}

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
        channels::MEASURANDS.iter().map(|m| m.name).collect()
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }

    fn conclude(&self, _cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
        Conclusion {
            measurements: points.iter().flat_map(|p| p.measurements.clone()).collect(),
            ..Conclusion::default()
        }
    }
}
