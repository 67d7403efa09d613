//! A director that does not exist, at the speed of the day: one world, one session, real time. Everything of real hardware
//! but its wires, for rehearsals with people.

use controllers::DirectorGains;
use drivers::device::DeviceError;
use procedures::case::Case;
use sim_devices::rig::{SeedAddress, SimulatedRig};
use sim_devices::unit::UnitSettings;

use super::{Contact, Opened, Purpose, Site, Surroundings, sim_unit_for_case, start_state, world_names};
use crate::clock::Clock;
use crate::files::unit::Unit;
use crate::model::rig::Rig;
use crate::rig::OpenRig;
use crate::rig::wires::Wires;

/// The site of the paced tier.
pub struct PacedSite<'a> {
    unit: &'a Unit,
    built: &'a [Option<Unit>],
    wires: fn(&SimulatedRig) -> Wires,
}

impl<'a> PacedSite<'a> {
    /// A site with this unit. `built` is the unit in the build state of each stage, `None` where that is the final one.
    pub fn new(unit: &'a Unit, built: &'a [Option<Unit>]) -> Self {
        Self { unit, built, wires: Wires::simulated }
    }

    /// The same site with other wires between host and devices, for faults that no device has.
    #[must_use]
    pub fn with_wires(self, wires: fn(&SimulatedRig) -> Wires) -> Self {
        Self { wires, ..self }
    }
}

impl Site for PacedSite<'_> {
    fn keeps_session(&self) -> bool {
        true
    }

    /// A world at rest whose time begins now, and passes by itself.
    fn open(&self, rig: &Rig, gains: &DirectorGains, purpose: &Purpose<'_>) -> Result<Opened, DeviceError> {
        let unit = purpose.stage.and_then(|stage| self.built.get(stage)?.as_ref()).unwrap_or(self.unit);
        let procedure = purpose.procedure.to_owned();
        let address = SeedAddress { seed: purpose.seed, procedure, point: String::new() };
        let axes = world_names(rig);
        let start = start_state(&axes, purpose, self.unit.settings.az.ambient_degc);
        let simulated = SimulatedRig::at_rate(&unit.settings, &address, start, rig.loop_rate_hz);
        let (wires, clock) = ((self.wires)(&simulated), Clock::real());
        let bus = wires.bus.name().to_owned();
        let open = OpenRig::open(wires, rig, gains, &clock)?;
        let (unit, rig) = (unit.settings.clone(), rig.clone());
        let surroundings = Box::new(Around { simulated, unit, rig, axes, address });
        Ok(Opened { bus, rig: open, clock, surroundings })
    }
}

/// What is around a running simulated rig.
struct Around {
    simulated: SimulatedRig,
    unit: UnitSettings,
    rig: Rig,
    /// What the rig calls azimuth and elevation of the world.
    axes: [Option<String>; 2],
    address: SeedAddress,
}

impl Surroundings for Around {
    fn bring(&mut self, case: &Case) {
        let address = SeedAddress { point: case.point.clone(), ..self.address.clone() };
        self.simulated.bring(&sim_unit_for_case(&self.unit, case, &self.rig), &address);
    }

    fn contacts(&self) -> Vec<Contact> {
        super::contacts(&self.simulated, &self.axes)
    }
}
