//! Kind `tracker-latency`: time from a motion to the tracker's message of it.

use crate::axis::Axes;
use crate::case::Case;
use crate::device::DeviceRole;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod keys;
mod plan;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

const LATENCY: &str = "tracker-latency";
const STAMP: &str = "tracker-stamp-error";
const JITTER: &str = "tracker-jitter";
const SCALE: &str = "tracker-scale-error";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        LATENCY,
        Q::Time,
        "Time from a motion to the message that shows it, without the wait for the next exposure.",
    ),
    Measurand::new(
        STAMP,
        Q::Time,
        "Stated time of an exposure less the time of the motion that it shows: the error of the message \
         delay in the rig file.",
    ),
    Measurand::new(JITTER, Q::Time, "Standard deviation of the age of messages on arrival."),
    Measurand::new(
        SCALE,
        Q::Ratio,
        "Motion of the line of sight by the coarse tracker over that by the encoder, less 1.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("tracker-latency", include_str!("tracker_latency/doc.md"), keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        // The fine tracker looks at the mirror: what it shows of it are the optical gains.
        let scale = (!self.is_fine).then_some(SCALE);
        Some([LATENCY, STAMP, JITTER].into_iter().chain(scale).collect())
    }

    fn needs(&self) -> Vec<DeviceRole> {
        let fine: &[DeviceRole] = &[DeviceRole::FineTracker, DeviceRole::Mirror];
        if self.is_fine { fine.to_vec() } else { vec![DeviceRole::CoarseTracker] }
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }

    fn conclude(&self, _cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
        Conclusion { proof: point::proof(self, points), ..Conclusion::collected(points) }
    }
}
