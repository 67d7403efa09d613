//! Kind `slew`: moves at the limits of an axis; acceleration, velocity, and how they end.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned::{self, Named};
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod motion;
mod plan;
mod point;
#[cfg(test)]
mod tests;

use plan::{Keys, Moves};

const ACCELERATION: &str = "slew-acceleration";
const DECELERATION: &str = "slew-deceleration";
const PEAK_ACCELERATION: &str = "slew-peak-acceleration";
const VELOCITY: &str = "slew-velocity";
const PEAK_VELOCITY: &str = "slew-peak-velocity";
const FULL_OVERSHOOT: &str = "slew-overshoot";
const FULL_SETTLING: &str = "slew-settling-time";
const OVERSHOOT: &str = "cue-overshoot";
const EXCESS: &str = "cue-overshoot-excess";
const SETTLING: &str = "cue-settling-time";

/// What moves at full acceleration yield.
const OF_FULL: [Named; 5] = [
    (ACCELERATION, Q::AngularAcceleration),
    (DECELERATION, Q::AngularAcceleration),
    (PEAK_ACCELERATION, Q::AngularAcceleration),
    (FULL_OVERSHOOT, Q::Angle),
    (FULL_SETTLING, Q::Time),
];
/// What slews to cues yield.
const OF_CUES: [Named; 3] = [(OVERSHOOT, Q::Angle), (EXCESS, Q::Angle), (SETTLING, Q::Time)];
/// What moves at the gentlest acceleration yield.
const OF_GENTLE: [Named; 2] = [(VELOCITY, Q::AngularVelocity), (PEAK_VELOCITY, Q::AngularVelocity)];

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        ACCELERATION,
        Q::AngularAcceleration,
        "Sustained acceleration: mean while the planned acceleration is constant, in the worst move.",
    ),
    Measurand::new(
        DECELERATION,
        Q::AngularAcceleration,
        "Sustained deceleration: mean while the planned deceleration is constant, in the worst move, as a \
         magnitude; friction helps.",
    ),
    Measurand::new(PEAK_ACCELERATION, Q::AngularAcceleration, "Largest mean over 0.1 s, a magnitude."),
    Measurand::new(
        VELOCITY,
        Q::AngularVelocity,
        "Sustained velocity: mean over the cruise, in the worst move.",
    ),
    Measurand::new(PEAK_VELOCITY, Q::AngularVelocity, "Largest mean over 0.1 s, a magnitude."),
    Measurand::new(
        FULL_OVERSHOOT,
        Q::Angle,
        "Largest overshoot beyond the final position at the end of a full move.",
    ),
    Measurand::new(
        FULL_SETTLING,
        Q::Time,
        "Time from the planned end of a full move until the axis stays within 75 urad.",
    ),
    Measurand::new(
        OVERSHOOT,
        Q::Angle,
        "Largest overshoot beyond the final position at the end of a move, averaged over repeats.",
    ),
    Measurand::new(
        EXCESS,
        Q::Angle,
        "Overshoot less the larger of 3 sigma of the noise and 3 urad; a value above 0 counts as overshoot.",
    ),
    Measurand::new(
        SETTLING,
        Q::Time,
        "Time from the planned end of a move until the axis stays within 75 urad of its final position.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("slew", include_str!("slew/doc.md"), plan::FIELDS, MEASURANDS);

impl Keys {
    fn named(&self) -> &'static [Named] {
        match self.moves {
            Moves::Full => &OF_FULL,
            Moves::Cue => &OF_CUES,
            Moves::Gentle => &OF_GENTLE,
        }
    }
}

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        Some(self.named().iter().map(|(name, _)| *name).collect())
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        let found = point::analyse(self, case, window, axes);
        found.unwrap_or_else(|reason| positioned::without(case, self.named(), point::ESTIMATOR, &reason))
    }

    /// A motor that is too weak falls behind until an interlock stops the axis: what it reached until then is the answer.
    fn reads_broken_off(&self) -> bool {
        true
    }
}
