//! Object dictionary of the simulated drive: widths, access, ranges and values, and the SDO server on top.

use Access::{ReadOnly, ReadWrite};
use Pdo::{Input, Neither, Output};
use Width::{I8, I16, I32, U8, U16, U32};

/// SDO abort codes of CiA 301.
pub(crate) mod abort {
    pub(crate) const READ_ONLY: u32 = 0x0601_0002;
    pub(crate) const COUNT_NOT_ZERO: u32 = 0x0601_0003;
    pub(crate) const NO_OBJECT: u32 = 0x0602_0000;
    pub(crate) const NOT_MAPPABLE: u32 = 0x0604_0041;
    pub(crate) const PDO_TOO_LONG: u32 = 0x0604_0042;
    pub(crate) const LENGTH: u32 = 0x0607_0010;
    pub(crate) const NO_SUB_INDEX: u32 = 0x0609_0011;
    pub(crate) const INVALID_VALUE: u32 = 0x0609_0030;
    pub(crate) const TOO_HIGH: u32 = 0x0609_0031;
    pub(crate) const TOO_LOW: u32 = 0x0609_0032;
    pub(crate) const DEVICE_STATE: u32 = 0x0800_0022;
}

/// Coding of a number, little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub(crate) enum Width {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
}

impl Width {
    pub(crate) const fn bytes(self) -> usize {
        match self {
            I8 | U8 => 1,
            I16 | U16 => 2,
            I32 | U32 => 4,
        }
    }

    /// Smallest and largest value.
    pub(crate) const fn range(self) -> (i64, i64) {
        let bits = 8 * self.bytes() as u32;
        match self {
            I8 | I16 | I32 => (-(1 << (bits - 1)), (1 << (bits - 1)) - 1),
            U8 | U16 | U32 => (0, (1 << bits) - 1),
        }
    }

    /// A value from its bytes; `bytes` is as long as the width says.
    pub(crate) fn decode(self, bytes: &[u8]) -> i64 {
        let raw = bytes.iter().rev().fold(0_i64, |value, &byte| value << 8 | i64::from(byte));
        let (_, largest) = self.range();
        if raw > largest { raw - (1 << (8 * self.bytes())) } else { raw }
    }

    /// Writes a value into its bytes.
    pub(crate) fn encode(self, value: i64, bytes: &mut [u8]) {
        let count = self.bytes();
        bytes[..count].copy_from_slice(&value.to_le_bytes()[..count]);
    }
}

/// SDO access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Access {
    ReadOnly,
    ReadWrite,
}

/// Whether an object may lie in the process data, and which way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pdo {
    /// Not mappable.
    Neither,
    /// Host to drive.
    Output,
    /// Drive to host.
    Input,
}

/// One object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Object {
    pub(crate) index: u16,
    pub(crate) sub: u8,
    pub(crate) width: Width,
    access: Access,
    pub(crate) pdo: Pdo,
    initial: i64,
    /// The only values allowed, or all of the width if empty.
    only: &'static [i64],
}

const fn constant(index: u16, sub: u8, width: Width, initial: i64) -> Object {
    Object { index, sub, width, access: ReadOnly, pdo: Neither, initial, only: &[] }
}

const fn input(index: u16, width: Width) -> Object {
    Object { index, sub: 0, width, access: ReadOnly, pdo: Input, initial: 0, only: &[] }
}

const fn output(index: u16, width: Width) -> Object {
    Object { index, sub: 0, width, access: ReadWrite, pdo: Output, initial: 0, only: &[] }
}

const fn setting(index: u16, sub: u8, width: Width, initial: i64) -> Object {
    Object { index, sub, width, access: ReadWrite, pdo: Neither, initial, only: &[] }
}

const fn option(index: u16, initial: i64, only: &'static [i64]) -> Object {
    Object { index, sub: 0, width: I16, access: ReadWrite, pdo: Neither, initial, only }
}

const fn mode(index: u16, only: &'static [i64]) -> Object {
    Object { index, sub: 0, width: I8, access: ReadWrite, pdo: Output, initial: 10, only }
}

/// Vendor id 1018h:1, the letters SIM: no real vendor has it.
const VENDOR: i64 = 0x0053_494D;

