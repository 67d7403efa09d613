//! A rotary table that does not exist: drives and encoders on one bus, and nothing else.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::ByteLine;
use procedures::case::Case;
use sim_devices::rig::{SeedAddress, SimulatedTable};
use sim_devices::unit::TableSettings;

use crate::clock::Clock;
use crate::files::unit::{Unit, World};
use crate::model::rig::Rig;
use crate::rig::OpenRig;
use crate::rig::device::Ports;
use crate::site::{Contact, Purpose, Session, Witness};
use crate::wires::{InstrumentWires, Wires};

/// What a point asks of the surroundings of the rig and a simulated unit cannot bring.
///
/// # Errors
/// The first thing that is asked for in vain.
pub fn check_scenery(unit: &Unit, case: &Case) -> Result<(), DeviceError> {
    if let World::Director(_) = unit.world {
        return Ok(());
    }
    let asked = [
        ("target", case.target.is_some(), "a target, which no tracker of a rotary table sees"),
        ("pull", case.pull.is_some(), "a pull, which no force gauge of a rotary table measures"),
        (
            "frame rate",
            case.fine_frame_rate_hz.is_some(),
            "a frame rate of a fine tracker that a rotary table lacks",
        ),
    ];
    match asked.into_iter().find(|(_, is_asked, _)| *is_asked) {
        Some((field, _, found)) => Err(DeviceError::Field {
            device: format!("unit `{}`", unit.id),
            field,
            expected: "none".to_owned(),
            found: format!("{found}, at point `{}`", case.point),
            help: "leave the procedure out, or choose a director with `--unit`",
        }),
        None => Ok(()),
    }
}

/// Opens a rig on a simulated table.
pub(super) fn open(
    settings: &TableSettings,
    rig: &Rig,
    gains: &controllers::DirectorGains,
    purpose: &Purpose<'_>,
    address: &SeedAddress,
) -> Result<Session, DeviceError> {
    check_names(settings, rig)?;
    let simulated = SimulatedTable::new(settings, address, &purpose.pose_rad);
    let wires = Wires::table(&simulated);
    let bus = wires.bus.name().to_owned();
    let rig = OpenRig::open(wires, rig, gains, &Clock::Virtual)?;
    Ok(Session { bus, rig, witness: Box::new(simulated) })
}

/// Every axis of the rig has the name of the axis on its station, so that poses and contacts are about the same axis.
fn check_names(settings: &TableSettings, rig: &Rig) -> Result<(), DeviceError> {
    for axis in &rig.axes {
        let station = usize::from(axis.drive.station);
        let simulated = station.checked_sub(1).and_then(|place| settings.axes.get(place));
        let found = simulated.map_or("no axis".to_owned(), |own| format!("axis `{}`", own.name));
        if simulated.is_none_or(|own| own.name != axis.name) {
            return Err(DeviceError::Field {
                device: format!("rig `{}`", rig.id),
                field: "axis",
                expected: format!("axis `{}` on station {station} of the unit", axis.name),
                found,
                help: "name the axes of rig and unit file alike, in the order of their stations",
            });
        }
    }
    Ok(())
}

impl Witness for SimulatedTable {
    fn contacts(&self) -> Vec<Contact> {
        let crashes = self.record().crashes.into_iter();
        crashes.map(|(axis, at_s, speed_rad_per_s)| Contact { axis, at_s, speed_rad_per_s }).collect()
    }
}

impl Wires {
    /// The wires of a simulated table: its bus, no port and no instrument.
    pub fn table(table: &SimulatedTable) -> Self {
        Self {
            bus: table.bus(),
            ports: Ports::default(),
            instruments: InstrumentWires {
                analyser: Box::new(Unconnected("impedance analyser")),
                scope: Box::new(Unconnected("oscilloscope")),
            },
        }
    }
}

/// The line of an instrument that this bench does not have.
struct Unconnected(&'static str);

impl Unconnected {
    fn missing(&self) -> DeviceError {
        let reason = "a rotary table has none: take its section out of the rig file".to_owned();
        DeviceError::Bus { device: self.0.to_owned(), reason }
    }
}

impl ByteLine for Unconnected {
    fn name(&self) -> &str {
        self.0
    }

    fn read(&mut self, _now: Duration, _into: &mut [u8]) -> Result<usize, DeviceError> {
        Err(self.missing())
    }

    fn write(&mut self, _now: Duration, _bytes: &[u8]) -> Result<(), DeviceError> {
        Err(self.missing())
    }
}

#[cfg(test)]
mod tests;
