//! Who the devices are, and whether each is proven to be real.

use drivers::cia402::Identity;
use reports::record::DeviceRecord;

use crate::files::rig::Rig;
use crate::rig::OpenRig;

/// One record per drive, then the devices on the gimbal. A device is real only where that is proven; one on virtual
/// wires never is.
pub fn records(rig: &Rig, open: &OpenRig) -> Vec<DeviceRecord> {
    let payload = open.payload().identities().into_iter().map(|(name, identity)| DeviceRecord {
        name,
        identity,
        real: false,
        grounds: "virtual wire: no interface with a physical device".to_owned(),
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
            real: false,
            grounds: grounds(id),
        })
        .chain(payload)
        .collect()
}

fn grounds(identity: &Identity) -> String {
    let mark = if identity.device_name.contains("SIM") { "; it carries the simulator's mark" } else { "" };
    format!("virtual bus: no network interface with a physical device{mark}")
}
