//! Kind `atmosphere`: how much of the tip-tilt of the air the fine track loop takes away.

use crate::axis::Axes;
use crate::case::Case;
use crate::device::DeviceRole;
use crate::diagnostic::Diagnostic;
use crate::kinds::mirror;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod conclude;
mod keys;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

const REJECTION: &str = "tip-tilt-rejection";
const CROSSING: &str = "tip-tilt-crossing";
const AMPLIFICATION: &str = "tip-tilt-amplification";
const WITH_AND_WITHOUT: &str = "tip-tilt-with-and-without";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        REJECTION,
        Q::Decibel,
        "Residual of the tip-tilt at a frequency with the fine loop closed, in the line of sight.",
    ),
    Measurand::new(
        CROSSING,
        Q::Frequency,
        "Lowest frequency at which the fine loop does not reduce the tip-tilt (0 dB).",
    ),
    Measurand::new(
        AMPLIFICATION,
        Q::Decibel,
        "Largest amplification of the tip-tilt by the fine loop at any frequency.",
    ),
    Measurand::new(
        WITH_AND_WITHOUT,
        Q::Decibel,
        "Power of the readings with the fine loop closed over that with it open, in a band around a frequency.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("atmosphere", include_str!("atmosphere/doc.md"), keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn needs(&self) -> Vec<DeviceRole> {
        vec![DeviceRole::FineTracker, DeviceRole::Mirror]
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        keys::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, _axes: &Axes) -> PointResult {
        point::analyse(self, case, window)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        mirror::on_gimbal(conclude::conclude(self, cases, points), axes)
    }
}
