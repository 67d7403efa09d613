//! Kind `self-check`: every channel of the bench while nothing moves, before and after the unit.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind};
use crate::log::Window;
use crate::measurement::PointResult;

mod channels;
mod keys;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

pub(in crate::kinds) const KIND: Kind = Kind::new::<Keys>(
    crate::drift::KIND,
    include_str!("self_check/doc.md"),
    keys::FIELDS,
    channels::MEASURANDS,
);

impl Experiment for Keys {
    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        keys::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }
}
