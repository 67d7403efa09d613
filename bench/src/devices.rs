//! Who the devices are, and whether each is proven to be real.

use drivers::cia402::Identity;
use reports::record::DeviceRecord;

use crate::files::rig::Rig;

/// One record per drive. A device is real only where that is proven; a virtual bus never is.
pub fn records(rig: &Rig, identities: &[Identity]) -> Vec<DeviceRecord> {
    rig.axes
        .iter()
        .zip(identities)
        .map(|(axis, id)| DeviceRecord {
            name: format!("{}-drive", axis.name),
            identity: format!(
                "{}, vendor {:08X}h, product {:08X}h, revision {:08X}h, serial {:08X}h, firmware {}",
                id.device_name, id.vendor, id.product, id.revision, id.serial, id.firmware
            ),
            real: false,
            grounds: grounds(id),
        })
        .collect()
}

fn grounds(identity: &Identity) -> String {
    let mark = if identity.device_name.contains("SIM") { "; it carries the simulator's mark" } else { "" };
    format!("virtual bus: no network interface with a physical device{mark}")
}
