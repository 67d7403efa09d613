//! PDOs of a node: what its drive takes and gives at a SYNC.

use super::node::Node;
use super::objects::PDOS;
use crate::bus::{Plant, VirtualBus};
use drivers::wire::BusState;
use drivers::wire::can::CanFrame;
use std::time::Duration;

/// A PDO that is switched on, and its place in the process data of the drive.
#[derive(Clone, Copy, Debug)]
struct Pdo {
    identifier: u16,
    every: u8,
    first: usize,
    bytes: usize,
}

/// Process data of a node, laid out when it becomes operational.
#[derive(Clone, Debug, Default)]
pub(super) struct ProcessData {
    rpdos: Vec<Pdo>,
    tpdos: Vec<Pdo>,
    outputs: Vec<u8>,
    inputs: Vec<u8>,
    /// Outputs came since the last SYNC.
    is_fresh: bool,
    syncs_count: u64,
}

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Receipt {
    /// It is no RPDO of this node.
    Foreign,
    /// Its data act at the next SYNC.
    Kept,
    /// It is shorter than what is mapped.
    TooShort,
}

impl ProcessData {
    /// Lays out the PDOs that are switched on and have something mapped; the abort code of a mapping that does not fit. The
    /// drive is told by its lists of assigned PDOs, which only EtherCAT shows to the outside.
    pub(super) fn lay_out<P: Plant>(node: &Node, bus: &mut VirtualBus<P>) -> Result<Self, u32> {
        let ways = [(0x1600, 0x1C12, &node.communication.rpdos), (0x1A00, 0x1C13, &node.communication.tpdos)];
        let mut laid_out = [Vec::new(), Vec::new()];
        for ((first_mapping, assignment, parameters), pdos) in ways.into_iter().zip(&mut laid_out) {
            let drive = bus.drive_mut(node.k);
            drive.download(assignment, 0, &[0])?;
            let mut first = 0;
            for (mapping, parameters) in (first_mapping..).zip(parameters) {
                let bytes = bytes(&*bus, node.k, mapping);
                let (Some(identifier), 1..) = (parameters.identifier(), bytes) else { continue };
                pdos.push(Pdo { identifier, every: parameters.every, first, bytes });
                first += bytes;
                let sub = pdos.len() as u8;
                bus.drive_mut(node.k).download(assignment, sub, &mapping.to_le_bytes())?;
            }
            bus.drive_mut(node.k).download(assignment, 0, &[pdos.len() as u8])?;
        }
        let (outputs, inputs) = bus.drive_mut(node.k).map()?;
        let [rpdos, tpdos] = laid_out;
        let (outputs, inputs) = (vec![0; outputs], vec![0; inputs]);
        Ok(Self { rpdos, tpdos, outputs, inputs, is_fresh: false, syncs_count: 0 })
    }

    /// Takes a frame that may be an RPDO.
    pub(super) fn receive(&mut self, frame: &CanFrame) -> Receipt {
        let Some(pdo) = self.rpdos.iter().find(|pdo| pdo.identifier == frame.id()) else {
            return Receipt::Foreign;
        };
        let place = self.outputs.get_mut(pdo.first..pdo.first + pdo.bytes);
        let (Some(data), Some(place)) = (frame.data().get(..pdo.bytes), place) else {
            return Receipt::TooShort;
        };
        place.copy_from_slice(data);
        self.is_fresh = true;
        Receipt::Kept
    }

    /// SYNC: inputs are sampled and sent, outputs that came since the last one act.
    pub(super) fn sync<P: Plant>(
        &mut self,
        bus: &mut VirtualBus<P>,
        k: usize,
        now: Duration,
        send: &mut dyn FnMut(CanFrame),
    ) {
        self.syncs_count += 1;
        bus.sample(k, now, &mut self.inputs);
        for pdo in self.tpdos.iter().filter(|pdo| self.syncs_count.is_multiple_of(u64::from(pdo.every))) {
            let data = self.inputs.get(pdo.first..pdo.first + pdo.bytes);
            if let Some(frame) = data.and_then(|data| CanFrame::new(pdo.identifier, data)) {
                send(frame);
            }
        }
        if std::mem::take(&mut self.is_fresh) {
            if bus.drive(k).bus_state() != BusState::Op {
                bus.enter(k, BusState::Op);
            }
            bus.take(k, now, &self.outputs);
        }
    }
}

/// Bytes that are mapped onto a PDO.
fn bytes<P: Plant>(bus: &VirtualBus<P>, k: usize, mapping: u16) -> usize {
    let object = |sub| bus.drive(k).upload(mapping, sub).ok().and_then(|bytes| bytes.first().copied());
    let count = object(0).unwrap_or(0);
    let bits: usize = (1..=count).filter_map(object).map(usize::from).sum();
    bits.div_ceil(8)
}

/// Gives the drive the mapping that a CANopen node has after power-up: one PDO each way, 8 bytes at the most.
pub(super) fn map_by_default<P: Plant>(bus: &mut VirtualBus<P>, k: usize) {
    const RPDO: [u32; 3] = [0x6040_0010, 0x6071_0010, 0x60FF_0020];
    const TPDO: [u32; 3] = [0x6041_0010, 0x6064_0020, 0x6077_0010];
    for (first, words) in [(0x1600, RPDO), (0x1A00, TPDO)] {
        for (mapping, words) in (first..).zip([&words[..], &[], &[], &[]]).take(PDOS) {
            let entries = (1..).zip(words).map(|(sub, word)| (sub, word.to_le_bytes().to_vec()));
            let count = (0, vec![words.len() as u8]);
            for (sub, data) in std::iter::once((0, vec![0])).chain(entries).chain([count]) {
                bus.drive_mut(k)
                    .download(mapping, sub, &data)
                    .expect("a drive in PRE-OP maps its own objects");
            }
        }
    }
}
