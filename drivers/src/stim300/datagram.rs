//! Datagrams: identifiers, lengths and the layout of measurements (TS1524 rev. 31, tables 5-20 to 5-22).
//!
//! All fields are big-endian. The first byte says what follows; there is no other header, and its value may occur anywhere in a
//! datagram.

use crate::crc32::{crc32, crc32_from};

/// Bytes of the checksum.
const CRC_BYTES: usize = 4;
/// Longest of all datagrams: F7h and AFh.
pub(super) const LONGEST_DATAGRAM: usize = 63;

/// The last field of a measurement datagram.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Input {
    /// No such field.
    #[default]
    None,
    /// Pulse-per-second input.
    Pps,
    /// Auxiliary voltage input of older units.
    Aux,
}

/// What a measurement datagram carries besides the angular rates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Content {
    /// Accelerometers.
    pub accelerometers: bool,
    /// Inclinometers.
    pub inclinometers: bool,
    /// Temperatures of all sensors that are present.
    pub temperatures: bool,
    /// Last field.
    pub input: Input,
}

/// Identifiers by content: accelerometers count 1, inclinometers 2, temperatures 4.
const PLAIN_IDS: [u8; 8] = [0x90, 0x91, 0x92, 0x93, 0x94, 0xA5, 0xA6, 0xA7];
const PPS_IDS: [u8; 8] = [0xF0, 0xF1, 0xF2, 0xF3, 0xF4, 0xF5, 0xF6, 0xF7];
const AUX_IDS: [u8; 8] = [0x98, 0x99, 0x9A, 0x9B, 0x9C, 0xAD, 0xAE, 0xAF];
/// Letters of the service mode command `d` in the same order (table 9-13); none for units with AUX.
const PLAIN_LETTERS: [char; 8] = ['0', '1', '2', '3', '4', '5', '6', '7'];
const PPS_LETTERS: [char; 8] = ['l', 'm', 'n', 'p', 'q', 'r', 's', 't'];

impl Content {
    fn from_place(place: usize, input: Input) -> Self {
        Self {
            accelerometers: place & 1 != 0,
            inclinometers: place & 2 != 0,
            temperatures: place & 4 != 0,
            input,
        }
    }

    fn place(self) -> usize {
        usize::from(self.accelerometers)
            | usize::from(self.inclinometers) << 1
            | usize::from(self.temperatures) << 2
    }

    /// What a measurement datagram with this identifier carries; `None` if it is no measurement.
    pub fn by_id(id: u8) -> Option<Self> {
        let find = |ids: &[u8; 8], input| {
            ids.iter().position(|&known| known == id).map(|place| Self::from_place(place, input))
        };
        find(&PLAIN_IDS, Input::None)
            .or_else(|| find(&PPS_IDS, Input::Pps))
            .or_else(|| find(&AUX_IDS, Input::Aux))
    }

    /// Identifier of the measurement datagram.
    pub fn id(self) -> u8 {
        match self.input {
            Input::None => PLAIN_IDS[self.place()],
            Input::Pps => PPS_IDS[self.place()],
            Input::Aux => AUX_IDS[self.place()],
        }
    }

    /// Letter that selects the datagram in service mode; `None` if the current firmware has none (AUX).
    pub(super) fn letter(self) -> Option<char> {
        match self.input {
            Input::None => Some(PLAIN_LETTERS[self.place()]),
            Input::Pps => Some(PPS_LETTERS[self.place()]),
            Input::Aux => None,
        }
    }

    /// Bytes of the datagram, identifier and checksum included, CR LF excluded.
    pub const fn bytes(self) -> usize {
        let sensors = 1 + self.accelerometers as usize + self.inclinometers as usize;
        let temperatures = if self.temperatures { 7 * sensors } else { 0 };
        let input = if matches!(self.input, Input::None) { 0 } else { 4 };
        1 + 10 * sensors + temperatures + input + 3 + CRC_BYTES
    }
}

/// Datagrams that replace measurement datagrams: at start-up and on request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpecialKind {
    /// Part number (`N`).
    PartNumber,
    /// Serial number (`I`).
    SerialNumber,
    /// Configuration (`C`).
    Configuration,
    /// Bias trim offsets (`T`).
    BiasTrim,
    /// Extended error information (`E`); reading it clears it.
    ExtendedError,
}

impl SpecialKind {
    /// Kinds of special datagrams in the order of the tables below.
    pub(super) const ALL: [Self; 5] =
        [Self::PartNumber, Self::SerialNumber, Self::Configuration, Self::BiasTrim, Self::ExtendedError];
    /// Identifiers without and with CR LF behind the datagram.
    const IDS: [[u8; 2]; 5] = [[0xB1, 0xB3], [0xB5, 0xB7], [0xBC, 0xBD], [0xD1, 0xD2], [0xBE, 0xBF]];
    const PAYLOAD_BYTES: [usize; 5] = [15, 15, 21, 35, 16];

    fn by_id(id: u8) -> Option<Self> {
        Self::IDS.iter().position(|ids| ids.contains(&id)).map(|place| Self::ALL[place])
    }

