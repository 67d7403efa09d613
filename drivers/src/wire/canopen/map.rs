//! The end of configuration: PDOs get their identifiers, nodes are started.

use std::time::Duration;

use super::load;
use super::message::{self, NmtCommand, NmtState};
use super::node::Lengths;
use super::{CanOpenBus, ProcessImage, Slot};
use crate::cia402::Dictionary;
use crate::cia402::frames::{Direction, FRAME_BYTES, NO_OBJECT, PDOS, SWITCHED_OFF};
use crate::device::DeviceError;

/// Bit of a COB-ID that forbids remote requests: it stays as the node has it.
const NO_REMOTE: i64 = 1 << 30;
/// Sent with every SYNC, or acting with the next one.
const EVERY_SYNC: i64 = 1;
/// Longest wait for the TPDOs of the first SYNC.
const FIRST_LIMIT: Duration = Duration::from_millis(100);

impl CanOpenBus {
    pub(super) fn configure(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        self.mapped = None;
        self.commands = false;
        self.pass_to(NmtCommand::EnterPreOperational, NmtState::PreOperational)?;
        let mut image = ProcessImage::default();
        let mut slots = Vec::new();
        for k in 0..self.nodes.len() {
            let id = self.nodes[k].id;
            let station = u16::from(id);
            let (rpdos, tpdos) = self.with_dictionary(station, |node| {
                let rpdos = switch_on(node, Direction::Receive, |k| message::rpdo_id(id, k))?;
                Ok((rpdos, switch_on(node, Direction::Transmit, |k| message::tpdo_id(id, k))?))
            })?;
            let slot = Slot {
                outputs: extend(&mut image.outputs, &rpdos),
                inputs: extend(&mut image.inputs, &tpdos),
            };
            (self.nodes[k].rpdos, self.nodes[k].tpdos, self.nodes[k].slot) = (rpdos, tpdos, slot.clone());
            slots.push((station, slot));
        }
        self.check_load()?;
        self.pass_to(NmtCommand::Start, NmtState::Operational)?;
        self.take_first()?;
        self.mapped = Some([image.outputs.len(), image.inputs.len()]);
        Ok((image, slots))
    }

    /// Brings all nodes into a state of network management.
    fn pass_to(&mut self, command: NmtCommand, state: NmtState) -> Result<(), DeviceError> {
        for k in 0..self.nodes.len() {
            self.command(k, command)?;
        }
        let limit = self.link.now() + self.settings.silence();
        self.wait_for(limit, |bus| bus.nodes.iter().all(|node| node.state == state || node.has_fallen))?;
        match self.nodes.iter().find(|node| node.state != state || node.has_fallen) {
            None => Ok(()),
            Some(node) if node.has_fallen => Err(self
                .error(format!("node {} was lost or has begun anew; check its supply and wiring", node.id))),
            Some(node) => Err(self.error(format!(
                "node {} is {} instead of {}; its emergency messages say why",
                node.id,
                node.state.name(),
                state.name()
            ))),
        }
    }

    /// Refuses a cycle that is too short for its frames.
    fn check_load(&self) -> Result<(), DeviceError> {
        let lengths = self.nodes.iter().flat_map(|node| [&node.rpdos, &node.tpdos]);
        let needed_s = load::shortest_s(lengths, self.settings.bit_rate_hz);
        if self.settings.cycle_s >= needed_s {
            return Ok(());
        }
        let allowed = format!(
            "the process data of {} nodes need a cycle of at least {needed_s:.6} s at {} bit/s",
            self.nodes.len(),
            self.settings.bit_rate_hz
        );
        let device = self.name.clone();
        Err(DeviceError::Setting { device, setting: "cycle_s", value: self.settings.cycle_s, allowed })
    }

    /// A first SYNC, so that the first exchange has inputs; shows that every TPDO comes.
    fn take_first(&mut self) -> Result<(), DeviceError> {
        self.send(&message::sync())?;
        let limit = self.link.now() + FIRST_LIMIT;
        if self.wait_for(limit, |bus| bus.nodes.iter().all(super::Node::is_complete))? {
            return Ok(());
        }
        let silent: Vec<_> =
            self.nodes.iter().filter(|node| !node.is_complete()).map(|node| node.id.to_string()).collect();
        Err(DeviceError::Field {
            device: self.name.clone(),
            field: "TPDOs",
            expected: format!("all TPDOs of node {} within {FIRST_LIMIT:?} of SYNC", silent.join(", ")),
            found: "some are missing or shorter than mapped".to_owned(),
            help: "check that the drive takes SYNC with identifier 80h (1005h) and sends TPDOs of transmission type 1",
        })
    }
}

/// Switches on the PDOs of one direction that have something mapped, and gives their lengths.
fn switch_on(
    node: &mut Dictionary<'_, '_>,
    direction: Direction,
    id: impl Fn(u16) -> u16,
) -> Result<Lengths, DeviceError> {
    let mut lengths = Lengths::default();
    for k in 0..PDOS {
        let count = match node.read(direction.mapped_count(k)) {
            Err(DeviceError::Abort { code: NO_OBJECT, .. }) => break,
            found => found?,
        };
        if count == 0 {
            continue;
        }
        lengths[usize::from(k)] = length(node, direction, k, count)?;
        let kept = node.read(direction.cob_id(k))? & NO_REMOTE;
        let cob_id = kept | i64::from(id(k));
        node.write_checked(direction.cob_id(k), SWITCHED_OFF | cob_id)?;
        node.write_checked(direction.transmission_type(k), EVERY_SYNC)?;
        node.write_checked(direction.cob_id(k), cob_id)?;
    }
    Ok(lengths)
}

/// Bytes of a PDO, from its mapping read back.
fn length(
    node: &mut Dictionary<'_, '_>,
    direction: Direction,
    k: u16,
    count: i64,
) -> Result<usize, DeviceError> {
    let mut bits = 0;
    for entry in (1..=u8::MAX).take(usize::try_from(count).unwrap_or(0)) {
        bits += usize::try_from(node.read(direction.mapped_entry(k, entry))? & 0xFF).unwrap_or(0);
    }
    if bits % 8 == 0 && (1..=FRAME_BYTES).contains(&(bits / 8)) {
        return Ok(bits / 8);
    }
    let expected = format!("whole bytes, 1 to {FRAME_BYTES}");
    let help = "a frame holds no more: map the objects onto more PDOs";
    Err(node.mismatch(direction.mapped_count(k), expected, format!("{bits} bits"), help))
}

/// Makes room for the PDOs of a node at the end of one half of the image.
fn extend(half: &mut Vec<u8>, lengths: &Lengths) -> std::ops::Range<usize> {
    let first = half.len();
    half.resize(first + lengths.iter().sum::<usize>(), 0);
    first..half.len()
}
