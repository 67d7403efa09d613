//! Who the devices are, and whether each is proven to be real.

use drivers::cia402::Identity;
use reports::record::DeviceRecord;

use super::OpenRig;
use crate::model::device::DeviceEntry;
use crate::model::rig::Rig;

/// Vendor id (1018h:1) of every simulated drive: the letters SIM. No maker has it.
pub(crate) const SIMULATORS_MARK: u32 = 0x0053_494D;
/// What serial numbers and answers to `*IDN?` of simulated devices contain.
const SIMULATORS_WORD: &str = "SIM";

/// Whether there may be hardware at the far end of a bus, and how that is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BusGrounds {
    /// Whether its interface has a physical device.
    pub is_physical: bool,
    /// Whether faults are planted on it: nothing on such a bus counts as real.
    pub is_disturbed: bool,
    /// How that is known.
    pub text: String,
    /// Lines and datagram ports that devices hang on.
    pub lines: Vec<LineGrounds>,
}

/// Whether there may be a device at the far end of a line or a datagram port, and how that is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineGrounds {
    /// Address, as the rig file has it.
    pub address: String,
    /// Whether it leaves the computer: a serial port with a physical device, or a peer behind an interface with one.
    pub is_physical: bool,
    /// How that is known.
    pub text: String,
}

impl BusGrounds {
    /// A bus inside this program.
    pub(crate) fn in_process() -> Self {
        let text = "virtual bus: no network interface with a physical device".to_owned();
        Self { is_physical: false, is_disturbed: false, text, lines: Vec::new() }
    }
}

/// One record per drive, then the devices on the gimbal, then the instruments. A drive without the simulator's mark counts as real:
/// whoever stands beside it is protected first. So does a device on a physical line whose identity lacks the mark. What has no
/// identity of that sort stays simulated.
pub(crate) fn records(rig: &Rig, open: &OpenRig, bus: &BusGrounds) -> Vec<DeviceRecord> {
    let instruments = open.instruments().identities().iter().cloned();
    let others = open.devices().identities().into_iter().chain(instruments);
    let others = others.map(|(name, identity)| {
        let entry = rig.devices.iter().find(|entry| entry.name == name);
        beside_drives(entry, name, identity, bus)
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

/// The record of a device beside the drives.
fn beside_drives(
    entry: Option<&DeviceEntry>,
    name: String,
    identity: String,
    bus: &BusGrounds,
) -> DeviceRecord {
    let ports: Vec<&str> = entry.iter().flat_map(|entry| entry.ports.values()).map(String::as_str).collect();
    let simulated = |grounds: String| DeviceRecord {
        name: name.clone(),
        identity: identity.clone(),
        may_be_real: false,
        proven_real: false,
        grounds,
    };
    if ports.iter().any(|port| port.starts_with("ethercat:")) {
        return simulated(format!(
            "{}; a terminal is not asked who it is, so nothing proves it real",
            bus.text
        ));
    }
    let Some(line) = bus.lines.iter().find(|line| ports.contains(&line.address.as_str())) else {
        return simulated("virtual wire: no interface with a physical device".to_owned());
    };
    if !line.is_physical {
        return simulated(line.text.clone());
    }
    if identity.contains(SIMULATORS_WORD) {
        return simulated(format!("{}; it carries the simulator's mark", line.text));
    }
    let text = format!("{}; its identity lacks the simulator's mark ({SIMULATORS_WORD})", line.text);
    let grounds = with_disturbance(text, bus.is_disturbed);
    DeviceRecord { may_be_real: true, proven_real: !bus.is_disturbed, ..simulated(grounds) }
}

/// Names of those that may be real.
pub(crate) fn real(devices: &[DeviceRecord]) -> Vec<&str> {
    devices.iter().filter(|d| d.may_be_real).map(|d| d.name.as_str()).collect()
}

fn lacks_mark(identity: &Identity) -> bool {
    identity.vendor != SIMULATORS_MARK
}

fn grounds(identity: &Identity, bus: &BusGrounds) -> String {
    let BusGrounds { is_physical, is_disturbed, text, .. } = bus;
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
    with_disturbance(found, *is_disturbed)
}

fn with_disturbance(grounds: String, is_disturbed: bool) -> String {
    match is_disturbed {
        true => format!("{grounds}; faults were planted on the wire, so nothing on it counts as real"),
        false => grounds,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::rig::read_rig;
    use crate::files::shipped::{self, Folder};

    /// What is recorded of the oscilloscope of the shipped rig with this identity, its line being as `line` says.
    fn scope(identity: &str, line: Option<LineGrounds>, is_disturbed: bool) -> DeviceRecord {
        let rig = shipped::find(Folder::Rigs, "sim", None).and_then(read_rig).expect("the shipped rig");
        let mut entry = rig.devices.into_iter().find(|entry| entry.name == "scope").expect("a scope");
        entry.ports.insert("line".to_owned(), ADDRESS.to_owned());
        let lines = Vec::from_iter(line);
        let bus = BusGrounds { is_physical: true, is_disturbed, text: "a card".to_owned(), lines };
        beside_drives(Some(&entry), entry.name.clone(), identity.to_owned(), &bus)
    }

    const ADDRESS: &str = "tcp:192.168.1.20:5025";

    fn line(is_physical: bool) -> Option<LineGrounds> {
        let text = "interface enp3s0 has a physical device".to_owned();
        Some(LineGrounds { address: ADDRESS.to_owned(), is_physical, text })
    }

    #[test]
    fn a_device_on_a_line_is_real_only_with_physical_grounds_and_without_the_mark() {
        let own = "KEYSIGHT, DSO-X 3034T, MY12345678, 7.50";
        let real = scope(own, line(true), false);
        assert!(real.may_be_real && real.proven_real, "{}", real.grounds);
        assert!(real.grounds.contains("enp3s0") && real.grounds.contains("lacks"), "{}", real.grounds);
        for simulated in [
            scope("Simulated, DSO-X-SIM, SIM0002, 1.0", line(true), false),
            scope(own, line(false), false),
            scope(own, None, false),
        ] {
            assert!(!simulated.may_be_real && !simulated.proven_real, "{}", simulated.grounds);
        }
    }

    #[test]
    fn on_a_wire_with_faults_a_device_is_protected_and_proves_nothing() {
        let disturbed = scope("KEYSIGHT, DSO-X 3034T, MY12345678, 7.50", line(true), true);
        assert!(disturbed.may_be_real && !disturbed.proven_real);
        assert!(disturbed.grounds.contains("faults were planted"), "{}", disturbed.grounds);
    }
}