/// All numbers, in order of index and sub-index; texts and mappings stand apart.
#[rustfmt::skip]
pub(crate) const OBJECTS: [Object; 51] = [
    constant(0x1000, 0, U32, 0x0002_0192), // servo drive, profile 402
    input(0x1001, U8),
    constant(0x1018, 0, U8, 4), constant(0x1018, 1, U32, VENDOR), constant(0x1018, 2, U32, 0x402),
    constant(0x1018, 3, U32, 0x0001_0000), constant(0x1018, 4, U32, 0),
    input(0x22A3, I16),            // heat sink, 0.1 °C
    setting(0x2F00, 0, U16, 1000), // process data watchdog, 100 µs
    option(0x6007, 1, &[0, 1, 2, 3]),
    input(0x603F, U16),
    output(0x6040, U16),
    input(0x6041, U16),
    option(0x605A, 2, &[0, 1, 2, 3, 5, 6, 7]),
    option(0x605B, 0, &[0, 1]),
    option(0x605C, 1, &[0, 1]),
    option(0x605D, 1, &[1]),       // halt is ignored
    option(0x605E, 2, &[0, 1, 2, 3]),
    mode(0x6060, &[9, 10]),
    input(0x6061, I8),
    input(0x6063, I32),
    input(0x6064, I32),
    setting(0x6065, 0, U32, 0xFFFF_FFFF),
    setting(0x6066, 0, U16, 0),
    input(0x606C, I32),
    output(0x6071, I16),
    setting(0x6072, 0, U16, 0), setting(0x6073, 0, U16, 0),
    input(0x6074, I16),
    constant(0x6075, 0, U32, 0), constant(0x6076, 0, U32, 0),
    input(0x6077, I16), input(0x6078, I16), input(0x6079, U32),
    constant(0x607D, 0, U8, 2), setting(0x607D, 1, I32, i32::MIN as i64), setting(0x607D, 2, I32, i32::MAX as i64),
    setting(0x6080, 0, U32, 0xFFFF_FFFF),
    setting(0x6084, 0, U32, 16_777_216), setting(0x6085, 0, U32, 16_777_216), // 90 °/s² at 26 bit
    constant(0x608F, 0, U8, 2), constant(0x608F, 1, U32, 0), constant(0x608F, 2, U32, 1),
    output(0x60B1, I32), output(0x60B2, I16),
    constant(0x60C2, 0, U8, 2), setting(0x60C2, 1, U8, 1), setting(0x60C2, 2, I8, -3),
    input(0x60FD, U32),
    output(0x60FF, I32),
    constant(0x6502, 0, U32, 0x300), // CSV and CST
];

/// Texts: device name, hardware version, firmware.
const TEXTS: [(u16, &str); 3] =
    [(0x1008, "SIM servo drive"), (0x1009, "SIM 1"), (0x100A, concat!("SIM ", env!("CARGO_PKG_VERSION")))];

/// Position of an object in the table, at compile time.
const fn slot(index: u16, sub: u8) -> usize {
    let mut k = 0;
    while k < OBJECTS.len() {
        if OBJECTS[k].index == index && OBJECTS[k].sub == sub {
            return k;
        }
        k += 1;
    }
    panic!("object is not in the table")
}

/// Positions of the objects that the drive itself uses.
pub(crate) mod at {
    use super::slot;
    pub(crate) const ERROR_REGISTER: usize = slot(0x1001, 0);
    pub(crate) const VENDOR: usize = slot(0x1018, 1);
    pub(crate) const PRODUCT: usize = slot(0x1018, 2);
    pub(crate) const REVISION: usize = slot(0x1018, 3);
    pub(crate) const SERIAL: usize = slot(0x1018, 4);
    pub(crate) const HEAT_SINK: usize = slot(0x22A3, 0);
    pub(crate) const WATCHDOG: usize = slot(0x2F00, 0);
    pub(crate) const ABORT_CONNECTION: usize = slot(0x6007, 0);
    pub(crate) const ERROR_CODE: usize = slot(0x603F, 0);
    pub(crate) const CONTROLWORD: usize = slot(0x6040, 0);
    pub(crate) const STATUSWORD: usize = slot(0x6041, 0);
    pub(crate) const QUICK_STOP: usize = slot(0x605A, 0);
    pub(crate) const SHUTDOWN: usize = slot(0x605B, 0);
    pub(crate) const DISABLE: usize = slot(0x605C, 0);
    pub(crate) const FAULT_REACTION: usize = slot(0x605E, 0);
    pub(crate) const MODE: usize = slot(0x6060, 0);
    pub(crate) const MODE_DISPLAY: usize = slot(0x6061, 0);
    pub(crate) const POSITION_INTERNAL: usize = slot(0x6063, 0);
    pub(crate) const POSITION: usize = slot(0x6064, 0);
    pub(crate) const VELOCITY: usize = slot(0x606C, 0);
    pub(crate) const TARGET_TORQUE: usize = slot(0x6071, 0);
    pub(crate) const MAX_TORQUE: usize = slot(0x6072, 0);
    pub(crate) const MAX_CURRENT: usize = slot(0x6073, 0);
    pub(crate) const TORQUE_DEMAND: usize = slot(0x6074, 0);
    pub(crate) const RATED_CURRENT: usize = slot(0x6075, 0);
    pub(crate) const RATED_TORQUE: usize = slot(0x6076, 0);
    pub(crate) const TORQUE: usize = slot(0x6077, 0);
    pub(crate) const CURRENT: usize = slot(0x6078, 0);
    pub(crate) const DC_LINK: usize = slot(0x6079, 0);
    pub(crate) const SOFT_LIMIT_MIN: usize = slot(0x607D, 1);
    pub(crate) const SOFT_LIMIT_MAX: usize = slot(0x607D, 2);
    pub(crate) const MAX_SPEED: usize = slot(0x6080, 0);
    pub(crate) const SLOW_DOWN_DECELERATION: usize = slot(0x6084, 0);
    pub(crate) const QUICK_STOP_DECELERATION: usize = slot(0x6085, 0);
    pub(crate) const ENCODER_COUNTS: usize = slot(0x608F, 1);
    pub(crate) const VELOCITY_OFFSET: usize = slot(0x60B1, 0);
    pub(crate) const TORQUE_OFFSET: usize = slot(0x60B2, 0);
    pub(crate) const DIGITAL_INPUTS: usize = slot(0x60FD, 0);
    pub(crate) const TARGET_VELOCITY: usize = slot(0x60FF, 0);
}

