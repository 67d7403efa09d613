//! Opening a bus: who is there, and who watches whom.

use std::time::Duration;

use super::super::ethercat::ExpectedStation;
use super::message::{NmtCommand, NmtState};
use super::node::Node;
use super::sdo::SdoClient;
use super::{CanLink, CanOpenBus, CanOpenSettings};
use crate::cia402::PowerState;
use crate::cia402::frames::NO_OBJECT;
use crate::cia402::objects::{self, Access, DataType, Object};
use crate::cia402::{Dictionary, Waiting};
use crate::device::DeviceError;
use crate::identity_range::IdentityRange;

/// How long the bus is listened to before anything is sent: whoever is on it already is heard.
const LISTEN: Duration = Duration::from_millis(200);
/// Longest wait for the boot-up of the nodes.
const BOOT_LIMIT: Duration = Duration::from_secs(2);
/// Time between two looks at a transfer.
const LOOK_EVERY: Duration = Duration::from_micros(500);

const PRODUCER: Object =
    object(0x1017, 0, "producer heartbeat time", DataType::U16, "ms", "Period of the node's heartbeat.");
const CONSUMER: Object = object(
    0x1016,
    1,
    "consumer heartbeat time",
    DataType::U32,
    "",
    "Node-ID << 16 | ms: whose heartbeat may stay out for how long before 6007h acts.",
);

const fn object(
    index: u16,
    sub: u8,
    name: &'static str,
    data_type: DataType,
    unit: &'static str,
    doc: &'static str,
) -> Object {
    Object { index, sub, name, data_type, access: Access::ReadWrite, unit, doc }
}

impl CanOpenBus {
    /// Opens the bus on an interface: resets the communication of the nodes, waits for their boot-up, checks their identities
    /// and sets up heartbeats both ways. The nodes are pre-operational then; nothing can move.
    ///
    /// # Errors
    /// When a node does not boot or is another one than expected, when another main device is on the bus, when the interface
    /// fails; a setting that no bus can be given.
    pub fn open(link: Box<dyn CanLink>, settings: CanOpenSettings) -> Result<Self, DeviceError> {
        settings.check()?;
        let name = format!("{} ({})", settings.name, link.name());
        let expected = settings.nodes.clone();
        let ids = expected.iter().filter_map(|node| u8::try_from(node.station).ok());
        let nodes = ids.map(Node::new).collect();
        let mut bus = Self {
            name,
            settings,
            link,
            nodes,
            sdo: SdoClient::new(),
            mapped: None,
            is_alone: false,
            commands: false,
            heartbeat_due: None,
            failure: None,
            notices: std::collections::VecDeque::with_capacity(super::MOST_NOTICES),
            last_error: None,
        };
        bus.boot()?;
        for node in &expected {
            bus.check_identity(node)?;
            bus.watch(node.station)?;
        }
        Ok(bus)
    }

    fn boot(&mut self) -> Result<(), DeviceError> {
        self.reach(self.link.now() + LISTEN);
        self.check()?;
        if !self.settings.may_let_go {
            self.check_nothing_is_held()?;
        }
        self.is_alone = true;
        for k in 0..self.nodes.len() {
            // Who was switched on just now has told so already; the boot-up after this command counts.
            self.nodes[k].has_booted = false;
            self.command(k, NmtCommand::ResetCommunication)?;
        }
        let limit = self.link.now() + BOOT_LIMIT;
        if self.wait_for(limit, |bus| bus.nodes.iter().all(|node| node.has_booted))? {
            // From now on a boot-up means that a node has begun anew.
            self.nodes.iter_mut().for_each(|node| node.wanted = NmtState::PreOperational);
            return Ok(());
        }
        let missing: Vec<_> =
            self.nodes.iter().filter(|node| !node.has_booted).map(|node| node.id.to_string()).collect();
        Err(DeviceError::Field {
            device: self.name.clone(),
            field: "nodes",
            expected: format!("boot-up within {} s of node {}", BOOT_LIMIT.as_secs(), missing.join(", ")),
            found: "none".to_owned(),
            help: "check supply, wiring, termination, bit rate and the node-ID that is set at the drive, or correct the stations in \
                   the rig file",
        })
    }

