//! A drive behind its SubDevice controller.

use std::time::Duration;

use drivers::wire::BusState;

use super::application::{Application, Emergency, EntryInfo, ObjectInfo, ProcessDataBytes};
use super::objects;
use super::sii::{Description, MailboxPlace, Pdo, PdoEntry};
use crate::bus::{Plant, VirtualBus};
use crate::cia402::Drive;

/// Mailboxes of 128 bytes at the beginning of the RAM.
const MAILBOX: MailboxPlace = MailboxPlace { receive: 0x1000, send: 0x1080, length: 128 };
/// Outputs and inputs: room for three buffers of 256 bytes each.
const PROCESS_DATA: [u16; 2] = [0x1100, 0x1400];
/// Four PDOs of 64 bytes.
const LARGEST_IMAGE_BYTES: usize = 256;
const NO_SUB_INDEX: u32 = 0x0609_0011;
const READ_ONLY: u32 = 0x0601_0002;
const LENGTH: u32 = 0x0607_0010;
const RANGE: u32 = 0x0609_0030;

/// Objects 1C32h and 1C33h: how outputs and inputs follow the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct SyncParameters {
    /// 0 free, 1 with the frame, 2 with SYNC0.
    kind: u16,
    cycle_ns: u32,
}

/// What a drive's end of the bus has beside the drive itself.
#[derive(Clone, Debug)]
pub(crate) struct DriveEnd {
    sync: [SyncParameters; 2],
    /// Error code of the last emergency message.
    told: u16,
}

impl DriveEnd {
    /// The end of a drive after power-up.
    pub(crate) fn new() -> Self {
        Self { sync: [SyncParameters { kind: 1, cycle_ns: 1_000_000 }; 2], told: 0 }
    }

    /// Objects that belong to the bus and not to the drive: sync manager types, synchronisation.
    fn upload(&self, index: u16, sub: u8) -> Option<Result<Vec<u8>, u32>> {
        const TYPES: [u8; 4] = [1, 2, 3, 4];
        let answer = match (index, sub) {
            (0x1C00, 0) => Ok(vec![TYPES.len() as u8]),
            (0x1C00, _) => TYPES.get(usize::from(sub) - 1).map(|&kind| vec![kind]).ok_or(NO_SUB_INDEX),
            (0x1C32 | 0x1C33, _) => self.sync[usize::from(index - 0x1C32)].upload(sub),
            _ => return None,
        };
        Some(answer)
    }

    fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Option<Result<(), u32>> {
        match index {
            0x1C00 => Some(Err(READ_ONLY)),
            0x1C32 | 0x1C33 => Some(self.sync[usize::from(index - 0x1C32)].download(sub, data)),
            _ => None,
        }
    }
}

impl SyncParameters {
    fn upload(&self, sub: u8) -> Result<Vec<u8>, u32> {
        /// Free, with the frame, with SYNC0.
        const SUPPORTED: u16 = 1 | 1 << 1 | 1 << 2;
        const SHORTEST_CYCLE_NS: u32 = 62_500;
        Ok(match sub {
            0 => vec![0x20],
            1 => self.kind.to_le_bytes().to_vec(),
            2 => self.cycle_ns.to_le_bytes().to_vec(),
            4 => SUPPORTED.to_le_bytes().to_vec(),
            5 => SHORTEST_CYCLE_NS.to_le_bytes().to_vec(),
            3 | 6 | 9 => vec![0; 4],
            0x0B | 0x0C => vec![0; 2],
            0x20 => vec![0],
            _ => return Err(NO_SUB_INDEX),
        })
    }

    fn download(&mut self, sub: u8, data: &[u8]) -> Result<(), u32> {
        match (sub, data) {
            (1, &[low, high]) if u16::from_le_bytes([low, high]) <= 2 => {
                self.kind = u16::from_le_bytes([low, high]);
                Ok(())
            }
            (1, &[_, _]) => Err(RANGE),
            (2, &[a, b, c, d]) => {
                self.cycle_ns = u32::from_le_bytes([a, b, c, d]);
                Ok(())
            }
            (1 | 2, _) => Err(LENGTH),
            (0 | 3..=6 | 9 | 0x0B | 0x0C | 0x20, _) => Err(READ_ONLY),
            _ => Err(NO_SUB_INDEX),
        }
    }
}

