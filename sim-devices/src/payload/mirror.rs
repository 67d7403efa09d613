//! The mirror on the gimbal behind one of the controllers that there are.

use std::time::Duration;

use crate::mirror::{GcsMirror, Mirror};
use crate::physics::noise::SeedAddress;
use crate::unit::UnitSettings;

/// Controller of the mirror. Both have the same servo, actuators and mechanism.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum MirrorType {
    /// CEDRAT CCBu40, on its serial line.
    #[default]
    Ccbu40,
    /// A controller that speaks PI's GCS 2.0.
    Gcs {
        /// Bit rate of its line, bit/s.
        bit_rate_hz: f64,
    },
}

/// The mirror unit.
#[derive(Debug)]
pub(crate) enum MirrorUnit {
    Ccbu40(Box<Mirror>),
    Gcs(Box<GcsMirror>),
}

impl MirrorUnit {
    /// At rest in mid-stroke.
    pub(super) fn new(mirror_type: MirrorType, unit: &UnitSettings, address: &SeedAddress) -> Self {
        let step_s = 1.0 / unit.step_rate_hz;
        match mirror_type {
            MirrorType::Ccbu40 => Self::Ccbu40(Box::new(Mirror::new(&unit.mirror, address, step_s))),
            MirrorType::Gcs { bit_rate_hz } => {
                let controller = GcsMirror::new(&unit.mirror, address, step_s).with_bit_rate(bit_rate_hz);
                Self::Gcs(Box::new(controller))
            }
        }
    }

    /// One step of servo and mechanism.
    #[inline]
    pub(super) fn step(&mut self, step: u64) {
        match self {
            Self::Ccbu40(mirror) => mirror.step(step),
            Self::Gcs(controller) => controller.step(step),
        }
    }

    /// Servo and mechanism.
    pub(crate) fn mirror(&self) -> &Mirror {
        match self {
            Self::Ccbu40(mirror) => mirror,
            Self::Gcs(controller) => controller.mirror(),
        }
    }

    /// Voltage at the analog input of an axis, from now on.
    pub(crate) fn command_analog_v(&mut self, axis: usize, volts: f64) {
        match self {
            Self::Ccbu40(mirror) => mirror.command_analog_v(axis, volts),
            Self::Gcs(controller) => controller.command_analog_v(axis, volts),
        }
    }

    /// Bytes that have arrived at the host by `now`.
    pub(crate) fn read(&mut self, now: Duration, into: &mut [u8]) -> usize {
        match self {
            Self::Ccbu40(mirror) => mirror.take_reply(into),
            Self::Gcs(controller) => controller.read(now, into),
        }
    }

    /// Bytes from the host.
    pub(crate) fn write(&mut self, now: Duration, bytes: &[u8]) {
        match self {
            Self::Ccbu40(mirror) => bytes.iter().for_each(|&byte| mirror.receive(byte)),
            Self::Gcs(controller) => controller.write(now, bytes),
        }
    }
}
