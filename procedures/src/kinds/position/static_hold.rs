//! Kind `static-hold`: an axis at rest, held by its loop, without torque, and with its drive off.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand, experiment};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod held;
mod keys;
mod plan;
mod released;
#[cfg(test)]
mod tests;

use keys::Keys;
use plan::Way;

const NOISE: &str = "position-noise";
const DRIFT: &str = "drift-rate";
const TORQUE: &str = "holding-torque";
const TORQUE_NOISE: &str = "torque-noise";
const MOVEMENT: &str = "self-hold-movement";

const ESTIMATOR: &str = "static-hold/1";

const MEASURANDS: &[Measurand] = &[
    Measurand {
        name: NOISE,
        kind: Q::Angle,
        doc: "Standard deviation of the position of an axis that its loop holds, drift taken off.",
    },
    Measurand {
        name: DRIFT,
        kind: Q::AngularVelocity,
        doc: "Drift of the position of an axis that its loop holds.",
    },
    Measurand { name: TORQUE, kind: Q::Torque, doc: "Mean motor torque that holds the axis." },
    Measurand {
        name: TORQUE_NOISE,
        kind: Q::Torque,
        doc: "Standard deviation of the motor torque of an axis that its loop holds: its noise floor.",
    },
    Measurand {
        name: MOVEMENT,
        kind: Q::Angle,
        doc: "Largest movement of an axis from rest after its torque is taken away.",
    },
];

pub(in crate::kinds) const KIND: Kind = Kind {
    name: "static-hold",
    doc: include_str!("static_hold/doc.md"),
    fields: keys::FIELDS,
    measurands: MEASURANDS,
    read: |table| experiment(Keys::read(table)),
};

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
        let held = if self.held_rad.is_empty() { &[][..] } else { &[NOISE, DRIFT, TORQUE, TORQUE_NOISE][..] };
        let lets_go = !(self.released_rad.is_empty() && self.off_rad.is_empty());
        held.iter().copied().chain(lets_go.then_some(MOVEMENT)).collect()
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        match Way::of(case) {
            Way::Held => held::analyse(case, window, axes),
            Way::Released | Way::Off => released::analyse(self, case, window, axes),
        }
    }
}
