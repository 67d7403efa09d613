//! Opening the drives: each is identified, configured and read back, and whatever else is on their bus is no drive.

use std::time::Duration;

use drivers::cia402::{Cia402, Identity, Waiting, is_drive};
use drivers::device::DeviceError;
use drivers::wire::Fieldbus;

use super::devices::DIALOGUE_STEP;
use crate::clock::Clock;
use crate::model::axis::RigAxis;
use crate::model::rig::Rig;

/// Drives that were identified, configured and read back, and the axes as they allow them.
pub(super) struct OpenedDrives {
    pub(super) drives: Vec<Cia402>,
    pub(super) identities: Vec<Identity>,
    pub(super) axes: Vec<RigAxis>,
}

/// Opens the drives of a rig in the order of its axes, letting time pass on `clock`.
///
/// # Errors
/// The first station that is missing, is of another type, or refuses a setting.
pub(super) fn open_drives(
    bus: &mut dyn Fieldbus,
    rig: &Rig,
    clock: &Clock,
    now: &mut Duration,
) -> Result<OpenedDrives, DeviceError> {
    let mut at = *now;
    let mut pause = || {
        at = clock.wait_until(at + DIALOGUE_STEP);
        at
    };
    let mut waiting = Waiting { now: *now, pause: &mut pause };

    let found = bus.stations();
    let mut drives = Vec::new();
    let mut identities = Vec::new();
    let mut axes = rig.axes.clone();
    for axis in &mut axes {
        if !found.contains(&axis.drive.station) {
            let (station, bus) = (axis.drive.station, bus.name());
            let reason = format!(
                "no station {station} on {bus}, found stations {found:?}; check power and wiring, and `station` in the rig file"
            );
            return Err(DeviceError::Bus { device: axis.name.clone(), reason });
        }
        let (drive, identity) = Cia402::open(bus, axis.drive.clone(), &mut waiting)?;
        axis.guard.rely_on(drive.available_torque_nm());
        if drives.is_empty() {
            check_inputs(rig, &drive)?;
        }
        drives.push(drive);
        identities.push(identity);
    }
    check_terminals(bus, rig, &found, &mut waiting)?;
    *now = waiting.now;
    Ok(OpenedDrives { drives, identities, axes })
}

/// Refuses a drive where the rig file has a terminal: what is written to it would be commands. Rigs in this process have no
/// terminals on their bus.
fn check_terminals(
    bus: &mut dyn Fieldbus,
    rig: &Rig,
    found: &[u16],
    waiting: &mut Waiting<'_>,
) -> Result<(), DeviceError> {
    let beside = rig.stations_beside_drives();
    for own in beside.iter().filter(|own| rig.interface.is_some() && found.contains(&own.station)) {
        if is_drive(bus, own.station, waiting) {
            let (names, station) = (own.names.join(", "), own.station);
            let reason = format!(
                "station {station} is a CiA 402 drive, but the rig file has {names} there; correct the address, or check the \
                 order of the line"
            );
            return Err(DeviceError::Bus { device: bus.name().to_owned(), reason });
        }
    }
    Ok(())
}

/// Refuses a first drive that does not send the inputs to which emergency stop or enabling switch are wired.
fn check_inputs(rig: &Rig, drive: &Cia402) -> Result<(), DeviceError> {
    let is_wired = rig.emergency_stop_bit.is_some() || rig.enabling_switch_bit.is_some();
    if !is_wired || drive.sends_digital_inputs() {
        return Ok(());
    }
    Err(DeviceError::Field {
        device: drive.settings().name.clone(),
        field: "digital inputs (60FDh)",
        expected: "among the process data: the rig file names bits of it".to_owned(),
        found: "not mapped".to_owned(),
        help: "add 60FDh to the inputs in the profile of the drive",
    })
}
