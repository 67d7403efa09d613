//! Kind `model-check`: a run at constant velocity, both ways, against a declared model of friction and loads.

use super::{Experiment, Kind, Measurand};
use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, TableReader};

mod keys;
mod model;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

/// See [`DOC`].
pub(super) struct ModelCheck;

const DOC: &str = include_str!("model_check/doc.md");

const MEAN: &str = "model-error-mean";
const RMS: &str = "model-error-rms";

const MEASURANDS: &[Measurand] = &[
    Measurand {
        name: MEAN,
        kind: Q::Torque,
        doc: "Mean over whole cogging periods of motor torque less inertia less model, in one direction.",
    },
    Measurand {
        name: RMS,
        kind: Q::Torque,
        doc: "Root mean square over angle of the same, cogging included.",
    },
];

impl Kind for ModelCheck {
    fn name(&self) -> &'static str {
        "model-check"
    }

    fn doc(&self) -> &'static str {
        DOC
    }

    fn fields(&self) -> &'static [Field] {
        keys::FIELDS
    }

    fn measurands(&self) -> &'static [Measurand] {
        MEASURANDS
    }

    fn read(&self, table: &mut TableReader<'_>) -> Option<Box<dyn Experiment>> {
        Keys::read(table).map(|keys| Box::new(keys) as Box<dyn Experiment>)
    }
}

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
        MEASURANDS.iter().map(|m| m.name).collect()
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        self.strokes.plan(axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }

    fn conclude(&self, _cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
        Conclusion {
            measurements: points.iter().flat_map(|p| p.measurements.clone()).collect(),
            plots: points.iter().flat_map(|p| p.plots.clone()).collect(),
            ..Conclusion::default()
        }
    }
}
