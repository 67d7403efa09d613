//! The process data of one drive: which object lies at which byte.

use super::objects::{self, Object};

/// One entry of a PDO mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// An object in its full width.
    Mapped(Object),
    /// One byte of padding.
    Padding,
}

impl Entry {
    /// Width in bytes.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Padding => 1,
            Self::Mapped(object) => match object.data_type.bytes() {
                Some(bytes) => bytes,
                None => panic!("a text cannot be mapped"),
            },
        }
    }

    /// The mapping word of 1600h and 1A00h: index << 16 | sub << 8 | bits.
    pub const fn word(self) -> u32 {
        let bits = self.bytes() as u32 * 8;
        match self {
            Self::Padding => bits,
            Self::Mapped(object) => (object.index as u32) << 16 | (object.sub as u32) << 8 | bits,
        }
    }
}

/// Host to drive (1600h).
pub const RX: [Entry; 5] = [
    Entry::Mapped(objects::CONTROLWORD),
    Entry::Mapped(objects::TARGET_TORQUE),
    Entry::Mapped(objects::TARGET_VELOCITY),
    Entry::Mapped(objects::MODE),
    Entry::Padding,
];

/// Drive to host (1A00h).
pub const TX: [Entry; 11] = [
    Entry::Mapped(objects::STATUSWORD),
    Entry::Mapped(objects::ERROR_CODE),
    Entry::Mapped(objects::MODE_DISPLAY),
    Entry::Padding,
    Entry::Mapped(objects::POSITION),
    Entry::Mapped(objects::VELOCITY),
    Entry::Mapped(objects::TORQUE),
    Entry::Mapped(objects::CURRENT),
    Entry::Mapped(objects::DC_LINK),
    Entry::Mapped(objects::HEAT_SINK),
    Entry::Mapped(objects::DIGITAL_INPUTS),
];

/// Bytes of a mapping.
pub const fn bytes(mapping: &[Entry]) -> usize {
    offset(mapping, mapping.len())
}

/// Byte at which entry `position` of a mapping begins.
pub const fn offset(mapping: &[Entry], position: usize) -> usize {
    let mut k = 0;
    let mut sum = 0;
    while k < position {
        sum += mapping[k].bytes();
        k += 1;
    }
    sum
}

/// Bytes from host to drive: 10.
pub const RX_BYTES: usize = bytes(&RX);
/// Bytes from drive to host: 28.
pub const TX_BYTES: usize = bytes(&TX);

/// Byte offset of an object in a mapping; one that is not mapped does not compile.
pub const fn offset_of(mapping: &[Entry], object: Object) -> usize {
    let mut k = 0;
    while k < mapping.len() {
        if let Entry::Mapped(mapped) = mapping[k]
            && mapped.index == object.index
            && mapped.sub == object.sub
        {
            return offset(mapping, k);
        }
        k += 1;
    }
    panic!("object is not in the mapping")
}
