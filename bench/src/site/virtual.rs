//! A director that does not exist: every session has a world of its own, in virtual time.

use controllers::DirectorGains;
use drivers::device::DeviceError;
use procedures::case::Case;
use sim_devices::rig::{SeedAddress, SimulatedRig};

use super::{Contact, Opened, Purpose, Site, Surroundings, sim_unit_for_case, start_state, world_names};
use crate::clock::Clock;
use crate::files::unit::Unit;
use crate::model::rig::Rig;
use crate::rig::OpenRig;
use crate::rig::device::Ports;
use crate::rig::wires::Wires;

/// The site of the virtual tier.
pub struct VirtualSite<'a> {
    unit: &'a Unit,
    built: &'a [Option<Unit>],
    wires: fn(&SimulatedRig) -> Wires,
}

impl<'a> VirtualSite<'a> {
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

impl Site for VirtualSite<'_> {
    fn keeps_session(&self) -> bool {
        false
    }

    /// Every session starts from a declared state: at rest, bristles relaxed, heat sinks at ambient.
    fn open(&self, rig: &Rig, gains: &DirectorGains, purpose: &Purpose<'_>) -> Result<Opened, DeviceError> {
        let unit = purpose.stage.and_then(|stage| self.built.get(stage)?.as_ref()).unwrap_or(self.unit);
        let point = purpose.case.map_or(String::new(), |case| case.point.clone());
        let address = SeedAddress { seed: purpose.seed, procedure: purpose.procedure.to_owned(), point };
        let axes = world_names(rig);
        let start = start_state(&axes, purpose, self.unit.settings.az.ambient_degc);
        let simulated = match purpose.case {
            Some(case) => {
                let settings = sim_unit_for_case(&unit.settings, case, rig);
                SimulatedRig::at_rate(&settings, &address, start, rig.loop_rate_hz)
            }
            None => SimulatedRig::at_rate(&unit.settings, &address, start, rig.loop_rate_hz),
        };
        let (wires, clock) = ((self.wires)(&simulated), Clock::Virtual);
        let bus = wires.bus.name().to_owned();
        let rig = OpenRig::open(wires, rig, gains, &clock)?;
        Ok(Opened { bus, rig, clock, surroundings: Box::new(Around { simulated, axes }) })
    }
}

/// What is around a simulated rig that was made for one point.
struct Around {
    simulated: SimulatedRig,
    /// What the rig calls azimuth and elevation of the world.
    axes: [Option<String>; 2],
}

impl Surroundings for Around {
    /// The world was made with all that its point asks for.
    fn bring(&mut self, _case: &Case) {}

    fn contacts(&self) -> Vec<Contact> {
        super::contacts(&self.simulated, &self.axes)
    }
}

impl Wires {
    /// The wires of a simulated rig.
    pub fn simulated(rig: &SimulatedRig) -> Self {
        Self {
            bus: rig.bus(),
            ports: Ports::default()
                .with_line("sim:imu", rig.imu_line())
                .with_line("sim:mirror", rig.mirror_line())
                .with_line("sim:analyser", rig.analyser_line())
                .with_line("sim:scope", rig.scope_line())
                .with_card("sim:analog", rig.analog_card())
                .with_socket("sim:coarse", rig.coarse_port())
                .with_socket("sim:fine", rig.fine_port()),
        }
    }
}
