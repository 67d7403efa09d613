//! A director that does not exist: every session has a world of its own, in virtual time.

use controllers::DirectorGains;
use drivers::device::DeviceError;
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::world::AXIS_NAMES;

use super::unit_for_case::world_axis;
use super::{Contact, Purpose, Session, Site, Witness, sim_unit_for_case};
use crate::clock::Clock;
use crate::files::unit::Unit;
use crate::model::rig::Rig;
use crate::rig::OpenRig;
use crate::rig::device::Ports;
use crate::wires::{InstrumentWires, Wires};

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
    fn clock(&self) -> Clock {
        Clock::Virtual
    }

    /// Every session starts from a declared state: at rest, bristles relaxed, heat sinks at ambient.
    fn open(&self, rig: &Rig, gains: &DirectorGains, purpose: &Purpose<'_>) -> Result<Session, DeviceError> {
        let unit = purpose.stage.and_then(|stage| self.built.get(stage)?.as_ref()).unwrap_or(self.unit);
        let point = purpose.case.map_or(String::new(), |case| case.point.clone());
        let address = SeedAddress { seed: purpose.seed, procedure: purpose.procedure.to_owned(), point };
        let world = |index: usize| rig.axes.iter().find(|axis| world_axis(rig, &axis.name) == Some(index));
        let place = |index: usize| purpose.pose_rad.get(&world(index)?.name).copied();
        let [az_rad, el_rad] = [0, 1].map(|index| place(index).unwrap_or(0.0));
        let axes = [0, 1].map(|index| world(index).map(|axis| axis.name.clone()));
        let heat_sink_degc = self.unit.settings.az.ambient_degc;
        let start = StartState { az_rad, el_rad, heat_sink_degc };
        let simulated = match purpose.case {
            Some(case) => {
                let settings = sim_unit_for_case(&unit.settings, case, rig);
                SimulatedRig::at_rate(&settings, &address, start, rig.loop_rate_hz)
            }
            None => SimulatedRig::at_rate(&unit.settings, &address, start, rig.loop_rate_hz),
        };
        let wires = (self.wires)(&simulated);
        let bus = wires.bus.name().to_owned();
        let rig = OpenRig::open(wires, rig, gains, &self.clock())?;
        Ok(Session { bus, rig, witness: Box::new(Watched { simulated, axes }) })
    }
}

/// A simulated director, and what the rig calls its azimuth and its elevation.
struct Watched {
    simulated: SimulatedRig,
    axes: [Option<String>; 2],
}

impl Witness for Watched {
    fn contacts(&self) -> Vec<Contact> {
        let called = |own: String| {
            let index = AXIS_NAMES.iter().position(|name| *name == own);
            index.and_then(|index| self.axes[index].clone()).unwrap_or(own)
        };
        let crashes = self.simulated.record().crashes.into_iter();
        let contact = |(axis, at_s, speed_rad_per_s)| Contact { axis: called(axis), at_s, speed_rad_per_s };
        crashes.map(contact).collect()
    }
}

impl Wires {
    /// The wires of a simulated rig.
    pub fn simulated(rig: &SimulatedRig) -> Self {
        Self {
            bus: rig.bus(),
            ports: Ports::default()
                .with_line("imu", rig.imu_line())
                .with_line("mirror", rig.mirror_line())
                .with_card("analog", rig.analog_card())
                .with_socket("coarse", rig.coarse_port())
                .with_socket("fine", rig.fine_port()),
            instruments: InstrumentWires { analyser: rig.analyser_line(), scope: rig.scope_line() },
        }
    }
}
