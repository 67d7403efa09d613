//! Simulated worlds in virtual time: every session has one of its own, for one point.

use controllers::DirectorGains;
use drivers::device::DeviceError;
use sim_devices::rig::SimulatedRig;

use super::simulated::Units;
use super::{BusGrounds, Opened, OpenedPorts, Purpose, Site};
use crate::clock::Clock;
use crate::model::rig::Rig;
use crate::rig::OpenRig;
use crate::rig::wires::Wires;
use crate::site::unit::Unit;

/// The site of the virtual tier.
pub struct VirtualSite<'a> {
    units: Units<'a>,
    wires: fn(&SimulatedRig) -> Wires,
}

impl<'a> VirtualSite<'a> {
    /// A site with this unit. `built` is the unit in the build state of each stage, `None` where that is the final one.
    pub fn new(unit: &'a Unit, built: &'a [Option<Unit>]) -> Self {
        Self { units: Units { unit, built }, wires: Wires::simulated }
    }

    /// The site with other wires between host and the devices of a director, for faults that no device has.
    #[must_use]
    pub fn with_wires(self, wires: fn(&SimulatedRig) -> Wires) -> Self {
        Self { wires, ..self }
    }
}

impl Site for VirtualSite<'_> {
    fn keeps_session(&self) -> bool {
        false
    }

    /// Every session starts from a declared state: at rest, bristles relaxed, heat sinks at ambient.
    fn open(&self, rig: &Rig, gains: &DirectorGains, purpose: &Purpose<'_>) -> Result<Opened, DeviceError> {
        let simulated = self.units.simulate(rig, purpose, self.wires)?;
        let bus = simulated.wires.bus.name().to_owned();
        let clock = Clock::Virtual;
        let rig = OpenRig::open(simulated.wires, rig, gains, &clock)?;
        Ok(Opened {
            bus,
            grounds: BusGrounds::in_process(),
            rig,
            clock,
            surroundings: simulated.surroundings,
        })
    }

    fn open_ports(&self, rig: &Rig, purpose: &Purpose<'_>) -> Result<OpenedPorts, DeviceError> {
        let ports = self.units.simulate(rig, purpose, self.wires)?.wires.ports;
        Ok(OpenedPorts { ports, clock: Clock::Virtual, lines: Vec::new() })
    }
}
