//! Kind `self-check`: every channel of the bench while nothing moves, before and after the unit.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, experiment};
use crate::log::Window;
use crate::measurement::PointResult;

mod channels;
mod keys;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

pub(in crate::kinds) const KIND: Kind = Kind {
    name: crate::drift::KIND,
    doc: include_str!("self_check/doc.md"),
    fields: keys::FIELDS,
    measurands: channels::MEASURANDS,
    read: |table| experiment(Keys::read(table)),
};

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
        channels::MEASURANDS.iter().map(|m| m.name).collect()
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        keys::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }
}
