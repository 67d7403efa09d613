//! Kind `polarity`: signs and scales of every path from torque to sensor, before any loop is closed.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod conclude;
mod plan;
mod record;
#[cfg(test)]
mod tests;

use plan::Keys;

const DOC: &str = "\
# What it finds
Whether a positive torque turns each axis the positive way, whether encoder and gyros agree on sign, axis and angle, and
whether torque is scaled correctly: `presliding-ratio`, `gyro-encoder-ratio`, `gyro-cross-ratio`, `torque-scale-ratio`
with `small-motion-inertia`. A fault of any of them is positive feedback in a closed loop, so the procedure is the first
motion of a campaign and the proof named `polarity` the gate of every loop. Each fault is one sentence: the path, the
likely cause, what was expected and what was found.

# How it excites
Torque without feedback, every axis of the rig, at poses at least 30 deg from the soft limits where friction holds the
load. *Pulses* first, on all axes: ± 0.2 of the expected static friction, ramped up, held, ramped down, then three sines
(2.25, 3.75 and 5.25 Hz) of 0.08 together. The contact stays in presliding and springs back; one that bears a load sags.
Beyond 2.5 z_ss (static friction over bristle stiffness: 0.33 / 0.12 deg) or 0.5 deg/s the point trips, the torque is
switched off, and nothing else is run. Then *ramps*: torque grows until the axis has moved by 1.5 z_ss, then it is switched off; friction brakes.
They trip beyond 0.45 deg or 5 z_ss, and 0.9 deg/s: if a sensor shows only half of the motion, the axis still stays below
1 deg and 2 deg/s.

# How it computes
*Pulses*: slope of angle over torque, times the expected bristle stiffness: 1, with the sign of the path. Rates of the
three gyros, turned by the mounting angle of 45 deg into left, up and along the line of sight, over means of 50 ms against
the difference of the encoder, with an offset that removes bias and Earth rate. An azimuth that turns positively shows (0,
cos el, sin el), an elevation (-1, 0, 0); the length is the gyro-encoder ratio whatever the elevation is, the direction
shows sign and axis. Elevation is taken from the pose of the plan, not from its encoder, which is under test.
*Sines*: a contact that does not break away is a spring with a damper, so T = (k + jω·b - J/s·ω²)·X on each line and only
the inertia grows with ω²; s is the torque scale, whatever friction is. The lines between the sines are fitted with them,
because a contact that bears a load moves the axis there, too. Flexible modes make the axis appear up to 4.5 % heavier, a
load up to 1 %, an angle that is up to 2 ms late b·2 ms: half of each is subtracted and is also the half-width of the
remaining uncertainty. J/s is `small-motion-inertia`: the judge compares it with what frequency responses of the sliding axis
show (`apparent-inertia`), by its own uncertainty. Play of a microradian counts in such small motions, and the gyros do not have it: what
J/s is by the gyros differs by is a half-width of its uncertainty (6 % to 10 % of elevation, whose frame bends between motor and gyros).
*At rest*: every encoder against the pose of the plan, to which the operator brought the axis by its own scale, within
`zero-tolerance` of the rig: that proves the zero that travel, soft limits and braking curve are computed from. Where a
gate refuses all motion because an encoder shows an angle outside the travel, that reading alone identifies the likely
fault. Torque against encoder and gyro, which agree: torque sign. Encoder against both others: encoder sign. Gyro against
both others: gyro sign. Motion about the other axis: axes swapped. Displacement beyond 1/4 … 4 of what is expected, or
torque beyond 0.8 … 1.2 by more than its expanded uncertainty, with that of the torque constant: torque scale, unless the
angle that the gyros turned through gives a scale that is right: then the encoder is wrong over small motions.
Gyro-encoder ratio beyond 2 %: counts per turn.

# Fails when
A point trips; an axis does not move at all; the gyros are silent; a point was not run. Too little motion up to the torque
limit of this check is not a fault; it is reported as a remark.

# Source
safety.md §2, layer 3; director.md §6 (mounting), §3 (bristles).
";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        "presliding-ratio",
        Q::Ratio,
        "Displacement by a small torque relative to torque over expected bristle stiffness; negative if it \
         opposes the torque.",
    ),
    Measurand::new(
        "gyro-encoder-ratio",
        Q::Ratio,
        "Angle by the gyros over angle by the encoder; negative where they contradict each other.",
    ),
    Measurand::new(
        "gyro-cross-ratio",
        Q::Ratio,
        "Share of the motion of an axis that the gyros see about the other axis.",
    ),
    Measurand::new(
        "torque-scale-ratio",
        Q::Ratio,
        "Accelerating torque, by the inertia in the rig file, over the torque that the drive reports.",
    ),
    Measurand::new(
        conclude::SMALL_MOTION_INERTIA,
        Q::Inertia,
        "Inertia of the axis from its response to a small periodic torque, based on the torque constant of \
         the rig file.",
    ),
];

pub(in crate::kinds) const KIND: Kind = Kind::new::<Keys>("polarity", DOC, plan::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        record::analyse(case, window, axes)
    }

    fn reads_broken_off(&self) -> bool {
        true
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        conclude::conclude(cases, points, axes)
    }
}
