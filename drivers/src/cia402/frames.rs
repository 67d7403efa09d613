//! Process data in CAN frames: PDOs of at most 8 bytes, each with an identifier of its own (CiA 301).

use super::objects::{Access, DataType, Object};
use super::pdo::Entry;
use super::sdo::Dictionary;
use crate::device::DeviceError;

/// PDOs each way of a node in the predefined connection set.
pub(crate) const PDOS: u16 = 4;
/// Bytes of a classic CAN frame.
pub(crate) const FRAME_BYTES: usize = 8;
/// Bit of a COB-ID that switches its PDO off.
pub(crate) const SWITCHED_OFF: i64 = 1 << 31;
/// SDO abort code of an object that there is not.
pub(crate) const NO_OBJECT: u32 = 0x0602_0000;

/// Which way a PDO goes, from the node's point of view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// The node receives it: RPDO, objects 1400h... and 1600h...
    Receive,
    /// The node transmits it: TPDO, objects 1800h... and 1A00h...
    Transmit,
}

impl Direction {
    const fn communication(self) -> u16 {
        match self {
            Self::Receive => 0x1400,
            Self::Transmit => 0x1800,
        }
    }

    const fn mapping(self) -> u16 {
        match self {
            Self::Receive => 0x1600,
            Self::Transmit => 0x1A00,
        }
    }

    /// Identifier and switch of PDO `k`, the first being 0.
    pub(crate) const fn cob_id(self, k: u16) -> Object {
        let doc = "Bits 0 to 10 identifier, bit 31 switches the PDO off.";
        object(self.communication() + k, 1, "PDO COB-ID", DataType::U32, doc)
    }

    /// When PDO `k` is sent, or acts.
    pub(crate) const fn transmission_type(self, k: u16) -> Object {
        let doc = "1 with every SYNC.";
        object(self.communication() + k, 2, "PDO transmission type", DataType::U8, doc)
    }

    /// Number of entries of the mapping of PDO `k`.
    pub(crate) const fn mapped_count(self, k: u16) -> Object {
        let doc = "Number of entries in force; 0 while entries change.";
        object(self.mapping() + k, 0, "PDO mapping, count", DataType::U8, doc)
    }

    /// Entry of the mapping of PDO `k`, the first being 1.
    pub(crate) const fn mapped_entry(self, k: u16, entry: u8) -> Object {
        let doc = "Mapped object: index << 16 | sub << 8 | bits.";
        object(self.mapping() + k, entry, "PDO mapping, entry", DataType::U32, doc)
    }
}

const fn object(index: u16, sub: u8, name: &'static str, data_type: DataType, doc: &'static str) -> Object {
    Object { index, sub, name, data_type, access: Access::ReadWrite, unit: "", doc }
}

/// Parts of a mapping that fit into a frame each, in its order.
pub(crate) fn split(entries: &[Entry]) -> Vec<&[Entry]> {
    let mut parts = Vec::new();
    let (mut first, mut bytes) = (0, 0);
    for (k, entry) in entries.iter().enumerate() {
        if bytes + entry.bytes() > FRAME_BYTES {
            parts.push(&entries[first..k]);
            (first, bytes) = (k, 0);
        }
        bytes += entry.bytes();
    }
    parts.push(&entries[first..]);
    parts
}

/// Maps the process data of one direction onto PDOs and leaves them all switched off: the bus gives them their identifiers
/// and switches on what is mapped.
pub(super) fn map(
    drive: &mut Dictionary<'_, '_>,
    direction: Direction,
    entries: &[Entry],
) -> Result<(), DeviceError> {
    let parts = split(entries);
    for k in 0..PDOS {
        let part = parts.get(usize::from(k)).copied().unwrap_or_default();
        let cob_id = match drive.read(direction.cob_id(k)) {
            // Nothing has to lie in a PDO that the drive does not have.
            Err(DeviceError::Abort { code: NO_OBJECT, .. }) if part.is_empty() => break,
            found => found?,
        };
        drive.write_checked(direction.cob_id(k), cob_id | SWITCHED_OFF)?;
        drive.write_checked(direction.mapped_count(k), 0)?;
        for (number, entry) in (1..).zip(part) {
            drive.write_checked(direction.mapped_entry(k, number), i64::from(entry.word()))?;
        }
        drive.write_checked(direction.mapped_count(k), part.len() as i64)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::profile::{DriveProfile, ProcessData};
    use super::super::tests::dictionary;
    use super::*;
    use crate::wire::canopen::shortest_cycle_s;
    use proptest::prelude::*;

    fn entries(process_data: ProcessData) -> Vec<Entry> {
        match process_data {
            ProcessData::Mapped(entries) => entries,
            ProcessData::Assigned(pdos) => panic!("a mapping, not the PDOs {pdos:?}"),
        }
    }

    fn bytes(part: &[Entry]) -> usize {
        part.iter().map(|entry| entry.bytes()).sum()
    }

    #[test]
    fn the_process_data_of_a_drive_fit_into_four_frames_each_way() {
        let profile = dictionary::profile();
        let lengths = |entries: Vec<Entry>| split(&entries).into_iter().map(bytes).collect::<Vec<_>>();
        assert_eq!(lengths(entries(profile.outputs)), [8, 2]);
        assert_eq!(lengths(entries(profile.inputs)), [6, 8, 8, 6]);
    }

    /// Six frames of 8, 2, 6, 8, 8 and 6 bytes are at most 710 bits, two drives and SYNC 1475: 1.639 ms at 90 % of 1 Mbit/s.
    #[test]
    fn two_drives_need_1_64_ms_at_1_mbit_per_s_and_one_fits_into_1_ms() {
        let profile = dictionary::profile();
        let shortest_s = |drives: &[&DriveProfile], hz| shortest_cycle_s(drives, hz).expect("a mapping");
        let two_s = shortest_s(&[&profile, &profile], 1e6);
        assert!((1.63e-3..=1.64e-3).contains(&two_s), "{two_s}");
        assert!(shortest_s(&[&profile], 1e6) < 1e-3);
        assert!((shortest_s(&[&profile, &profile], 500e3) / two_s - 2.0).abs() < 1e-9);
    }

    #[test]
    fn fixed_pdos_are_none_for_can_frames() {
        let fixed = DriveProfile { inputs: ProcessData::Assigned(vec![0x1A02]), ..dictionary::profile() };
        let error = shortest_cycle_s(&[&fixed], 1e6).expect_err("fixed");
        assert!(error.contains(&fixed.id) && error.contains("choose a profile with a mapping"), "{error}");
    }

    proptest! {
        #[test]
        fn parts_fit_into_frames_and_make_up_the_whole(picked in prop::collection::vec(0..11_usize, 1..20)) {
            let inputs = entries(dictionary::profile().inputs);
            let picked: Vec<Entry> = picked.iter().map(|&k| inputs[k]).collect();
            let parts = split(&picked);
            prop_assert!(parts.iter().all(|part| (1..=FRAME_BYTES).contains(&bytes(part))));
            prop_assert_eq!(parts.concat(), picked);
        }
    }
}
