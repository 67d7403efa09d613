//! Kind `imu-consistency`: what the gyros show while one axis turns, against its encoder.

use crate::axis::Axes;
use crate::case::Case;
use crate::device::DeviceRole;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult, Reduced};
use crate::quantity::QuantityKind as Q;

mod coupling;
mod gravity;
mod keys;
mod point;
mod slow;
#[cfg(test)]
mod tests;

use keys::Keys;

const SCALE: &str = "gyro-scale-error";
const MAPPING: &str = "gyro-mapping-error";
const DELAY: &str = "gyro-encoder-delay";
const RIPPLE: &str = "encoder-pitch-error";
const ZERO: &str = "elevation-zero-error";
const GRAVITY: &str = "gravity-departure";
const BIAS: &str = "accelerometer-bias";
const PLAY: &str = "lost-motion";
const SLIP: &str = "encoder-slip";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(SCALE, Q::Ratio, "Magnitude of the gyros' rate over that of the encoder, less 1."),
    Measurand::new(
        MAPPING,
        Q::Angle,
        "Angle between the axis of rotation by the gyros and the one expected from the 45 deg mounting; \
         180 deg for a wrong sign.",
    ),
    Measurand::new(DELAY, Q::Time, "Delay of the gyros relative to the encoder in the log."),
    Measurand::new(
        RIPPLE,
        Q::Angle,
        "Largest error of an encoder within the pitches of its scale, zero to peak, measured with the gyros.",
    ),
    Measurand::new(
        ZERO,
        Q::Angle,
        "Elevation by the encoder less elevation by gravity, corrected for accelerometer biases; azimuth \
         must be level.",
    ),
    Measurand::new(
        GRAVITY,
        Q::Ratio,
        "Gravity measured by the accelerometers over its standard value, less 1.",
    ),
    Measurand::new(
        BIAS,
        Q::Acceleration,
        "Bias of the accelerometers upwards from the line of sight and along it, separated from gravity by \
         several elevations.",
    ),
    Measurand::new(
        PLAY,
        Q::Angle,
        "Lost motion: angle by the gyros through which the axis turns after a reversal before its encoder follows.",
    ),
    Measurand::new(
        SLIP,
        Q::Ratio,
        "Share of the travel towards larger angles, by the gyros, that the encoder misses; negative where \
         it misses travel the other way.",
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
        let mut result = match &self.slow {
            Some(slow) if slow::passes_pitches(case) => slow::analyse(slow, case, window, axes),
            _ => point::analyse(case, window, axes),
        };
        if let Ok(rest) = gravity::rest(case, window, axes) {
            result.reduced = Reduced::to(rest);
        }
        result
    }

    fn conclude(&self, _cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        let mut conclusion = Conclusion::collected(points);
        conclusion.measurements.extend(gravity::conclude(points, axes));
        conclusion
    }
}