/// The values of all objects.
#[derive(Clone, Debug)]
pub(crate) struct Dictionary {
    values: [i64; OBJECTS.len()],
}

impl Dictionary {
    /// As after power-up.
    pub(crate) fn new() -> Self {
        Self { values: OBJECTS.map(|object| object.initial) }
    }

    /// Finds an object, or says with which abort code it cannot be found.
    pub(crate) fn find(index: u16, sub: u8) -> Result<usize, u32> {
        let place = OBJECTS.binary_search_by_key(&(index, sub), |object| (object.index, object.sub));
        place.map_err(|_| {
            let known = OBJECTS.iter().any(|object| object.index == index) || text(index).is_some();
            if known { abort::NO_SUB_INDEX } else { abort::NO_OBJECT }
        })
    }

    /// The value at a position.
    #[inline]
    pub(crate) fn get(&self, slot: usize) -> i64 {
        self.values[slot]
    }

    /// Sets a value, saturated to what the object can hold.
    #[inline]
    pub(crate) fn put(&mut self, slot: usize, value: i64) {
        let (smallest, largest) = OBJECTS[slot].width.range();
        self.values[slot] = value.clamp(smallest, largest);
    }

    /// Indices of all objects, in no order, lists once.
    pub(crate) fn indices() -> impl Iterator<Item = u16> {
        let numbers = OBJECTS.iter().filter(|object| object.sub == 0).map(|object| object.index);
        numbers.chain(TEXTS.iter().map(|(index, _)| *index))
    }

    /// Answers an SDO upload.
    pub(crate) fn upload(&self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        if let (Some(text), 0) = (text(index), sub) {
            return Ok(text.as_bytes().to_vec());
        }
        let slot = Self::find(index, sub)?;
        let width = OBJECTS[slot].width;
        Ok(self.values[slot].to_le_bytes()[..width.bytes()].to_vec())
    }

    /// Answers an SDO download.
    pub(crate) fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<(), u32> {
        if text(index).is_some() && sub == 0 {
            return Err(abort::READ_ONLY);
        }
        let slot = Self::find(index, sub)?;
        let object = &OBJECTS[slot];
        if object.access == ReadOnly {
            return Err(abort::READ_ONLY);
        }
        if data.len() != object.width.bytes() {
            return Err(abort::LENGTH);
        }
        let value = object.width.decode(data);
        object.check(value)?;
        self.values[slot] = value;
        Ok(())
    }
}

/// An object as the table has it.
pub(crate) fn object(index: u16, sub: u8) -> Option<&'static Object> {
    Dictionary::find(index, sub).ok().map(|slot| &OBJECTS[slot])
}

impl Object {
    /// Whether SDO may write it.
    pub(crate) fn is_writable(&self) -> bool {
        self.access == ReadWrite
    }

    /// Whether the object takes this value.
    pub(crate) fn check(&self, value: i64) -> Result<(), u32> {
        match (self.only.first(), self.only.last()) {
            (Some(&smallest), _) if value < smallest => Err(abort::TOO_LOW),
            (_, Some(&largest)) if value > largest => Err(abort::TOO_HIGH),
            (Some(_), _) if !self.only.contains(&value) => Err(abort::INVALID_VALUE),
            _ => Ok(()),
        }
    }
}

fn text(index: u16) -> Option<&'static str> {
    TEXTS.iter().find(|(of, _)| *of == index).map(|(_, text)| *text)
}
