//! The process data that a station is mapped to, as it says itself.

use drivers::wire::ethercat::EtherCatBus;

use super::arguments::Place;
use super::objects;

/// An object in the process data of a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mapped {
    pub(crate) index: u16,
    pub(crate) sub: u8,
    pub(crate) bits: usize,
    /// Where it begins.
    pub(crate) at_bit: usize,
}

/// The process data of a station.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    pub(crate) outputs: Vec<Mapped>,
    pub(crate) inputs: Vec<Mapped>,
}

impl Layout {
    /// Reads assignments (1C12h, 1C13h) and mappings.
    pub(crate) fn read(bus: &mut EtherCatBus, station: u16) -> Result<Self, String> {
        Ok(Self { outputs: entries(bus, station, 0x1C12)?, inputs: entries(bus, station, 0x1C13)? })
    }
}

fn entries(bus: &mut EtherCatBus, station: u16, assignment: u16) -> Result<Vec<Mapped>, String> {
    let mut found = Vec::new();
    let mut at_bit = 0;
    for pdo in list(bus, station, assignment)? {
        // A PDO's index has 16 bits.
        for word in list(bus, station, pdo as u16)? {
            let bits = (word & 0xFF) as usize;
            found.push(Mapped { index: (word >> 16) as u16, sub: (word >> 8) as u8, bits, at_bit });
            at_bit += bits;
        }
    }
    Ok(found)
}

/// The entries of an object whose sub-index 0 is their number.
fn list(bus: &mut EtherCatBus, station: u16, index: u16) -> Result<Vec<u32>, String> {
    let count = objects::read_u32(bus, station, Place { index, sub: 0 })?;
    // The number is one byte.
    (1..=count as u8).map(|sub| objects::read_u32(bus, station, Place { index, sub })).collect()
}

/// One line: each object with its width.
pub(crate) fn text(entries: &[Mapped]) -> String {
    let texts: Vec<_> = entries
        .iter()
        .map(|&Mapped { index, sub, bits, .. }| match (index, sub) {
            (0, _) => format!("({bits})"),
            (_, 0) => format!("{index:04X}h ({bits})"),
            _ => format!("{index:04X}h:{sub:02X} ({bits})"),
        })
        .collect();
    let bytes = entries.iter().map(|entry| entry.bits).sum::<usize>().div_ceil(8);
    format!("{bytes} bytes: {}", texts.join(" "))
}

/// Where a whole-byte object lies; `None` if it is not mapped so.
fn bytes_of(entries: &[Mapped], index: u16) -> Option<std::ops::Range<usize>> {
    let entry = entries.iter().find(|entry| entry.index == index && entry.sub == 0)?;
    let is_whole = entry.at_bit.is_multiple_of(8) && entry.bits.is_multiple_of(8) && entry.bits <= 32;
    is_whole.then(|| entry.at_bit / 8..(entry.at_bit + entry.bits) / 8)
}

/// Whether an object can be reached by [`get`] and [`put`].
pub(crate) fn has(entries: &[Mapped], index: u16) -> bool {
    bytes_of(entries, index).is_some()
}

/// The bits of an object in a station's bytes.
pub(crate) fn get(entries: &[Mapped], index: u16, bytes: &[u8]) -> Option<u32> {
    let found = bytes.get(bytes_of(entries, index)?)?;
    Some(found.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte)))
}

/// Puts the bits of an object into a station's bytes; nothing where it is not mapped.
pub(crate) fn put(entries: &[Mapped], index: u16, value: u32, bytes: &mut [u8]) {
    if let Some(place) = bytes_of(entries, index).and_then(|range| bytes.get_mut(range)) {
        let count = place.len();
        place.copy_from_slice(&value.to_le_bytes()[..count]);
    }
}