    /// Bytes between identifier and checksum (tables 5-13 to 5-18).
    pub(super) const fn payload_bytes(self) -> usize {
        Self::PAYLOAD_BYTES[self as usize]
    }

    /// Command that asks for it in Normal mode, without the CR that ends it (table 8-1).
    pub const fn letter(self) -> char {
        match self {
            Self::PartNumber => 'N',
            Self::SerialNumber => 'I',
            Self::Configuration => 'C',
            Self::BiasTrim => 'T',
            Self::ExtendedError => 'E',
        }
    }
}

/// What an identifier announces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Announced {
    Measurement(Content),
    Special(SpecialKind),
}

impl Announced {
    /// `None` if no datagram begins like this.
    pub(super) fn by_id(id: u8) -> Option<Self> {
        let special = || SpecialKind::by_id(id).map(Self::Special);
        Content::by_id(id).map(Self::Measurement).or_else(special)
    }

    /// Bytes of the datagram, identifier and checksum included, CR LF excluded.
    pub(super) const fn bytes(self) -> usize {
        match self {
            Self::Measurement(content) => content.bytes(),
            Self::Special(kind) => 1 + kind.payload_bytes() + CRC_BYTES,
        }
    }
}

/// Checksum of a datagram over identifier and payload. What is not a whole number of 32-bit words is filled up with zero bytes
/// behind the last byte (table 5-22); these are not sent. No capture of a real unit was at hand to check the place of the zero
/// bytes; datagrams 91h, 92h, F1h and F2h need none.
pub fn checksum(bytes: &[u8]) -> u32 {
    let dummies = bytes.len().next_multiple_of(4) - bytes.len();
    crc32_from(crc32(bytes), &[0; 3][..dummies])
}

/// Identifier and payload of a datagram whose checksum is right.
pub(super) fn checked(datagram: &[u8]) -> Option<&[u8]> {
    let (bytes, crc) = datagram.split_last_chunk::<CRC_BYTES>()?;
    (checksum(bytes) == u32::from_be_bytes(*crc)).then_some(bytes)
}

/// Three sensors of a kind, X, Y, Z, as sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Triad {
    /// Values in units of the last bit.
    pub counts: [i32; 3],
    /// Status byte.
    pub status: u8,
}

/// A measurement datagram whose checksum is right, in the units of the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measurement {
    /// What it carries.
    pub content: Content,
    /// Gyros.
    pub gyros: Triad,
    /// Accelerometers; all 0 if they are not part of it.
    pub accelerometers: Triad,
    /// Inclinometers; all 0 if they are not part of it.
    pub inclinometers: Triad,
    /// Temperatures of gyros, accelerometers, inclinometers; all 0 where they are not part of it.
    pub temperatures: [Triad; 3],
    /// PPS or AUX; 0 if it is not part of it.
    pub input: i32,
    /// Status byte of PPS or AUX.
    pub input_status: u8,
    /// Number of the internal sample, 2000 per second, modulo 256.
    pub counter: u8,
    /// Time from the sampling to the first bit, µs.
    pub latency_us: u16,
}

impl Measurement {
    /// Decodes what lies between identifier and checksum; `None` if it is not as long as the content needs.
    pub(super) fn decode(content: Content, payload: &[u8]) -> Option<Self> {
        let mut fields = Fields(payload);
        let mut measurement = Self { content, gyros: fields.triad()?, ..Self::default() };
        if content.accelerometers {
            measurement.accelerometers = fields.triad()?;
        }
        if content.inclinometers {
            measurement.inclinometers = fields.triad()?;
        }
        let present = [true, content.accelerometers, content.inclinometers];
        for (temperatures, is_present) in measurement.temperatures.iter_mut().zip(present) {
            if content.temperatures && is_present {
                *temperatures = fields.temperatures()?;
            }
        }
        if content.input != Input::None {
            measurement.input = fields.i24()?;
            measurement.input_status = fields.u8()?;
        }
        measurement.counter = fields.u8()?;
        measurement.latency_us = u16::from_be_bytes(fields.next()?);
        fields.0.is_empty().then_some(measurement)
    }
}

/// Fields that have not been read yet.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn next<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (field, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*field)
    }

    fn u8(&mut self) -> Option<u8> {
        self.next::<1>().map(|[byte]| byte)
    }

    fn i24(&mut self) -> Option<i32> {
        self.next().map(i24)
    }

    fn triad(&mut self) -> Option<Triad> {
        Some(Triad { counts: [self.i24()?, self.i24()?, self.i24()?], status: self.u8()? })
    }

    fn temperatures(&mut self) -> Option<Triad> {
        let counts: [[u8; 2]; 3] = [self.next()?, self.next()?, self.next()?];
        let counts = counts.map(|bytes| i32::from(i16::from_be_bytes(bytes)));
        Some(Triad { counts, status: self.u8()? })
    }
}

/// A signed number of 24 bits.
pub(super) fn i24([high, middle, low]: [u8; 3]) -> i32 {
    i32::from_be_bytes([high, middle, low, 0]) >> 8
}

/// The longest datagrams are as long as the constant says.
const _: () = assert!(
    Content { accelerometers: true, inclinometers: true, temperatures: true, input: Input::Pps }.bytes()
        == LONGEST_DATAGRAM
);
