//! Objects that belong to the node and not to its drive: heartbeats, identifiers, PDO parameters (CiA 301, 7.5).

use super::node::{Node, NodeState};
use crate::bus::{Plant, VirtualBus};
use drivers::wire::BusState;

/// PDOs each way.
pub(super) const PDOS: usize = 4;
/// Bit of a COB-ID that switches a PDO off.
const SWITCHED_OFF: u32 = 1 << 31;
/// Bits of a COB-ID that are an identifier of 11 bits.
const IDENTIFIER: u32 = 0x7FF;
/// Bits that may be set beside it: switched off, no remote requests.
const FLAGS: u32 = SWITCHED_OFF | 1 << 30;
/// Transmission types: with every SYNC, up to every 240th one.
const SYNCHRONOUS: std::ops::RangeInclusive<u8> = 1..=240;
/// Identifiers that a PDO may have; the others belong to other services.
const PDO_IDENTIFIERS: std::ops::RangeInclusive<u32> = 0x181..=0x57F;
/// Bits of a CAN frame.
const LARGEST_PDO_BITS: u32 = 64;

mod abort {
    pub(super) const READ_ONLY: u32 = 0x0601_0002;
    pub(super) const NO_OBJECT: u32 = 0x0602_0000;
    pub(super) const PDO_TOO_LONG: u32 = 0x0604_0042;
    pub(super) const LENGTH: u32 = 0x0607_0010;
    pub(super) const NO_SUB_INDEX: u32 = 0x0609_0011;
    pub(super) const INVALID_VALUE: u32 = 0x0609_0030;
    pub(super) const DEVICE_STATE: u32 = 0x0800_0022;
}

/// Communication parameters of a PDO (1400h..., 1800h...).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PdoParameters {
    cob_id: u32,
    /// How many SYNCs from one to the next.
    pub(super) every: u8,
}

impl PdoParameters {
    /// Identifier of a PDO that is switched on.
    pub(super) fn identifier(&self) -> Option<u16> {
        (self.cob_id & SWITCHED_OFF == 0).then_some((self.cob_id & IDENTIFIER) as u16)
    }
}

/// Whose heartbeat is supervised (1016h).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Consumer {
    pub(super) node: u8,
    pub(super) limit_ms: u16,
}

/// Communication objects of a node.
#[derive(Clone, Debug)]
pub(super) struct Communication {
    id: u8,
    /// 1017h; 0 is no heartbeat.
    pub(super) heartbeat_ms: u16,
    /// 1016h.
    pub(super) consumers: [Consumer; 2],
    pub(super) rpdos: [PdoParameters; PDOS],
    pub(super) tpdos: [PdoParameters; PDOS],
}

impl Communication {
    /// As after power-up: the first PDO each way is on, no heartbeat.
    pub(super) fn new(id: u8) -> Self {
        let pdos = |first: u32| {
            std::array::from_fn(|k| {
                let off = if k == 0 { 0 } else { SWITCHED_OFF };
                PdoParameters { cob_id: off | (first + 0x100 * k as u32 + u32::from(id)), every: 1 }
            })
        };
        let consumers = Default::default();
        Self { id, heartbeat_ms: 0, consumers, rpdos: pdos(0x200), tpdos: pdos(0x180) }
    }

    /// Answers an upload; `None` for an object of the drive.
    fn upload(&self, index: u16, sub: u8) -> Option<Result<Vec<u8>, u32>> {
        let id = u32::from(self.id);
        let number = |value: u32| Ok(value.to_le_bytes().to_vec());
        Some(match (index, sub) {
            // The node takes SYNC and does not make it.
            (0x1005, 0) => number(0x080),
            (0x1014, 0) => number(0x080 + id),
            (0x1016, 0) => Ok(vec![self.consumers.len() as u8]),
            (0x1016, 1 | 2) => {
                let Consumer { node, limit_ms } = self.consumers[usize::from(sub) - 1];
                number(u32::from(node) << 16 | u32::from(limit_ms))
            }
            (0x1017, 0) => Ok(self.heartbeat_ms.to_le_bytes().to_vec()),
            (0x1200, 0) => Ok(vec![2]),
            (0x1200, 1) => number(0x600 + id),
            (0x1200, 2) => number(0x580 + id),
            (0x1400..=0x1403 | 0x1800..=0x1803, _) => match (self.pdo(index), sub) {
                (_, 0) => Ok(vec![2]),
                (Some(pdo), 1) => number(pdo.cob_id),
                (Some(pdo), 2) => Ok(vec![pdo.every]),
                _ => Err(abort::NO_SUB_INDEX),
            },
            (0x1005 | 0x1014 | 0x1016 | 0x1017 | 0x1200, _) => Err(abort::NO_SUB_INDEX),
            // The lists by which EtherCAT assigns PDOs.
            (0x1C12 | 0x1C13, _) => Err(abort::NO_OBJECT),
            _ => return None,
        })
    }

