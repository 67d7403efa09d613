//! PDO mapping (1600h…, 1A00h…) and assignment (1C12h, 1C13h): what lies where in the process data.

use super::dictionary::{Dictionary, OBJECTS, Pdo, Width, abort};

/// PDOs each way of a drive whose mappings can be written, and how many of them can be assigned.
const PDOS: u16 = 4;
/// How many PDOs a drive with fixed mappings can be assigned.
const MOST_FIXED: usize = 16;
/// Entries of one PDO.
const ENTRIES: usize = 16;
/// Largest PDO, bits.
const LARGEST_PDO_BITS: u32 = 8 * 64;

/// A mapping as after power-up.
const DEFAULT_OUTPUTS: [u32; 5] = [0x6040_0010, 0x6071_0010, 0x60FF_0020, 0x6060_0008, 0x0000_0008];
/// Likewise.
const DEFAULT_INPUTS: [u32; 4] = [0x6041_0010, 0x6064_0020, 0x606C_0020, 0x6077_0010];

/// One object's place in the process data of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// Position of the object in the dictionary.
    pub(crate) slot: usize,
    /// First byte.
    pub(crate) offset: usize,
    /// Coding.
    pub(crate) width: Width,
}

/// Process data of one direction.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Objects in order of their place.
    pub(crate) places: Vec<Place>,
    /// Length, padding included.
    pub(crate) bytes: usize,
}

/// A list whose sub-index 0 is its count.
#[derive(Clone, Debug)]
struct List {
    count: usize,
    /// As many as there is room for.
    entries: Vec<u32>,
}

/// PDOs of one direction and which of them are assigned.
#[derive(Clone, Debug)]
pub(crate) struct Mapping {
    direction: Pdo,
    assignment: u16,
    /// PDOs with their indices.
    pdos: Vec<(u16, List)>,
    /// Whether the mappings of the PDOs can only be read.
    is_fixed: bool,
    assigned: List,
}

impl Mapping {
    /// Host to drive.
    pub(crate) fn outputs() -> Self {
        Self::new(Pdo::Output, 0x1600, 0x1C12, &DEFAULT_OUTPUTS)
    }

    /// Drive to host.
    pub(crate) fn inputs() -> Self {
        Self::new(Pdo::Input, 0x1A00, 0x1C13, &DEFAULT_INPUTS)
    }

    fn new(direction: Pdo, first_pdo: u16, assignment: u16, first: &[u32]) -> Self {
        let mut pdos: Vec<(u16, List)> =
            (first_pdo..first_pdo + PDOS).map(|index| (index, List::with_room(ENTRIES))).collect();
        pdos[0].1.fill(first);
        let mut assigned = List::with_room(usize::from(PDOS));
        assigned.fill(&[u32::from(first_pdo)]);
        Self { direction, assignment, pdos, is_fixed: false, assigned }
    }

    /// PDOs whose mappings can only be read; the first of them is assigned after power-up.
    pub(super) fn fixed(direction: Pdo, assignment: u16, pdos: &[(u16, &[u32])]) -> Self {
        let list = |words: &[u32]| List { count: words.len(), entries: words.to_vec() };
        let mut assigned = List::with_room(MOST_FIXED);
        assigned.fill(&pdos.first().map(|(index, _)| u32::from(*index)).into_iter().collect::<Vec<_>>());
        let pdos = pdos.iter().map(|(index, words)| (*index, list(words))).collect();
        Self { direction, assignment, pdos, is_fixed: true, assigned }
    }

    /// Whether an index belongs here.
    pub(crate) fn owns(&self, index: u16) -> bool {
        index == self.assignment || self.pdo(index).is_some()
    }

    fn pdo(&self, index: u16) -> Option<usize> {
        self.pdos.iter().position(|(own, _)| *own == index)
    }

    /// All indices that belong here.
    pub(crate) fn indices(&self) -> impl Iterator<Item = u16> {
        self.pdos.iter().map(|(index, _)| *index).chain([self.assignment])
    }

    /// Objects of the PDOs that are assigned: index of the PDO, its mapping words.
    pub(crate) fn assigned(&self) -> impl Iterator<Item = (u16, &[u32])> {
        self.assigned.entries[..self.assigned.count].iter().filter_map(|&pdo| {
            let index = u16::try_from(pdo).ok()?;
            let (_, pdo) = &self.pdos[self.pdo(index)?];
            Some((index, &pdo.entries[..pdo.count]))
        })
    }

    /// Answers an SDO upload of an index that belongs here.
    pub(crate) fn upload(&self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        match self.pdo(index) {
            Some(k) => self.pdos[k].1.upload(sub, 4),
            None => self.assigned.upload(sub, 2),
        }
    }

