//! Who the devices are, and whether each is proven to be real.

use drivers::cia402::Identity;
use reports::record::DeviceRecord;

use super::OpenRig;
use crate::model::rig::Rig;

/// Vendor id (1018h:1) of every simulated drive: the letters SIM. No maker has it.
pub(crate) const SIMULATORS_MARK: u32 = 0x0053_494D;

/// Whether there may be hardware at the far end of a bus, and how that is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BusGrounds {
    /// Whether its interface has a physical device.
    pub is_physical: bool,
    /// Whether faults are planted on it: nothing on such a bus counts as real.
    pub is_disturbed: bool,
    /// How that is known.
    pub text: String,
}

impl BusGrounds {
    /// A bus inside this program.
    pub(crate) fn in_process() -> Self {
        let text = "virtual bus: no network interface with a physical device".to_owned();
        Self { is_physical: false, is_disturbed: false, text }
    }
}

/// One record per drive, then the devices on the gimbal, then the instruments. A drive without the simulator's mark counts as real:
/// whoever stands beside it is protected first. What has no identity of that sort stays simulated on virtual wires.
pub(crate) fn records(rig: &Rig, open: &OpenRig, bus: &BusGrounds) -> Vec<DeviceRecord> {
    let instruments = open.instruments().identities().iter().cloned();
    let others = open.devices().identities().into_iter().chain(instruments);
    let others = others.map(|(name, identity)| DeviceRecord {
        name,
        identity,
        may_be_real: false,
        proven_real: false,
        grounds: "virtual wire: no interface with a physical device".to_owned(),
    });
    let others = others.map(|device| {
        let entry = rig.devices.iter().find(|entry| entry.name == device.name);
        let is_wired = entry.is_some_and(|e| e.ports.values().any(|port| port.starts_with("ethercat:")));
        let grounds = format!("{}; a terminal is not asked who it is, so nothing proves it real", bus.text);
        if is_wired { DeviceRecord { grounds, ..device } } else { device }
    });
    rig.axes
        .iter()
        .zip(open.identities())
        .map(|(axis, id)| DeviceRecord {
            name: format!("{}-drive", axis.name),
            identity: format!(
                "{}, vendor {:08X}h, product {:08X}h, revision {:08X}h, serial {:08X}h, firmware {}",
                id.device_name, id.vendor, id.product, id.revision, id.serial, id.firmware
            ),
            may_be_real: lacks_mark(id),
            // A virtual bus proves nothing real, whoever answers on it.
            proven_real: bus.is_physical && !bus.is_disturbed && lacks_mark(id),
            grounds: grounds(id, bus),
        })
        .chain(others)
        .collect()
}

/// Names of those that may be real.
pub(crate) fn real(devices: &[DeviceRecord]) -> Vec<&str> {
    devices.iter().filter(|d| d.may_be_real).map(|d| d.name.as_str()).collect()
}

fn lacks_mark(identity: &Identity) -> bool {
    identity.vendor != SIMULATORS_MARK
}

fn grounds(identity: &Identity, bus: &BusGrounds) -> String {
    let BusGrounds { is_physical, is_disturbed, text } = bus;
    let vendor = identity.vendor;
    let found = match (lacks_mark(identity), is_physical) {
        (true, true) => {
            format!("{text}; vendor {vendor:08X}h is not the simulator's mark ({SIMULATORS_MARK:08X}h)")
        }
        (true, false) => format!(
            "vendor {vendor:08X}h is not the simulator's mark ({SIMULATORS_MARK:08X}h); its log stays simulated, for the \
             bus has no hardware: {text}"
        ),
        (false, _) => format!("{text}; it carries the simulator's mark"),
    };
    match is_disturbed {
        true => format!("{found}; faults were planted on the wire, so nothing on it counts as real"),
        false => found,
    }
}
