//! Kind `torque-constant`: friction by a force gauge on a lever arm, against friction by the motor's current.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod conclude;
mod keys;
mod plan;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

const CONSTANT: &str = "torque-constant";
const ERROR: &str = "torque-constant-error";
const PULLED: &str = "pulled-friction-torque";

const ESTIMATOR: &str = "torque-constant/2";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        CONSTANT,
        Q::TorqueConstant,
        "Torque constant K_t = T/i: friction by the force gauge over the current that overcomes the same friction.",
    ),
    Measurand::new(
        ERROR,
        Q::Ratio,
        "Measured torque constant over that of the rig file, less 1: the relative error of every torque of the run.",
    ),
    Measurand::new(
        PULLED,
        Q::Torque,
        "Friction torque by force gauge and lever arm, half the difference of both directions.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("torque-constant", include_str!("torque_constant/doc.md"), keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn notes(&self, axis: &str, _axes: &Axes) -> Vec<String> {
        vec![format!(
            "A person pulls axis {axis} at {} by {}, first towards increasing, then towards decreasing \
             angle, with a lever arm of {}; the drive has no torque meanwhile.",
            Q::AngularVelocity.format(self.velocity_rad_per_s),
            Q::Angle.format(self.way_rad),
            Q::Length.format(self.arm_m),
        )]
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        conclude::conclude(self, cases, points, axes)
    }
}
