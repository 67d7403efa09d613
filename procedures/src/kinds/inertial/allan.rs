//! Kind `allan`: noise of the gyros at standstill, and the least count of the encoders.

use crate::axis::Axes;
use crate::case::Case;
use crate::device::DeviceRole;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod creep;
mod keys;
mod step;
mod still;
#[cfg(test)]
pub(in crate::kinds) mod tests;

use keys::Keys;

const WALK: &str = "angle-random-walk";
const INSTABILITY: &str = "bias-instability";
const RATE_WALK: &str = "rate-random-walk";
const BIAS: &str = "gyro-bias";
const RESOLUTION: &str = "encoder-resolution";
const BITS: &str = "encoder-bits";
const PEAK: &str = "gyro-peak-ratio";
const STEP: &str = "gyro-step";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(WALK, Q::AngleRandomWalk, "Angle random walk N of a gyro (IEEE Std 952)."),
    Measurand::new(
        INSTABILITY,
        Q::AngularVelocity,
        "Bias instability B of a gyro; the flat part of the Allan deviation lies at 0.664 B.",
    ),
    Measurand::new(RATE_WALK, Q::RateRandomWalk, "Rate random walk K of a gyro."),
    Measurand::new(
        BIAS,
        Q::AngularVelocity,
        "Mean rate of a gyro at standstill less that of the Earth (needs `latitude`).",
    ),
    Measurand::new(RESOLUTION, Q::Angle, "Smallest step of the encoder's position during a slow creep."),
    Measurand::new(BITS, Q::Count, "Binary logarithm of a full turn over the smallest step of the encoder."),
    Measurand::new(
        PEAK,
        Q::Ratio,
        "Largest departure of a gyro's rate at standstill from its median, over the standard deviation of its noise.",
    ),
    Measurand::new(
        STEP,
        Q::AngularVelocity,
        "Step in which a gyro puts out its rate, from its samples at standstill.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("allan", include_str!("allan/doc.md"), keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let mut all = vec![WALK, INSTABILITY, RATE_WALK, PEAK, STEP];
        if self.latitude_rad.is_some() {
            all.push(BIAS);
        }
        if !self.creep.is_empty() {
            all.extend([RESOLUTION, BITS]);
        }
        Some(all)
    }

    fn needs(&self) -> Vec<DeviceRole> {
        vec![DeviceRole::InertialUnit]
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        keys::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        if keys::is_creep(case) {
            creep::analyse(case, window, axes)
        } else {
            still::analyse(self, case, window, axes)
        }
    }
}
