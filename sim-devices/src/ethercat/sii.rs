//! Contents of the SII, the EEPROM that says what a SubDevice is (ETG.1000.6, 5.4, and ETG.2010).

/// First word of the categories.
const CATEGORIES: usize = 0x40;
/// Category: texts.
const STRINGS: u16 = 10;
/// Category: what the device is.
const GENERAL: u16 = 30;
/// Category: uses of the FMMUs.
const FMMU: u16 = 40;
/// Category: sync managers.
const SYNC_MANAGERS: u16 = 41;
/// Category: inputs.
const TX_PDO: u16 = 50;
/// Category: outputs.
const RX_PDO: u16 = 51;
/// No more categories.
const END: u16 = 0xFFFF;
/// Protocol bit: CANopen over EtherCAT.
const COE: u16 = 1 << 2;
/// SDO, SDO information, PDO assignment, PDO configuration, complete access.
const COE_DETAILS: u8 = 1 | 1 << 1 | 1 << 2 | 1 << 3 | 1 << 5;
/// Size word: 2 KiB, in kbit less 1.
const SIZE: u16 = 15;
const SIZE_WORDS: usize = (SIZE as usize + 1) * 1024 / 16;

/// Mailbox of a SubDevice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MailboxPlace {
    /// First byte of the mailbox that the MainDevice writes.
    pub(crate) receive: u16,
    /// First byte of the mailbox that the MainDevice reads.
    pub(crate) send: u16,
    /// Bytes of either.
    pub(crate) length: u16,
}

/// One object or gap of a PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PdoEntry {
    /// Index; 0 for a gap.
    pub(crate) index: u16,
    /// Sub-index.
    pub(crate) sub: u8,
    /// Bits.
    pub(crate) bits: u8,
}

/// A PDO that power-up brings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pdo {
    /// Index of the PDO.
    pub(crate) index: u16,
    /// Its sync manager.
    pub(crate) sync_manager: u8,
    /// Objects in order.
    pub(crate) entries: Vec<PdoEntry>,
}

/// What the SII says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Description {
    /// Name.
    pub(crate) name: String,
    /// Vendor.
    pub(crate) vendor: u32,
    /// Product.
    pub(crate) product: u32,
    /// Revision.
    pub(crate) revision: u32,
    /// Serial number.
    pub(crate) serial: u32,
    /// Alias; 0 where nobody gave one.
    pub(crate) alias: u16,
    /// Mailbox; `None` for a device without.
    pub(crate) mailbox: Option<MailboxPlace>,
    /// First byte of outputs and of inputs in the RAM.
    pub(crate) process_data: [u16; 2],
    /// PDOs from MainDevice to SubDevice.
    pub(crate) outputs: Vec<Pdo>,
    /// PDOs from SubDevice to MainDevice.
    pub(crate) inputs: Vec<Pdo>,
}

impl Description {
    /// The words of the SII.
    pub(crate) fn words(&self) -> Vec<u16> {
        let mut words = vec![0; CATEGORIES];
        words[0] = 0x0005;
        words[4] = self.alias;
        for (at, value) in [(8, self.vendor), (10, self.product), (12, self.revision), (14, self.serial)] {
            words[at] = value as u16;
            words[at + 1] = (value >> 16) as u16;
        }
        if let Some(mailbox) = self.mailbox {
            let place = [mailbox.receive, mailbox.length, mailbox.send, mailbox.length];
            words[0x18..0x1C].copy_from_slice(&place);
            words[0x1C] = COE;
        }
        words[0x3E] = SIZE;
        words[0x3F] = 1;
        let configuration: Vec<u8> = words[..7].iter().flat_map(|word| word.to_le_bytes()).collect();
        words[7] = u16::from(crc8(&configuration));
        self.categories(&mut words);
        words.push(END);
        let used = words.len();
        // Erased up to its size, and writable.
        words.resize(used.max(SIZE_WORDS), 0xFFFF);
        words
    }

    fn categories(&self, words: &mut Vec<u16>) {
        let mut strings = vec![1, self.name.len() as u8];
        strings.extend(self.name.as_bytes());
        push(words, STRINGS, strings);
        let mut general = vec![0_u8; 32];
        general[3] = 1; // name
        if self.mailbox.is_some() {
            general[5] = COE_DETAILS;
        }
        general[16] = 0x11; // physical ports: MII in and out
        push(words, GENERAL, general);
        push(words, FMMU, vec![1, 2, if self.mailbox.is_some() { 3 } else { 0 }, 0]);
        push(words, SYNC_MANAGERS, self.sync_managers());
        for (category, pdos) in [(TX_PDO, &self.inputs), (RX_PDO, &self.outputs)] {
            if !pdos.is_empty() {
                push(words, category, pdos.iter().flat_map(pdo).collect());
            }
        }
    }

