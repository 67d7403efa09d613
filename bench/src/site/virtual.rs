//! A unit that does not exist: every session has a world of its own, in virtual time.

use controllers::DirectorGains;
use drivers::device::DeviceError;
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

use super::{Contact, Purpose, Session, Site, Witness, sim_unit_for_case};
use crate::clock::Clock;
use crate::files::unit::{Unit, World};
use crate::model::rig::Rig;
use crate::rig::OpenRig;
use crate::rig::device::Ports;
use crate::wires::{InstrumentWires, Wires};

mod table;

pub use table::check_scenery;

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

    /// The same site with other wires between host and devices of a director, for faults that no device has.
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
        if let Some(case) = purpose.case {
            check_scenery(unit, case)?;
        }
        if let World::Table(settings) = &unit.world {
            return table::open(settings, rig, gains, purpose, &address);
        }
        let settings = director(unit)?;
        let at = |axis: &str| purpose.pose_rad.get(axis).copied().unwrap_or(0.0);
        let heat_sink_degc = director(self.unit)?.az.ambient_degc;
        let start = StartState { az_rad: at("az"), el_rad: at("el"), heat_sink_degc };
        let simulated = match purpose.case {
            Some(case) => {
                let settings = sim_unit_for_case(settings, case);
                SimulatedRig::at_rate(&settings, &address, start, rig.loop_rate_hz)
            }
            None => SimulatedRig::at_rate(settings, &address, start, rig.loop_rate_hz),
        };
        let wires = (self.wires)(&simulated);
        let bus = wires.bus.name().to_owned();
        let rig = OpenRig::open(wires, rig, gains, &self.clock())?;
        Ok(Session { bus, rig, witness: Box::new(simulated) })
    }
}

impl Witness for SimulatedRig {
    fn contacts(&self) -> Vec<Contact> {
        let crashes = self.record().crashes.into_iter();
        crashes.map(|(axis, at_s, speed_rad_per_s)| Contact { axis, at_s, speed_rad_per_s }).collect()
    }
}

/// The settings of a unit that is a director.
fn director(unit: &Unit) -> Result<&UnitSettings, DeviceError> {
    unit.director().ok_or_else(|| DeviceError::Bus {
        device: format!("unit `{}`", unit.id),
        reason: "it is a rotary table, expected a director".to_owned(),
    })
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
