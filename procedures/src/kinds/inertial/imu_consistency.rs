//! Kind `imu-consistency`: what the gyros show while one axis turns, against its encoder.

use crate::axis::Axes;
use crate::case::Case;
use crate::device::DeviceRole;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod keys;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

const SCALE: &str = "gyro-scale-error";
const MAPPING: &str = "gyro-mapping-error";
const DELAY: &str = "gyro-encoder-delay";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(SCALE, Q::Ratio, "Size of the rate that the gyros show over that of the encoder, less 1."),
    Measurand::new(
        MAPPING,
        Q::Angle,
        "Angle between the axis that the gyros show and the one that the mount of 45 deg says: 180 deg for a wrong sign.",
    ),
    Measurand::new(
        DELAY,
        Q::Time,
        "How much later the log has a motion from the gyros than from the encoder.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("imu-consistency", include_str!("imu_consistency/doc.md"), keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn needs(&self) -> Vec<DeviceRole> {
        vec![DeviceRole::InertialUnit]
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        keys::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(case, window, axes)
    }
}