    /// Start, length, control, status, enable, type of each. A device without mailbox begins with its outputs.
    fn sync_managers(&self) -> Vec<u8> {
        let row = |start: u16, length: u16, control: u8, enable: u8, kind: u8| {
            let ([s0, s1], [l0, l1]) = (start.to_le_bytes(), length.to_le_bytes());
            [s0, s1, l0, l1, control, 0, enable, kind]
        };
        let mut rows = Vec::new();
        if let Some(mailbox) = self.mailbox {
            rows.extend(row(mailbox.receive, mailbox.length, 0x26, 1, 1));
            rows.extend(row(mailbox.send, mailbox.length, 0x22, 1, 2));
        }
        let [outputs, inputs] = self.process_data;
        let (out_bytes, in_bytes) = (bytes(&self.outputs), bytes(&self.inputs));
        rows.extend(row(outputs, out_bytes, 0x64, u8::from(out_bytes > 0), 3));
        rows.extend(row(inputs, in_bytes, 0x20, u8::from(in_bytes > 0), 4));
        rows
    }
}

/// Bytes of all these PDOs together.
pub(crate) fn bytes(pdos: &[Pdo]) -> u16 {
    let bits: u16 = pdos.iter().flat_map(|pdo| &pdo.entries).map(|entry| u16::from(entry.bits)).sum();
    bits.div_ceil(8)
}

fn pdo(pdo: &Pdo) -> Vec<u8> {
    let [i0, i1] = pdo.index.to_le_bytes();
    let mut bytes = vec![i0, i1, pdo.entries.len() as u8, pdo.sync_manager, 0, 0, 0, 0];
    for entry in &pdo.entries {
        let [e0, e1] = entry.index.to_le_bytes();
        // Name, data type and flags are left open: nobody needs them to lay out process data.
        bytes.extend([e0, e1, entry.sub, 0, 0, entry.bits, 0, 0]);
    }
    bytes
}

fn push(words: &mut Vec<u16>, category: u16, mut bytes: Vec<u8>) {
    if bytes.len() % 2 == 1 {
        bytes.push(0);
    }
    words.push(category);
    words.push((bytes.len() / 2) as u16);
    words.extend(bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])));
}

/// CRC-8 of the first seven words: polynomial 07h, start value FFh.
pub(crate) fn crc8(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0xFF, |crc, &byte| {
        (0..8).fold(crc ^ byte, |crc: u8, _| if crc & 0x80 != 0 { crc << 1 ^ 0x07 } else { crc << 1 })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description() -> Description {
        let entry = PdoEntry { index: 0x6040, sub: 0, bits: 16 };
        Description {
            name: "SIM drive".to_owned(),
            vendor: 0x0053_494D,
            product: 0x402,
            revision: 1,
            serial: 1001,
            alias: 7,
            mailbox: Some(MailboxPlace { receive: 0x1000, send: 0x1080, length: 128 }),
            process_data: [0x1100, 0x1400],
            outputs: vec![Pdo { index: 0x1600, sync_manager: 2, entries: vec![entry] }],
            inputs: Vec::new(),
        }
    }

    #[test]
    fn identity_and_mailbox_stand_where_the_standard_has_them() {
        let words = description().words();
        assert_eq!(words[4], 7);
        assert_eq!(words[8..16], [0x494D, 0x0053, 0x402, 0, 1, 0, 1001, 0]);
        assert_eq!(words[0x18..0x1D], [0x1000, 128, 0x1080, 128, 4]);
    }

    #[test]
    fn the_checksum_of_zeros_is_known() {
        // FFh, divided bit by bit by x^8 + x^2 + x + 1.
        assert_eq!(crc8(&[0x00]), 0xF3);
    }

    #[test]
    fn categories_follow_each_other_to_the_end() {
        let words = description().words();
        let mut found = Vec::new();
        let mut at = CATEGORIES;
        while words[at] != END {
            found.push(words[at]);
            at += 2 + usize::from(words[at + 1]);
        }
        assert_eq!(found, [STRINGS, GENERAL, FMMU, SYNC_MANAGERS, RX_PDO]);
        assert_eq!(words.len(), 1024, "2 KiB as word 3Eh says");
        assert!(words[at..].iter().all(|&word| word == 0xFFFF));
    }
}
