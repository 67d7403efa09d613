//! Kind `stop`: angle and time of stops against what was computed before.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod keys;
mod measure;
mod pictures;
mod plan;
#[cfg(test)]
mod tests;

use keys::Keys;

const DOC: &str = "\
# What it finds
For every stop `stop-angle` and `stop-time`, from its cause to standstill; `stop-angle-ratio` and `stop-time-ratio`, the
same over what was computed when it began (1 or less: the computed figures, on which plan and interlocks rely, are on the
safe side); `stop-room`, the remaining distance to the end of the travel. These are reported without a requirement.

# How it excites
Each of `manners` at `speed` in both directions, from the ends of `span`: *quick-stop*, the drive's own (605Ah, 6085h)
from a constant rate; *soft-limit*, a move past a soft limit of the point's own (`fence`), which the braking curve must
stop; *torque-off*, the torque switched off as by safe torque off, at `torque-off-speed`: elevation would coast through
more than its travel from full speed (safety.md §1). A plan that would coast into an end stop is refused. A brake, where
the rig declares one, engages when the torque is switched off.

# How it computes
The bench writes each stop into the log: where and how fast it began, in which manner, what was computed from the rig
file (reaction until the drive's watchdog, jerk-limited ramp, settling; without torque least friction and largest
loads), how far it went, when standstill was reached (0.05 deg/s). Angle from the encoder. The uncertainty of the angle is
the encoder's resolution and the angle turned in a tick (rectangular), because a stop begins at a tick; that of the time is
a tick. Without torque no time is computed.

# Fails when
The point did not complete; no stop of the axis is in the log, or one in another manner than ordered; it did not end at
standstill: inconclusive with reason.

# Source
safety.md §1, §2 (controlled stop, standstill), §4 (make_safe: computed stop + 3 s); director.md §2, §8.
";

const ANGLE: &str = "stop-angle";
const TIME: &str = "stop-time";
const ANGLE_RATIO: &str = "stop-angle-ratio";
const TIME_RATIO: &str = "stop-time-ratio";
const ROOM: &str = "stop-room";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(ANGLE, Q::Angle, "Angle from the cause of a stop to standstill."),
    Measurand::new(TIME, Q::Time, "Time from the cause of a stop to standstill."),
    Measurand::new(ANGLE_RATIO, Q::Ratio, "Angle of a stop over the computed angle."),
    Measurand::new(TIME_RATIO, Q::Ratio, "Time of a stop over the computed time."),
    Measurand::new(ROOM, Q::Angle, "Smallest distance to the end of the travel during a stop."),
];

pub(in crate::kinds) const KIND: Kind = Kind::new::<Keys>("stop", DOC, keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        measure::analyse(case, window, axes)
    }

    fn conclude(&self, _cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
        Conclusion { plots: pictures::pictures(points), ..Conclusion::collected(points) }
    }
}
