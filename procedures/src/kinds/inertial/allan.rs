//! Kind `allan`: noise of the gyros at standstill, and the least count of the encoders.

use crate::axis::Axes;
use crate::case::Case;
use crate::device::DeviceRole;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand, experiment};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod creep;
mod keys;
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

const MEASURANDS: &[Measurand] = &[
    Measurand { name: WALK, kind: Q::AngleRandomWalk, doc: "Angle random walk N of a gyro (IEEE Std 952)." },
    Measurand {
        name: INSTABILITY,
        kind: Q::AngularVelocity,
        doc: "Bias instability B of a gyro; its Allan deviation is 0.664 B where it is flat.",
    },
    Measurand { name: RATE_WALK, kind: Q::RateRandomWalk, doc: "Rate random walk K of a gyro." },
    Measurand {
        name: BIAS,
        kind: Q::AngularVelocity,
        doc: "Mean rate of a gyro at standstill less that of the Earth (needs `latitude`).",
    },
    Measurand {
        name: RESOLUTION,
        kind: Q::Angle,
        doc: "Least step of the encoder's position that is seen in a slow creep.",
    },
    Measurand { name: BITS, kind: Q::Count, doc: "Binary logarithm of a full turn over that step." },
];

pub(in crate::kinds) const KIND: Kind = Kind {
    name: "allan",
    doc: include_str!("allan/doc.md"),
    fields: keys::FIELDS,
    measurands: MEASURANDS,
    read: |table| experiment(Keys::read(table)),
};

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
        let mut all = vec![WALK, INSTABILITY, RATE_WALK];
        if self.latitude_rad.is_some() {
            all.push(BIAS);
        }
        if !self.creep.is_empty() {
            all.extend([RESOLUTION, BITS]);
        }
        all
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
