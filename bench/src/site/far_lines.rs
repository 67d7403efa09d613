//! Serial lines, TCP connections and UDP ports of a rig at their far ends, where a simulated director has them.

use std::sync::Arc;

use drivers::device::DeviceError;
use drivers::wire::lines::LineAddress;
use drivers::wire::{ByteLine, DatagramPort};
use procedures::device::DeviceRole;
use sim_devices::rig::{DeviceTypes, ImuType, MirrorType, SimulatedRig};
use sim_devices::stim300::Stim300Setup;

use crate::model::device::DeviceEntry;
use crate::model::rig::Rig;
use crate::rig::devices::{gcs, stim300, supply};

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

/// Bit rate of a simulated GCS controller on a line without one, bit/s: the serial port of PI's examples (PIPython), and Ethernet.
const GCS_SERIAL_HZ: f64 = 115_200.0;
const GCS_NETWORK_HZ: f64 = 100e6;

/// Makes of the simulated devices that answer the drivers of a rig.
pub(super) fn device_types(rig: &Rig) -> DeviceTypes {
    let imu = match rig.device(DeviceRole::InertialUnit) {
        Some(entry) if entry.driver == stim300::NAME => {
            ImuType::Stim300(Stim300Setup { is_gyro_delayed: false, ..Stim300Setup::default() })
        }
        _ => ImuType::Kvh1775,
    };
    let mirror = match rig.device(DeviceRole::Mirror) {
        Some(entry) if entry.driver == gcs::NAME => MirrorType::Gcs {
            bit_rate_hz: match entry.lines().next() {
                Some(LineAddress::Serial { baud, .. }) => f64::from(baud),
                Some(LineAddress::Tcp { .. }) => GCS_NETWORK_HZ,
                _ => GCS_SERIAL_HZ,
            },
        },
        _ => MirrorType::Ccbu40,
    };
    DeviceTypes { imu, mirror }
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
    if entry.driver == supply::NAME {
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
