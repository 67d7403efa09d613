//! What a unit with given settings shows of a measurand.

use sim_devices::unit::{AxisSettings, StructureSettings, UnitSettings};

use super::{Finding, Setup};

pub(super) mod drivetrain;
pub(super) mod inertial;
pub(super) mod mirror;

/// A finding, and the settings that it is to be explained by.
#[derive(Clone, Copy)]
pub(super) struct Shown<'a> {
    pub(super) finding: &'a Finding<'a>,
    pub(super) unit: &'a UnitSettings,
    pub(super) setup: &'a Setup,
}

impl Shown<'_> {
    /// 0 azimuth, 1 elevation.
    pub(super) fn place(&self) -> Option<usize> {
        self.finding.axis
    }

    /// The axis of the finding.
    pub(super) fn axis(&self) -> Option<&AxisSettings> {
        Some(self.unit.axis(self.place()?))
    }

    /// The structure behind the axis of the finding.
    fn structure(&self) -> Option<&StructureSettings> {
        Some([&self.unit.az_structure, &self.unit.el_structure][self.place()?])
    }

    fn condition(&self, name: &str) -> Option<f64> {
        self.finding.condition(name)
    }

    /// A magnitude, where noise alone does not explain what was found.
    pub(super) fn above_noise(&self, shown: f64) -> Option<f64> {
        self.finding.is_above_noise().then_some(shown)
    }
}
