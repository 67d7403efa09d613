//! Kind `step`: small steps of the position command; rise, settling, overshoot.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned::{self, Named};
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod keys;
mod pictures;
mod plan;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

const DOC: &str = "\
Response of the position loop to small steps.

# What it finds
Rise time, settling time, final value and overshoot of the position, by elevation and height of the step.

# How it excites
The position command jumps up and down by the height, again and again, and the axis rests after each jump. Heights of 0.3 to
0.8 deg: below, friction decides; above, the torque saturates (2000 N*m per degree). A height is refused whose rate or
acceleration the rig does not allow, taking 5 1/s for the gain of the position loop and 4.5 Hz for the crossover of the
velocity loop.

# How it computes
The responses of a direction are averaged on the time since their step. Rise from 10 % to 90 % of the final value; settled
from where the response stays within 2 % of the height; final value is the mean of the last 0.5 s. Overshoot is the
largest excursion of the averaged response beyond its final value. Only the part counts that exceeds the larger of three
standard deviations of a single response at rest and 3 urad: `step-overshoot-excess` is the difference, 0 or less means
none. The worse direction is reported.

# Fails when
A response does not reach half of its height, is not settled when its last 0.5 s begin, or fewer than three of a direction
were recorded: inconclusive with the reason.

# Source
Study 4.5, table 4.3; POS-OVS (4.2).
";

const RISE: &str = "step-rise-time";
const SETTLING: &str = "step-settling-time";
const OVERSHOOT: &str = "step-overshoot";
const EXCESS: &str = "step-overshoot-excess";
const FINAL: &str = "step-final-value";

const ALL: [Named; 5] =
    [(RISE, Q::Time), (SETTLING, Q::Time), (OVERSHOOT, Q::Angle), (EXCESS, Q::Angle), (FINAL, Q::Ratio)];

const MEASURANDS: &[Measurand] = &[
    Measurand::new(RISE, Q::Time, "Rise time from 10 % to 90 % of the final value."),
    Measurand::new(
        SETTLING,
        Q::Time,
        "Time from the step until the response stays within 2 % of its final value.",
    ),
    Measurand::new(OVERSHOOT, Q::Angle, "Largest overshoot beyond the final value, averaged over repeats."),
    Measurand::new(
        EXCESS,
        Q::Angle,
        "Overshoot less the larger of 3 sigma of the noise and 3 urad; above 0 it is one.",
    ),
    Measurand::new(FINAL, Q::Ratio, "Final value over the height of the step."),
];

pub(in crate::kinds) const KIND: Kind = Kind::new::<Keys>("step", DOC, keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(case, window, axes)
            .unwrap_or_else(|reason| positioned::without(case, &ALL, point::ESTIMATOR, &reason))
    }
}