    fn pdo(&self, index: u16) -> Option<&PdoParameters> {
        let pdos = if index < 0x1800 { &self.rpdos } else { &self.tpdos };
        pdos.get(usize::from(index & 0xFF))
    }

    fn pdo_mut(&mut self, index: u16) -> Option<&mut PdoParameters> {
        let pdos = if index < 0x1800 { &mut self.rpdos } else { &mut self.tpdos };
        pdos.get_mut(usize::from(index & 0xFF))
    }

    /// Writes an object that [`Communication::upload`] knows, in the width that it has there.
    fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<(), u32> {
        match (index, sub, data) {
            (0x1005, 0, &[0x80, 0, 0, 0]) => Ok(()),
            (0x1005, 0, _) => Err(abort::INVALID_VALUE),
            (0x1016, 1 | 2, &[low, high, node, 0]) if node <= 127 => {
                let limit_ms = u16::from_le_bytes([low, high]);
                self.consumers[usize::from(sub) - 1] = Consumer { node, limit_ms };
                Ok(())
            }
            (0x1016, 1 | 2, _) => Err(abort::INVALID_VALUE),
            (0x1017, 0, &[low, high]) => {
                self.heartbeat_ms = u16::from_le_bytes([low, high]);
                Ok(())
            }
            (0x1400..=0x1403 | 0x1800..=0x1803, 1, &[a, b, c, d]) => {
                self.set_cob_id(index, u32::from_le_bytes([a, b, c, d]))
            }
            (0x1400..=0x1403 | 0x1800..=0x1803, 2, &[every]) => {
                let pdo = self.pdo_mut(index).ok_or(abort::NO_OBJECT)?;
                if !SYNCHRONOUS.contains(&every) {
                    return Err(abort::INVALID_VALUE);
                }
                pdo.every = every;
                Ok(())
            }
            _ => Err(abort::READ_ONLY),
        }
    }

    /// A PDO that is switched on keeps its identifier.
    fn set_cob_id(&mut self, index: u16, cob_id: u32) -> Result<(), u32> {
        let pdo = self.pdo_mut(index).ok_or(abort::NO_OBJECT)?;
        let is_known =
            cob_id & !(FLAGS | IDENTIFIER) == 0 && PDO_IDENTIFIERS.contains(&(cob_id & IDENTIFIER));
        let is_on = |cob_id: u32| cob_id & SWITCHED_OFF == 0;
        let changes = (cob_id ^ pdo.cob_id) & IDENTIFIER != 0;
        if !is_known || (changes && is_on(pdo.cob_id) && is_on(cob_id)) {
            return Err(abort::INVALID_VALUE);
        }
        pdo.cob_id = cob_id;
        Ok(())
    }
}

impl Node {
    /// Reads an object of the node or of its drive.
    pub(super) fn upload<P: Plant>(
        &self,
        bus: &mut VirtualBus<P>,
        index: u16,
        sub: u8,
    ) -> Result<Vec<u8>, u32> {
        if let Some(answer) = self.communication.upload(index, sub) {
            return answer;
        }
        if bus.drive(self.k).bus_state() < BusState::SafeOp {
            // Nobody samples the actual values here.
            let now = bus.now();
            bus.sample(self.k, now, &mut [0; PDOS * 64]);
        }
        bus.drive(self.k).upload(index, sub)
    }

    /// Writes an object of the node or of its drive.
    pub(super) fn download<P: Plant>(
        &mut self,
        bus: &mut VirtualBus<P>,
        index: u16,
        sub: u8,
        data: &[u8],
    ) -> Result<(), u32> {
        if let Some(present) = self.communication.upload(index, sub) {
            if present?.len() != data.len() {
                return Err(abort::LENGTH);
            }
            if (0x1400..=0x1BFF).contains(&index) && self.state == NodeState::Operational {
                return Err(abort::DEVICE_STATE);
            }
            self.communication.download(index, sub, data)?;
            self.heartbeats_changed(bus.now(), index);
            return Ok(());
        }
        if let 0x1600..=0x1603 | 0x1A00..=0x1A03 = index {
            self.check_mapping(bus, index, sub, data)?;
        }
        bus.drive_mut(self.k).download(index, sub, data).map(|_| ())
    }

    /// A mapping changes only while its PDO is switched off, and fits into a frame.
    fn check_mapping<P: Plant>(
        &self,
        bus: &VirtualBus<P>,
        index: u16,
        sub: u8,
        data: &[u8],
    ) -> Result<(), u32> {
        let pdo = self.communication.pdo(index - 0x200);
        if pdo.is_some_and(|pdo| pdo.identifier().is_some()) {
            return Err(abort::DEVICE_STATE);
        }
        let (0, &[count]) = (sub, data) else { return Ok(()) };
        let bits = |entry| bus.drive(self.k).upload(index, entry).map_or(0, |word| u32::from(word[0]));
        let sum: u32 = (1..=count).map(bits).sum();
        if sum > LARGEST_PDO_BITS { Err(abort::PDO_TOO_LONG) } else { Ok(()) }
    }
}
