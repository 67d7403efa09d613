//! Typed access to one drive's object dictionary: every failure names device, object, expected and found.

use std::time::Duration;

use super::objects::{DataType, Object};
use crate::device::DeviceError;
use crate::wire::{SdoAbort, SdoRequest, SdoWire};

/// Longest wait for the answer to a transfer (safety.md: deadlines).
const TIMEOUT: Duration = Duration::from_secs(1);
/// SDO protocol timed out (CiA 301).
const TIMED_OUT: SdoAbort = SdoAbort(0x0504_0000);

/// Time for dialogues before the tick.
pub struct Waiting<'a> {
    /// Time since the start of the run.
    pub now: Duration,
    /// Lets a little time pass; gives the time after that.
    pub pause: &'a mut dyn FnMut() -> Duration,
}

/// A transfer that goes on from tick to tick.
#[derive(Clone, Debug, Default)]
pub(super) struct Transfer {
    /// When it was begun; `None` while none is under way.
    begun: Option<Duration>,
    answer: Vec<u8>,
}

impl Transfer {
    /// Begins to read an object, or to write it.
    pub(super) fn start(&mut self, wire: &mut dyn SdoWire, now: Duration, request: &SdoRequest<'_>) {
        wire.start(now, request);
        self.begun = Some(now);
    }

    /// What the station answered, once it has; nothing after a transfer that wrote.
    pub(super) fn poll(&mut self, wire: &mut dyn SdoWire, now: Duration) -> Result<Option<&[u8]>, SdoAbort> {
        let begun = self.begun.unwrap_or(now);
        self.answer.clear();
        match wire.poll(now, &mut self.answer) {
            Ok(true) => {
                self.begun = None;
                Ok(Some(&self.answer))
            }
            Ok(false) if now.saturating_sub(begun) > TIMEOUT => Err(TIMED_OUT),
            Ok(false) => Ok(None),
            Err(abort) => Err(abort),
        }
    }
}

/// One drive's dictionary, reached over a wire.
pub(crate) struct Dictionary<'a, 'w> {
    pub(crate) wire: &'a mut dyn SdoWire,
    pub(crate) waiting: &'a mut Waiting<'w>,
    pub(crate) device: &'a str,
    pub(crate) station: u16,
}

impl Dictionary<'_, '_> {
    /// Reads a number of exactly the object's width.
    pub(crate) fn read(&mut self, object: Object) -> Result<i64, DeviceError> {
        let bytes = self.upload(object)?;
        number(object.data_type, &bytes).ok_or_else(|| {
            let expected = match object.data_type.bytes() {
                Some(width) => format!("{} bits", 8 * width),
                None => "a number".to_owned(),
            };
            let found = format!("{} bits {bytes:02X?}", 8 * bytes.len());
            self.mismatch(
                object,
                expected,
                found,
                "the drive's object has another type: check drive type and firmware",
            )
        })
    }

    /// Reads a number that does not fit into more than 32 unsigned bits.
    pub(crate) fn read_u32(&mut self, object: Object) -> Result<u32, DeviceError> {
        let value = self.read(object)?;
        u32::try_from(value).map_err(|_| {
            let help = "check drive type and firmware";
            self.mismatch(object, "0 to 4294967295".to_owned(), value.to_string(), help)
        })
    }

    /// Reads a text; bytes from the first NUL on do not count.
    pub(super) fn read_text(&mut self, object: Object) -> Result<String, DeviceError> {
        let bytes = self.upload(object)?;
        let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
        Ok(String::from_utf8_lossy(&bytes[..end]).trim().to_owned())
    }

    /// Writes a number in the object's width.
    pub(super) fn write(&mut self, object: Object, value: i64) -> Result<(), DeviceError> {
        let width = object.data_type.bytes().unwrap_or(0);
        let bytes = value.to_le_bytes();
        self.transfer(object, Some(&bytes[..width])).map(|_| ())
    }

    /// Writes a number and reads it back.
    pub(crate) fn write_checked(&mut self, object: Object, value: i64) -> Result<(), DeviceError> {
        self.write(object, value)?;
        self.expect(
            object,
            value,
            "the drive did not accept the written value: check its parameter locks and limits",
        )
    }

