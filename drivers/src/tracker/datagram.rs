//! The message of a tracker, 32 bytes, little-endian:
//!
//! | bytes | what |
//! | --- | --- |
//! | 0..4 | magic `VTRK` |
//! | 4 | version, 1 |
//! | 5 | source: 1 coarse, 2 fine |
//! | 6 | lock: 0 lost, 1 re-acquiring, 2 tracking |
//! | 7 | quality, 0 to 255 |
//! | 8..12 | frame counter, u32; dropped frames count |
//! | 12..20 | centre of the shutter on the camera's own clock, ns, u64 |
//! | 20..24, 24..28 | target offset x, y in pixels, f32 |
//! | 28..32 | CRC-32 (ISO-HDLC) of bytes 0..28 |

use std::time::Duration;

/// Length of a message.
pub const LENGTH: usize = 32;

const MAGIC: [u8; 4] = *b"VTRK";
/// Version of the message that is understood.
pub const VERSION: u8 = 1;
const CRC_AT: usize = 28;

/// Which camera a message comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Infrared, wide.
    Coarse,
    /// CCD behind the mirror, narrow.
    Fine,
}

/// What a tracker says of its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lock {
    /// No target in the field of view.
    #[default]
    Lost,
    /// Seen again, not yet measured.
    Reacquiring,
    /// Measured.
    Tracking,
}

/// One frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Frame counter.
    pub counter: u32,
    /// Centre of the shutter on the camera's own clock.
    pub stamp: Duration,
    /// Target offset along the rows of the image.
    pub x_px: f32,
    /// Target offset along its columns.
    pub y_px: f32,
    /// 0 to 1; the wire rounds it to 1/255.
    pub quality: f32,
    /// Whether the offset means something.
    pub lock: Lock,
}

/// Why a message was not understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DatagramFault {
    /// Not a message of this length.
    #[error("{0} bytes instead of {LENGTH}")]
    Length(usize),
    /// Not a tracker message of this version.
    #[error("magic or version differs")]
    Format,
    /// Damaged.
    #[error("CRC {found:08X}h, computed {computed:08X}h")]
    Checksum {
        /// As received.
        found: u32,
        /// Of what was received.
        computed: u32,
    },
    /// Whole, but says something impossible.
    #[error("byte {0} or the field there has no allowed value")]
    Value(usize),
}

impl Sample {
    /// Whether the offset is a measurement.
    pub fn is_valid(&self) -> bool {
        self.lock == Lock::Tracking
    }
}

impl Source {
    const fn code(self) -> u8 {
        match self {
            Self::Coarse => 1,
            Self::Fine => 2,
        }
    }

    const fn of(code: u8) -> Option<Self> {
        match code {
            1 => Some(Self::Coarse),
            2 => Some(Self::Fine),
            _ => None,
        }
    }
}

impl Lock {
    /// As on the wire and in the log.
    pub const fn code(self) -> u8 {
        match self {
            Self::Lost => 0,
            Self::Reacquiring => 1,
            Self::Tracking => 2,
        }
    }

    const fn of(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::Lost),
            1 => Some(Self::Reacquiring),
            2 => Some(Self::Tracking),
            _ => None,
        }
    }
}

/// The message of a frame.
pub fn encode(source: Source, sample: &Sample) -> [u8; LENGTH] {
    let mut bytes = [0; LENGTH];
    let nanoseconds = u64::try_from(sample.stamp.as_nanos()).unwrap_or(u64::MAX);
    bytes[0..4].copy_from_slice(&MAGIC);
    bytes[4] = VERSION;
    bytes[5] = source.code();
    bytes[6] = sample.lock.code();
    // The cast saturates, and takes not-a-number for 0.
    bytes[7] = (sample.quality * 255.0).round() as u8;
    bytes[8..12].copy_from_slice(&sample.counter.to_le_bytes());
    bytes[12..20].copy_from_slice(&nanoseconds.to_le_bytes());
    bytes[20..24].copy_from_slice(&sample.x_px.to_le_bytes());
    bytes[24..28].copy_from_slice(&sample.y_px.to_le_bytes());
    seal(&mut bytes);
    bytes
}

/// Adds to the frame counter of a message, modulo 2³², and makes its checksum right again. What is no message stays as it is.
pub fn advance_counter(bytes: &mut [u8], by: u32) {
    if let Ok((source, mut sample)) = decode(bytes) {
        sample.counter = sample.counter.wrapping_add(by);
        bytes.copy_from_slice(&encode(source, &sample));
    }
}

/// Puts the checksum over what is there.
pub(super) fn seal(bytes: &mut [u8; LENGTH]) {
    let checksum = crc32(&bytes[..CRC_AT]);
    bytes[CRC_AT..].copy_from_slice(&checksum.to_le_bytes());
}

/// The frame in a message.
///
/// # Errors
/// What is wrong with the message; the checksum is looked at before any value.
pub fn decode(bytes: &[u8]) -> Result<(Source, Sample), DatagramFault> {
    let bytes: &[u8; LENGTH] = bytes.try_into().map_err(|_| DatagramFault::Length(bytes.len()))?;
    if bytes[0..4] != MAGIC || bytes[4] != VERSION {
        return Err(DatagramFault::Format);
    }
    let found = u32::from_le_bytes(four(bytes, CRC_AT));
    let computed = crc32(&bytes[..CRC_AT]);
    if found != computed {
        return Err(DatagramFault::Checksum { found, computed });
    }
    let source = Source::of(bytes[5]).ok_or(DatagramFault::Value(5))?;
    let lock = Lock::of(bytes[6]).ok_or(DatagramFault::Value(6))?;
    let low = u64::from(u32::from_le_bytes(four(bytes, 12)));
    let high = u64::from(u32::from_le_bytes(four(bytes, 16)));
    let sample = Sample {
        counter: u32::from_le_bytes(four(bytes, 8)),
        stamp: Duration::from_nanos(high << 32 | low),
        x_px: pixels(bytes, 20)?,
        y_px: pixels(bytes, 24)?,
        quality: f32::from(bytes[7]) / 255.0,
        lock,
    };
    Ok((source, sample))
}

fn pixels(bytes: &[u8; LENGTH], at: usize) -> Result<f32, DatagramFault> {
    let value = f32::from_le_bytes(four(bytes, at));
    if value.is_finite() { Ok(value) } else { Err(DatagramFault::Value(at)) }
}

fn four(bytes: &[u8; LENGTH], at: usize) -> [u8; 4] {
    [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]
}

/// CRC-32/ISO-HDLC: polynomial 04C11DB7h reflected, initial value and final exclusive-or FFFFFFFFh.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes
        .iter()
        .fold(u32::MAX, |crc, &byte| (crc >> 8) ^ CRC_TABLE[((crc ^ u32::from(byte)) & 0xff) as usize])
}

const CRC_TABLE: [u32; 256] = {
    let mut table = [0; 256];
    let mut index = 0;
    while index < 256 {
        let mut crc = index as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
            bit += 1;
        }
        table[index] = crc;
        index += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::*;

    /// Check value of the CRC catalogue.
    #[test]
    fn the_checksum_is_the_catalogue_s() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }
}