    /// Answers an SDO download of an index that belongs here.
    pub(crate) fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<(), u32> {
        let Some(k) = self.pdo(index) else {
            let known: Vec<u32> = self.pdos.iter().map(|(index, _)| u32::from(*index)).collect();
            return self.assigned.download(sub, data, 2, |pdo| {
                if known.contains(&pdo) { Ok(()) } else { Err(abort::INVALID_VALUE) }
            });
        };
        if self.is_fixed {
            return Err(abort::READ_ONLY);
        }
        let direction = self.direction;
        let pdo = &mut self.pdos[k].1;
        if sub == 0 && data.len() == 1 && usize::from(data[0]) <= ENTRIES {
            pdo.check_length(usize::from(data[0]))?;
        }
        pdo.download(sub, data, 4, |word| mapped(word, direction).map(|_| ()))
    }

    /// Where everything lies, or the abort code that names what is wrong.
    pub(crate) fn layout(&self) -> Result<Layout, u32> {
        let mut layout = Layout::default();
        let mut bits = 0;
        for &pdo in &self.assigned.entries[..self.assigned.count] {
            let k = self.pdo(pdo as u16).ok_or(abort::INVALID_VALUE)?;
            let (_, pdo) = &self.pdos[k];
            for &word in &pdo.entries[..pdo.count] {
                if let Some(slot) = mapped(word, self.direction)? {
                    // Objects on byte boundaries only: a drive that packs bits across bytes is not what this is.
                    let offset =
                        if bits % 8 == 0 { bits as usize / 8 } else { return Err(abort::NOT_MAPPABLE) };
                    layout.places.push(Place { slot, offset, width: OBJECTS[slot].width });
                }
                bits += word & 0xFF;
            }
        }
        layout.bytes = bits.div_ceil(8) as usize;
        Ok(layout)
    }
}

/// The object that a mapping word names, `None` for padding.
fn mapped(word: u32, direction: Pdo) -> Result<Option<usize>, u32> {
    let index = (word >> 16) as u16;
    let sub = (word >> 8) as u8;
    let bits = word & 0xFF;
    if index == 0 {
        return if (1..=64).contains(&bits) { Ok(None) } else { Err(abort::NOT_MAPPABLE) };
    }
    let slot = Dictionary::find(index, sub)?;
    let object = &OBJECTS[slot];
    let fits = object.pdo == direction && bits == 8 * object.width.bytes() as u32;
    if fits { Ok(Some(slot)) } else { Err(abort::NOT_MAPPABLE) }
}

impl List {
    /// An empty list with room for so many entries.
    fn with_room(entries: usize) -> Self {
        Self { count: 0, entries: vec![0; entries] }
    }

    /// Puts these entries in; there is room for them.
    fn fill(&mut self, entries: &[u32]) {
        self.count = entries.len();
        self.entries[..entries.len()].copy_from_slice(entries);
    }

    fn upload(&self, sub: u8, entry_bytes: usize) -> Result<Vec<u8>, u32> {
        match usize::from(sub) {
            0 => Ok(vec![self.count as u8]),
            k if k <= self.entries.len() => Ok(self.entries[k - 1].to_le_bytes()[..entry_bytes].to_vec()),
            _ => Err(abort::NO_SUB_INDEX),
        }
    }

    fn download(
        &mut self,
        sub: u8,
        data: &[u8],
        entry_bytes: usize,
        check: impl Fn(u32) -> Result<(), u32>,
    ) -> Result<(), u32> {
        let k = usize::from(sub);
        if k > self.entries.len() {
            return Err(abort::NO_SUB_INDEX);
        }
        if data.len() != if k == 0 { 1 } else { entry_bytes } {
            return Err(abort::LENGTH);
        }
        let value = data.iter().rev().fold(0_u32, |value, &byte| value << 8 | u32::from(byte));
        if k == 0 {
            let count = value as usize;
            if count > self.entries.len() {
                return Err(abort::TOO_HIGH);
            }
            self.entries[..count].iter().try_for_each(|&entry| check(entry))?;
            self.count = count;
        } else {
            if self.count != 0 {
                return Err(abort::COUNT_NOT_ZERO);
            }
            check(value)?;
            self.entries[k - 1] = value;
        }
        Ok(())
    }

    fn check_length(&self, count: usize) -> Result<(), u32> {
        let bits: u32 = self.entries[..count].iter().map(|word| word & 0xFF).sum();
        if bits > LARGEST_PDO_BITS { Err(abort::PDO_TOO_LONG) } else { Ok(()) }
    }
}