    /// Reads a number that must have a given value.
    pub(super) fn expect(
        &mut self,
        object: Object,
        value: i64,
        help: &'static str,
    ) -> Result<(), DeviceError> {
        let found = self.read(object)?;
        if found == value {
            return Ok(());
        }
        Err(self.mismatch(object, with_unit(value, object), with_unit(found, object), help))
    }

    /// The error for an object that is not what it must be.
    pub(crate) fn mismatch(
        &self,
        object: Object,
        expected: String,
        found: String,
        help: &'static str,
    ) -> DeviceError {
        mismatch(self.device, object, [expected, found], help)
    }

    fn upload(&mut self, object: Object) -> Result<Vec<u8>, DeviceError> {
        self.transfer(object, None)
    }

    fn transfer(&mut self, object: Object, write: Option<&[u8]>) -> Result<Vec<u8>, DeviceError> {
        let request = SdoRequest { station: self.station, index: object.index, sub: object.sub, write };
        let mut transfer = Transfer::default();
        transfer.start(self.wire, self.waiting.now, &request);
        loop {
            match transfer.poll(self.wire, self.waiting.now) {
                Ok(Some(answer)) => return Ok(answer.to_vec()),
                Ok(None) => self.waiting.now = (self.waiting.pause)(),
                Err(abort) => return Err(aborted(self.device, object, abort)),
            }
        }
    }
}

/// The error for an object that is not what it must be; what was expected, then what was found.
pub(super) fn mismatch(
    device: &str,
    object: Object,
    [expected, found]: [String; 2],
    help: &'static str,
) -> DeviceError {
    let Object { index, sub, name, .. } = object;
    DeviceError::Mismatch { device: device.to_owned(), index, sub, name, expected, found, help }
}

/// The error for a transfer that the station aborted.
pub(super) fn aborted(device: &str, object: Object, SdoAbort(code): SdoAbort) -> DeviceError {
    let Object { index, sub, name, .. } = object;
    DeviceError::Abort { device: device.to_owned(), index, sub, name, code, meaning: abort_meaning(code) }
}

pub(super) fn with_unit(value: i64, object: Object) -> String {
    if object.unit.is_empty() { value.to_string() } else { format!("{value} ({})", object.unit) }
}

/// Decodes a little-endian number; `None` unless the bytes have exactly its width.
pub(super) fn number(data_type: DataType, bytes: &[u8]) -> Option<i64> {
    match (data_type, bytes) {
        (DataType::I8, &[a]) => Some(i64::from(i8::from_le_bytes([a]))),
        (DataType::U8, &[a]) => Some(i64::from(a)),
        (DataType::I16, &[a, b]) => Some(i64::from(i16::from_le_bytes([a, b]))),
        (DataType::U16, &[a, b]) => Some(i64::from(u16::from_le_bytes([a, b]))),
        (DataType::I32, &[a, b, c, d]) => Some(i64::from(i32::from_le_bytes([a, b, c, d]))),
        (DataType::U32, &[a, b, c, d]) => Some(i64::from(u32::from_le_bytes([a, b, c, d]))),
        _ => None,
    }
}

/// What an SDO abort code means (CiA 301).
pub fn abort_meaning(code: u32) -> &'static str {
    ABORTS.iter().find(|(known, _)| *known == code).map_or("unknown abort code", |(_, meaning)| meaning)
}

const ABORTS: &[(u32, &str)] = &[
    (0x0503_0000, "toggle bit not alternated"),
    (0x0504_0000, "SDO timed out"),
    (0x0504_0001, "unknown SDO command"),
    (0x0601_0000, "access not supported"),
    (0x0601_0001, "object is write-only"),
    (0x0601_0002, "object is read-only"),
    (0x0602_0000, "no such object"),
    (0x0604_0041, "object cannot be mapped"),
    (0x0604_0042, "mapping is longer than the PDO"),
    (0x0604_0043, "parameter incompatible"),
    (0x0606_0000, "hardware error"),
    (0x0607_0010, "length does not match the data type"),
    (0x0607_0012, "too long for the data type"),
    (0x0607_0013, "too short for the data type"),
    (0x0609_0011, "no such sub-index"),
    (0x0609_0030, "value not allowed"),
    (0x0609_0031, "value too high"),
    (0x0609_0032, "value too low"),
    (0x0800_0000, "general error"),
    (0x0800_0020, "cannot be transferred or stored"),
    (0x0800_0021, "refused: local control"),
    (0x0800_0022, "refused in the present device state"),
];
