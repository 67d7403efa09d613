//! CAN buses of a rig: on an interface of Linux, or in this process.

use drivers::cia402::profile::ProfileIdentity;
use drivers::device::DeviceError;
use drivers::wire::Fieldbus;
use drivers::wire::can::{CanLink, SocketCan};
use drivers::wire::canopen::{CanOpenBus, CanOpenSettings};
use drivers::wire::ethercat::ExpectedStation;
use sim_devices::canopen::{CanOpenLine, InProcessCan};

use crate::clock::Clock;
use crate::model::rig::{CanBus, Rig};

/// The bus of a rig on an interface of Linux. Opening it resets the drives, which let go of what they hold.
///
/// # Errors
/// When the interface cannot be used, when a drive holds an axis that may not fall, and as [`CanOpenBus::open`].
pub(super) fn on_interface(
    rig: &Rig,
    can: CanBus,
    interface: &str,
    clock: &Clock,
    may_let_go: bool,
) -> Result<Box<dyn Fieldbus>, DeviceError> {
    let clock = clock.clone();
    let link = SocketCan::open(interface, Box::new(move || clock.now()))?;
    open(rig, can, Box::new(link), may_let_go)
}

/// The bus of a rig with simulated nodes in this process, whose frames take their time.
///
/// # Errors
/// As [`CanOpenBus::open`].
pub(super) fn in_process(
    rig: &Rig,
    can: CanBus,
    nodes: Box<dyn CanOpenLine>,
) -> Result<Box<dyn Fieldbus>, DeviceError> {
    open(rig, can, Box::new(InProcessCan::new(nodes, can.bit_rate_hz)), true)
}

fn open(
    rig: &Rig,
    can: CanBus,
    link: Box<dyn CanLink>,
    may_let_go: bool,
) -> Result<Box<dyn Fieldbus>, DeviceError> {
    let usual = CanOpenSettings::usual("CAN", 1.0 / rig.loop_rate_hz, &[]);
    let settings = CanOpenSettings { bit_rate_hz: can.bit_rate_hz, nodes: nodes(rig), may_let_go, ..usual };
    Ok(Box::new(CanOpenBus::open(link, settings)?))
}

/// The nodes that the rig file names, and what the profiles of its drives say of them.
fn nodes(rig: &Rig) -> Vec<ExpectedStation> {
    let node = |axis: &crate::model::axis::RigAxis| {
        let ProfileIdentity { vendor, product, revisions } = axis.drive.profile.identity;
        let (station, name) = (axis.drive.station, axis.name.clone());
        ExpectedStation { station, name, vendor, product, revisions, serial: axis.serial }
    };
    rig.axes.iter().map(node).collect()
}
