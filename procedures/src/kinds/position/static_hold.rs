//! Kind `static-hold`: an axis at rest, held by its loop, without torque, and with its drive off.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
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
    Measurand::new(
        NOISE,
        Q::Angle,
        "Standard deviation of the position of an axis held by its loop, with drift removed.",
    ),
    Measurand::new(DRIFT, Q::AngularVelocity, "Drift of the position of an axis held by its loop."),
    Measurand::new(TORQUE, Q::Torque, "Mean motor torque that holds the axis."),
    Measurand::new(
        TORQUE_NOISE,
        Q::Torque,
        "Standard deviation of the motor torque of an axis held by its loop: the noise floor of the torque.",
    ),
    Measurand::new(
        MOVEMENT,
        Q::Angle,
        "Largest movement of an axis from rest after its torque is switched off.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("static-hold", include_str!("static_hold/doc.md"), keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let held = if self.held_rad.is_empty() { &[][..] } else { &[NOISE, DRIFT, TORQUE, TORQUE_NOISE][..] };
        let lets_go = !(self.released_rad.is_empty() && self.off_rad.is_empty());
        Some(held.iter().copied().chain(lets_go.then_some(MOVEMENT)).collect())
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
