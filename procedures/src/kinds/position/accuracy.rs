//! Kind `accuracy`: targets approached from both sides, again and again, against an external reference.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned::{self, Named};
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod plan;
mod point;
#[cfg(test)]
mod tests;
mod visits;

use plan::{Keys, Sequence};

const ACCURACY: &str = "positioning-accuracy";
const REPEATABILITY: &str = "positioning-repeatability";
const SYSTEMATIC: &str = "positioning-systematic-deviation";
const MEAN_RANGE: &str = "positioning-mean-deviation";
const REVERSAL: &str = "positioning-reversal";
const SERVO: &str = "servo-error";
const POSE_ACCURACY: &str = "pose-accuracy";
const POSE_REPEATABILITY: &str = "pose-repeatability";

/// What the sequence after ISO 230-2 yields, and what poses after ISO 9283 do.
const OF_TARGETS: [Named; 6] = [
    (ACCURACY, Q::Angle),
    (REPEATABILITY, Q::Angle),
    (SYSTEMATIC, Q::Angle),
    (MEAN_RANGE, Q::Angle),
    (REVERSAL, Q::Angle),
    (SERVO, Q::Angle),
];
const OF_POSES: [Named; 2] = [(POSE_ACCURACY, Q::Angle), (POSE_REPEATABILITY, Q::Angle)];

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        ACCURACY,
        Q::Angle,
        "Bidirectional accuracy A (ISO 230-2) against the external reference.",
    ),
    Measurand::new(
        REPEATABILITY,
        Q::Angle,
        "Bidirectional repeatability R (ISO 230-2), by the reference where there is one.",
    ),
    Measurand::new(
        SYSTEMATIC,
        Q::Angle,
        "Bidirectional systematic deviation E (ISO 230-2) against the external reference.",
    ),
    Measurand::new(
        MEAN_RANGE,
        Q::Angle,
        "Mean bidirectional deviation M (ISO 230-2) against the external reference.",
    ),
    Measurand::new(
        REVERSAL,
        Q::Angle,
        "Largest reversal value B (ISO 230-2), by the reference where there is one.",
    ),
    Measurand::new(
        SERVO,
        Q::Angle,
        "A of the encoder alone: how accurately the servo reaches its command, not where the axis really is.",
    ),
    Measurand::new(
        POSE_ACCURACY,
        Q::Angle,
        "Pose accuracy AP (ISO 9283) against the external reference, zeroed to the encoder in the first cycle.",
    ),
    Measurand::new(
        POSE_REPEATABILITY,
        Q::Angle,
        "Pose repeatability RP (ISO 9283), by the reference where there is one; the worst pose.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("accuracy", include_str!("accuracy/doc.md"), plan::FIELDS, MEASURANDS);

/// What a point yields.
fn named(case: &Case) -> &'static [Named] {
    match Sequence::of(case) {
        Sequence::Targets => &OF_TARGETS,
        Sequence::Poses => &OF_POSES,
    }
}

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let poses = OF_POSES.iter().filter(|_| self.poses_rad.is_some());
        Some(OF_TARGETS.iter().chain(poses).map(|(name, _)| *name).collect())
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn notes(&self, axis: &str, axes: &Axes) -> Vec<String> {
        let missing = axes.get(axis).is_some_and(|limits| limits.reference.is_none());
        let note = "reference instrument missing: accuracy stays inconclusive, because the encoder alone \
                    shows only the servo error";
        missing.then(|| note.to_owned()).into_iter().collect()
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        let found = point::analyse(self, case, window, axes);
        found.unwrap_or_else(|reason| positioned::without(case, named(case), point::ESTIMATOR, &reason))
    }
}