    /// Refuses drives that may hold an axis: the reset that follows takes their torque away. One that is silent has no supply, or
    /// only just got it.
    fn check_nothing_is_held(&mut self) -> Result<(), DeviceError> {
        for k in 0..self.nodes.len() {
            let (id, is_heard) = (self.nodes[k].id, self.nodes[k].state != NmtState::BootUp);
            let found = match self.with_dictionary(u16::from(id), |node| node.read(objects::STATUSWORD)) {
                Ok(statusword) if holds_nothing(statusword as u16) => continue,
                Ok(statusword) => format!("statusword {statusword:04X}h"),
                Err(DeviceError::Abort { code: NO_OBJECT, .. }) => continue,
                Err(_) if is_heard => "heartbeats, but no answer to SDO requests".to_owned(),
                Err(_) => {
                    self.check()?;
                    continue;
                }
            };
            return Err(DeviceError::Field {
                device: format!("{}, node {id}", self.name),
                field: "torque",
                expected: "a drive that holds nothing".to_owned(),
                found,
                help: "opening the bus resets the drive, which lets go of its axis: secure all axes mechanically, then run \
                       `bench devices --let-go`, or switch the drive off",
            });
        }
        Ok(())
    }

    /// Listens until `is_over`, at the latest until `limit`; whether it is over.
    pub(super) fn wait_for(
        &mut self,
        limit: Duration,
        is_over: impl Fn(&Self) -> bool,
    ) -> Result<bool, DeviceError> {
        loop {
            self.check()?;
            if is_over(self) {
                return Ok(true);
            }
            let now = self.link.now();
            if now >= limit {
                return Ok(false);
            }
            self.reach((now + LOOK_EVERY).min(limit));
        }
    }

    fn check_identity(&mut self, expected: &ExpectedStation) -> Result<(), DeviceError> {
        let rows = [
            (objects::VENDOR, expected.vendor.map(IdentityRange::one)),
            (objects::PRODUCT, expected.product.map(IdentityRange::one)),
            (objects::REVISION, expected.revisions.map(IdentityRange)),
            (objects::SERIAL, expected.serial.map(IdentityRange::one)),
        ];
        let rows = rows.into_iter().filter_map(|(object, wanted)| Some((object, wanted?)));
        self.with_dictionary(expected.station, |node| {
            for (object, wanted) in rows {
                let found = node.read_u32(object)?;
                if !wanted.contains(found) {
                    let [wanted, found] = [wanted, IdentityRange::one(found)].map(|range| range.to_string());
                    let help = "another device has this node-ID: check the wiring, or correct the identity in the rig file";
                    return Err(node.mismatch(object, wanted, found, help));
                }
            }
            Ok(())
        })
    }

    /// The node sends heartbeats and supervises the bench's own, from the first one on that it gets.
    fn watch(&mut self, station: u16) -> Result<(), DeviceError> {
        let period = i64::from(self.settings.heartbeat_ms());
        let supervised = i64::from(self.settings.own_node) << 16 | i64::from(self.settings.silence_ms());
        self.with_dictionary(station, |node| {
            node.write_checked(PRODUCER, period)?;
            node.write_checked(CONSUMER, supervised)
        })?;
        let now = self.link.now();
        self.nodes
            .iter_mut()
            .filter(|node| u16::from(node.id) == station)
            .for_each(|node| node.heard = Some(now));
        Ok(())
    }

    /// Dialogues over SDO before the tick.
    pub(super) fn with_dictionary<T>(
        &mut self,
        station: u16,
        act: impl FnOnce(&mut Dictionary<'_, '_>) -> Result<T, DeviceError>,
    ) -> Result<T, DeviceError> {
        let mut at = self.link.now();
        let device = format!("{}, node {station}", self.name);
        let mut pause = || {
            at += LOOK_EVERY;
            at
        };
        let mut waiting = Waiting { now: self.link.now(), pause: &mut pause };
        let outcome = act(&mut Dictionary { wire: self, waiting: &mut waiting, device: &device, station });
        // Why the interface failed says more than that a transfer timed out.
        self.check()?;
        outcome
    }
}

/// Whether a drive gives no torque: one that is still starting gives none either.
fn holds_nothing(statusword: u16) -> bool {
    let state = PowerState::of(statusword);
    state.is_without_torque() || state == PowerState::NotReady
}
