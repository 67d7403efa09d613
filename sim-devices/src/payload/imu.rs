//! The inertial unit on the gimbal: one of the makes that there are.

use std::time::Duration;

use crate::kvh::Kvh;
use crate::motion::Motion;
use crate::physics::noise::SeedAddress;
use crate::stim300::{self, Stim300, Stim300Setup};
use crate::unit::{ImuSettings, UnitSettings};

/// Make of the inertial unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ImuType {
    /// KVH 1775 with the errors that the unit file gives.
    #[default]
    Kvh1775,
    /// STIM300 with this configuration in its flash. Noise, delay and bias are those of the type; mount, scale, sign and planted
    /// errors are those of the unit file.
    Stim300(Stim300Setup),
}

impl ImuType {
    /// The unit's errors with those that belong to the make.
    fn settings(self, imu: &ImuSettings) -> ImuSettings {
        match self {
            Self::Kvh1775 => imu.clone(),
            Self::Stim300(_) => stim300::of_type(imu),
        }
    }
}

/// What the unit speaks, and what makes it measure.
#[derive(Debug)]
enum Make {
    /// The pulses of the exchanges.
    Kvh1775(Box<Kvh>),
    /// A clock of its own.
    Stim300 { unit: Box<Stim300>, samples_count: u64 },
}

/// An inertial unit of any make.
#[derive(Debug)]
pub(crate) struct Imu {
    make: Make,
    /// Age of a measured motion.
    delay_s: f64,
}

/// What rounding may take off a count of samples.
const ROUNDING_SAMPLES: f64 = 1e-6;

impl Imu {
    /// The unit at the start of a point; `pulse_rate_hz` synchronises one that follows the exchanges.
    pub(super) fn new(
        imu_type: ImuType,
        unit: &UnitSettings,
        address: &SeedAddress,
        pulse_rate_hz: f64,
    ) -> Self {
        let settings = imu_type.settings(&unit.imu);
        let make = match imu_type {
            ImuType::Kvh1775 => {
                Make::Kvh1775(Box::new(Kvh::new(&settings, address, pulse_rate_hz).after(unit.planned_s)))
            }
            ImuType::Stim300(setup) => {
                let own = Stim300::new(&settings, setup, address, stim300::INTERNAL_RATE_HZ);
                let own = own.after(unit.planned_s);
                let own = if settings.startup_s > 0.0 { own.powered_up() } else { own };
                Make::Stim300 { unit: Box::new(own), samples_count: 0 }
            }
        };
        Self { make, delay_s: settings.delay_s }
    }

    /// Age of a measured motion.
    pub(super) fn delay_s(&self) -> f64 {
        self.delay_s
    }

    /// From the next pulse on, pulse 0 was at an instant other than 0 of the world. A unit with a clock of its own has no pulses.
    pub(super) fn set_phase(&mut self, phase_s: f64) {
        if let Make::Kvh1775(unit) = &mut self.make {
            unit.set_phase(phase_s);
        }
    }

    /// The synchronisation pulse of an exchange, number `tick`.
    pub(super) fn pulse(&mut self, tick: u64, motion: impl FnOnce() -> Motion) {
        if let Make::Kvh1775(unit) = &mut self.make {
            unit.pulse(tick, &motion());
        }
    }

    /// The world has come to `now_s`: a unit with a clock of its own takes the sample that is due.
    #[inline]
    pub(super) fn reach(&mut self, now_s: f64, motion: impl FnOnce() -> Motion) {
        if let Make::Stim300 { unit, samples_count } = &mut self.make {
            let due_count = (now_s * stim300::INTERNAL_RATE_HZ + ROUNDING_SAMPLES) as u64;
            if due_count > *samples_count {
                *samples_count = due_count;
                unit.pulse(due_count, &motion());
            }
        }
    }

    /// The unit sends no message any more.
    pub(crate) fn fall_silent(&mut self) {
        match &mut self.make {
            Make::Kvh1775(unit) => unit.fall_silent(),
            Make::Stim300 { unit, .. } => unit.fall_silent(),
        }
    }

    /// The unit goes on sending the rates and accelerations of its last message.
    pub(crate) fn freeze(&mut self) {
        match &mut self.make {
            Make::Kvh1775(unit) => unit.freeze(),
            Make::Stim300 { unit, .. } => unit.freeze(),
        }
    }

    /// The gyros read this much more from now on, rad/s.
    pub(crate) fn shift_gyros(&mut self, by_rad_per_s: f64) {
        match &mut self.make {
            Make::Kvh1775(unit) => unit.shift_gyros(by_rad_per_s),
            Make::Stim300 { unit, .. } => unit.shift_gyros(by_rad_per_s),
        }
    }

    /// Bytes that have arrived at the host by `now`.
    pub(crate) fn read(&mut self, now: Duration, into: &mut [u8]) -> usize {
        match &mut self.make {
            Make::Kvh1775(unit) => unit.read(now, into),
            Make::Stim300 { unit, .. } => unit.read(now, into),
        }
    }

    /// Bytes from the host.
    pub(crate) fn write(&mut self, now: Duration, bytes: &[u8]) {
        match &mut self.make {
            Make::Kvh1775(unit) => unit.write(now, bytes),
            Make::Stim300 { unit, .. } => unit.write(now, bytes),
        }
    }
}
