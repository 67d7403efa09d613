//! PDO mappings: which object lies at which byte of the process data of a drive.

use super::objects::Object;

/// One entry of a PDO mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Index of the object; 0 is padding.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
    /// Width in bits.
    pub bits: u8,
}

impl Entry {
    /// One byte of padding.
    pub const PADDING: Self = Self { index: 0, sub: 0, bits: 8 };

    /// An object in its full width; `None` for a text, which cannot be mapped.
    pub const fn of(object: Object) -> Option<Self> {
        match object.data_type.bytes() {
            Some(bytes) => Some(Self { index: object.index, sub: object.sub, bits: 8 * bytes as u8 }),
            None => None,
        }
    }

    /// The mapping word of 1600h and 1A00h: index << 16 | sub << 8 | bits.
    pub(super) const fn word(self) -> u32 {
        (self.index as u32) << 16 | (self.sub as u32) << 8 | self.bits as u32
    }

    /// The entry of a mapping word.
    pub(super) const fn of_word(word: u32) -> Self {
        Self { index: (word >> 16) as u16, sub: (word >> 8) as u8, bits: word as u8 }
    }

    /// Width in bytes.
    pub(crate) fn bytes(self) -> usize {
        usize::from(self.bits).div_ceil(8)
    }

    fn is_padding(self) -> bool {
        self.index == 0
    }
}

/// Where the objects of one direction lie, by the mapping that the drive has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Layout {
    /// Entries without padding, each with its first bit.
    entries: Vec<(Entry, usize)>,
    bits: usize,
}

impl Layout {
    /// Adds an entry at the end.
    pub(super) fn push(&mut self, entry: Entry) {
        if !entry.is_padding() {
            self.entries.push((entry, self.bits));
        }
        self.bits += usize::from(entry.bits);
    }

    /// Length, padding included.
    pub(super) fn bytes(&self) -> usize {
        self.bits.div_ceil(8)
    }

    /// First byte of an object; `None` where it is not mapped in its full width on a byte boundary.
    pub(super) fn find(&self, object: Object) -> Option<usize> {
        let wanted = Entry::of(object)?;
        let (_, bit) = self.entries.iter().find(|(entry, bit)| *entry == wanted && bit % 8 == 0)?;
        Some(bit / 8)
    }

    /// Entries in order, without padding.
    pub(super) fn entries(&self) -> impl Iterator<Item = Entry> {
        self.entries.iter().map(|(entry, _)| *entry)
    }
}
