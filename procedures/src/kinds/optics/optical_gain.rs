//! Kind `optical-gain`: how far the mirror must tilt for an angle of the line of sight, sign and size.

use crate::axis::Axes;
use crate::case::Case;
use crate::device::DeviceRole;
use crate::diagnostic::Diagnostic;
use crate::kinds::mirror;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod keys;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

const GAIN: &str = "optical-gain";
const DEPARTURE: &str = "optical-gain-departure";
const COUPLING: &str = "optical-cross-coupling";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        GAIN,
        Q::Ratio,
        "Mirror angle per angle of the line of sight; negative where the line of sight moves the other way.",
    ),
    Measurand::new(
        DEPARTURE,
        Q::Ratio,
        "Optical gain over the gain that the fine loop assumes, less 1; -200 % for a wrong sign.",
    ),
    Measurand::new(
        COUPLING,
        Q::Ratio,
        "Motion seen by the tracker in the other axis over that in the axis in which the mirror moves.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("optical-gain", include_str!("optical_gain/doc.md"), keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn needs(&self) -> Vec<DeviceRole> {
        vec![DeviceRole::FineTracker, DeviceRole::Mirror]
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        keys::plan(self, axis, axes)
    }

    fn notes(&self, _axis: &str, _axes: &Axes) -> Vec<String> {
        let rates: Vec<String> = self.frame_rates_hz.iter().map(|&hz| Q::Frequency.format(hz)).collect();
        vec![format!(
            "set the fine camera to {} for the points that name this rate; frames are counted, and a point \
             at another rate has no result",
            rates.join(" and ")
        )]
    }

    fn analyse(&self, case: &Case, window: &Window, _axes: &Axes) -> PointResult {
        point::analyse(self, case, window)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        let (proof, remarks) = point::proof(self, cases, points);
        let plots = point::pictures(self, cases, points);
        mirror::on_gimbal(Conclusion { plots, remarks, proof, ..Conclusion::collected(points) }, axes)
    }
}
