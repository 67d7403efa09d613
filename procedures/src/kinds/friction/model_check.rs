//! Kind `model-check`: a run at constant velocity, both ways, against a declared model of friction and loads.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod keys;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

const MEAN: &str = "model-error-mean";
const RMS: &str = "model-error-rms";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        MEAN,
        Q::Torque,
        "Mean over whole cogging periods of motor torque less inertia less model, in one direction.",
    ),
    Measurand::new(
        RMS,
        Q::Torque,
        "Root mean square over angle of motor torque less inertia less model, cogging included.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("model-check", include_str!("model_check/doc.md"), keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        self.strokes.plan(axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }
}