/// A drive of a bus as an application.
pub(crate) struct WiredDrive<'a, P: Plant> {
    pub(crate) bus: &'a mut VirtualBus<P>,
    pub(crate) end: &'a mut DriveEnd,
    pub(crate) k: usize,
}

impl<P: Plant> Application for WiredDrive<'_, P> {
    fn upload(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        if let Some(answer) = self.end.upload(index, sub) {
            return answer;
        }
        if self.state() < BusState::SafeOp {
            // Nobody samples the actual values here.
            let now = self.bus.now();
            self.bus.sample(self.k, now, &mut [0; LARGEST_IMAGE_BYTES]);
        }
        self.bus.drive(self.k).upload(index, sub)
    }

    fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<(), u32> {
        self.end
            .download(index, sub, data)
            .unwrap_or_else(|| self.bus.drive_mut(self.k).download(index, sub, data).map(|_| ()))
    }

    fn indices(&self) -> Vec<u16> {
        let mut indices = self.bus.drive(self.k).indices();
        indices.extend([0x1C00, 0x1C32, 0x1C33]);
        indices.sort_unstable();
        indices
    }

    fn object_info(&self, index: u16) -> Option<ObjectInfo> {
        objects::object(index)
    }

    fn entry_info(&self, index: u16, sub: u8) -> Option<EntryInfo> {
        objects::entry(index, sub)
    }

    fn map(&mut self) -> Result<ProcessDataBytes, u32> {
        let (outputs, inputs) = self.bus.drive_mut(self.k).map()?;
        Ok(ProcessDataBytes { outputs, inputs })
    }

    fn state(&self) -> BusState {
        self.bus.drive(self.k).bus_state()
    }

    fn enter(&mut self, state: BusState) {
        self.bus.enter(self.k, state);
        if state < BusState::SafeOp {
            self.bus.drive_mut(self.k).leave_safe_op();
        }
    }

    fn sample(&mut self, now: Duration, inputs: &mut [u8]) {
        self.bus.sample(self.k, now, inputs);
    }

    fn trigger(&mut self, now: Duration) {
        self.bus.trigger(now);
    }

    fn take(&mut self, now: Duration, outputs: &[u8]) {
        self.bus.take(self.k, now, outputs);
    }

    /// A fault is told once, and once that it is gone: error code 0000h.
    fn emergency(&mut self) -> Option<Emergency> {
        let [code, register] = self.bus.drive(self.k).error();
        if code == self.end.told {
            return None;
        }
        self.end.told = code;
        Some(Emergency { code, register: register as u8, vendor: [0; 5] })
    }
}

/// What the SII of a drive says.
pub(crate) fn description(drive: &Drive) -> Description {
    let number = |sub: u8| {
        let bytes = drive.upload(0x1018, sub).unwrap_or_default();
        bytes.iter().rev().fold(0_u32, |value, &byte| value << 8 | u32::from(byte))
    };
    let name = drive.upload(0x1008, 0).unwrap_or_default();
    let [outputs, inputs] = drive.mappings();
    let pdos = |mapping: &crate::cia402::Mapping, sync_manager: u8| {
        let pdos = mapping.assigned().map(|(index, words)| Pdo {
            index,
            sync_manager,
            entries: words.iter().map(|&word| entry(word)).collect(),
        });
        pdos.collect()
    };
    Description {
        name: String::from_utf8_lossy(&name).into_owned(),
        vendor: number(1),
        product: number(2),
        revision: number(3),
        serial: number(4),
        alias: 0,
        mailbox: Some(MAILBOX),
        process_data: PROCESS_DATA,
        outputs: pdos(outputs, 2),
        inputs: pdos(inputs, 3),
    }
}

/// An entry from its mapping word: index, sub-index, bits.
fn entry(word: u32) -> PdoEntry {
    PdoEntry { index: (word >> 16) as u16, sub: (word >> 8) as u8, bits: word as u8 }
}
