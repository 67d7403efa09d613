//! Serial lines, TCP connections and UDP ports of a rig at their far ends, where a simulated director has them.

use std::sync::Arc;

use drivers::device::DeviceError;
use drivers::wire::lines::LineAddress;
use drivers::wire::{ByteLine, DatagramPort};
use procedures::device::DeviceRole;
use sim_devices::rig::SimulatedRig;

use crate::model::device::DeviceEntry;
use crate::model::rig::Rig;

/// Driver whose device has no role.
const DC_SUPPLY: &str = "e36300";

/// A line of a rig, and the simulated device behind it.
pub(crate) struct FarLine {
    /// Name of the device in the rig file.
    pub(crate) device: String,
    /// Where the rig file says that it is.
    pub(crate) address: LineAddress,
    /// The device.
    pub(crate) end: FarEnd,
}

/// The device behind a line.
pub(crate) enum FarEnd {
    /// Speaks bytes.
    Line(Box<dyn ByteLine>),
    /// Speaks datagrams.
    Port(Box<dyn DatagramPort>),
}

/// The far ends of all lines of a rig, those of a simulated director behind them; `None` is a unit that has none.
///
/// # Errors
/// A device that the unit lacks.
pub(super) fn far_lines(rig: &Rig, simulated: Option<&SimulatedRig>) -> Result<Vec<FarLine>, DeviceError> {
    let mut all = Vec::new();
    for entry in &rig.devices {
        for address in entry.lines() {
            let end = simulated.and_then(|simulated| far_end(entry, simulated));
            let Some(end) = end else {
                return Err(DeviceError::Field {
                    device: format!("{} at {address}", entry.name),
                    field: "driver",
                    expected: "a device that the simulated unit has".to_owned(),
                    found: format!("`{}`", entry.driver),
                    help: "choose a director with `--unit`, or leave the device out of the rig file",
                });
            };
            all.push(FarLine { device: entry.name.clone(), address, end });
        }
    }
    Ok(all)
}

/// The simulated device behind a line; `None` for one that a simulated director does not have.
pub(super) fn far_end(entry: &DeviceEntry, simulated: &SimulatedRig) -> Option<FarEnd> {
    if let Some(profile) = &entry.profile {
        return Some(FarEnd::Line(simulated.reader_line(Arc::clone(profile))));
    }
    if entry.driver == DC_SUPPLY {
        return Some(FarEnd::Line(simulated.supply_line()));
    }
    Some(match entry.role? {
        DeviceRole::InertialUnit => FarEnd::Line(simulated.imu_line()),
        DeviceRole::Mirror => FarEnd::Line(simulated.mirror_line()),
        DeviceRole::ImpedanceAnalyser => FarEnd::Line(simulated.analyser_line()),
        DeviceRole::Oscilloscope => FarEnd::Line(simulated.scope_line()),
        DeviceRole::CoarseTracker => FarEnd::Port(simulated.coarse_port()),
        DeviceRole::FineTracker => FarEnd::Port(simulated.fine_port()),
        _ => return None,
    })
}
