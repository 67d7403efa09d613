//! Messages and reports of the built-in test: layout (ICD 56-0298, bytes counted from 0 here).

use crate::crc32::crc32;

/// First three bytes of a message.
pub(super) const MESSAGE_HEADER: [u8; 3] = [0xFE, 0x81, 0xFF];
/// First three bytes of a report of the built-in test.
pub(super) const BIT_HEADER: [u8; 3] = [0xFE, 0x81, 0x00];
/// Longest of all frames.
pub(super) const LONGEST_FRAME: usize = 40;

/// Output formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 36 bytes, temperature in each message.
    A,
    /// 40 bytes, as A with a timestamp.
    B,
    /// 38 bytes, temperature and magnetic field in turn.
    C,
}

/// Temperature of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Temperature {
    /// In the unit that is configured, °C.
    Degc(f32),
    /// Format C brings it in every fourth message only.
    NotInThisMessage,
}

/// A message whose checksum is right, in the units of the wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Message {
    /// Format.
    pub format: Format,
    /// Rotation about X, Y, Z in the configured quantity and unit.
    pub rotation: [f32; 3],
    /// Specific force along X, Y, Z, g.
    pub acceleration_g: [f32; 3],
    /// Temperature.
    pub temperature: Temperature,
    /// Magnetic field of format C: axis (0 to 2) and gauss.
    pub magnetic_gauss: Option<(usize, f32)>,
    /// Time of the unit, µs modulo 2³²; format B.
    pub timestamp_us: Option<u32>,
    /// Status: bits 0 to 2 gyro X, Y, Z valid, bits 4 to 6 accelerometer X, Y, Z valid.
    pub status: u8,
    /// Number of the message, 0..=127.
    pub sequence: u8,
}

/// A report of the built-in test: each byte uses bits 0 to 6, 1 = passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitReport {
    bytes: [u8; 8],
    length: usize,
}

/// Tests of the first six bytes, seven to a byte.
const TEST_NAMES: [&str; 42] = [
    "gyro X SLD",
    "gyro X MODDAC",
    "gyro X phase",
    "gyro X flash",
    "gyro X PZT temperature",
    "gyro X SLD temperature",
    "gyro Y SLD",
    "gyro Y MODDAC",
    "gyro Y phase",
    "gyro Y flash",
    "gyro Y PZT temperature",
    "gyro Y SLD temperature",
    "gyro Z SLD",
    "gyro Z MODDAC",
    "gyro Z phase",
    "gyro Z flash",
    "gyro Z PZT temperature",
    "gyro Z SLD temperature",
    "accelerometer X",
    "accelerometer X temperature",
    "accelerometer Y",
    "accelerometer Y temperature",
    "accelerometer Z",
    "accelerometer Z temperature",
    "GCB temperature",
    "IMU temperature",
    "GCB DSP flash",
    "GCB FPGA flash",
    "IMU DSP flash",
    "IMU FPGA flash",
    "GCB 1.2 V",
    "GCB 3.3 V",
    "GCB 5 V",
    "IMU 1.2 V",
    "IMU 3.3 V",
    "IMU 5 V",
    "IMU 15 V",
    "GCB FPGA",
    "IMU FPGA",
    "high-speed SPORT",
    "auxiliary SPORT",
    "software",
];

/// What a header announces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Announced {
    Message(Format),
    Bit { length: usize },
}

impl Format {
    /// Letter of `OUTPUTFMT`.
    pub fn letter(self) -> char {
        match self {
            Self::A => 'A',
            Self::B => 'B',
            Self::C => 'C',
        }
    }

    /// Bytes of a message, header and checksum included.
    pub const fn bytes(self) -> usize {
        match self {
            Self::A => 36,
            Self::B => 40,
            Self::C => 38,
        }
    }

    /// Last byte of the header: it names the format, not the model.
    const fn header_end(self) -> u8 {
        match self {
            Self::A => 0x55,
            Self::B => 0x56,
            Self::C => 0x57,
        }
    }
}

impl Announced {
    /// What a complete header says; `None` if it is none.
    pub(super) fn by(header: [u8; 4]) -> Option<Self> {
        let [a, b, c, end] = header;
        match ([a, b, c], end) {
            (MESSAGE_HEADER, _) => [Format::A, Format::B, Format::C]
                .into_iter()
                .find(|f| f.header_end() == end)
                .map(Self::Message),
            (BIT_HEADER, 0xAA) => Some(Self::Bit { length: 6 }),
            (BIT_HEADER, 0xAB) => Some(Self::Bit { length: 8 }),
            _ => None,
        }
    }

    /// Bytes of the whole frame.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Message(format) => format.bytes(),
            Self::Bit { length } => 4 + length + 1,
        }
    }
}

impl Message {
    /// Decodes a frame of exactly the length of its format; `None` if the checksum is wrong.
    pub(super) fn decode(format: Format, frame: &[u8]) -> Option<Self> {
        let (body, checksum) = frame.split_last_chunk::<4>()?;
        if frame.len() != format.bytes() || crc32(body) != u32::from_be_bytes(*checksum) {
            return None;
        }
        // The status byte is the first of what follows the timestamp or the interleaved field.
        let status_at = if format == Format::A { 28 } else { 32 };
        let status = body[status_at];
        let sequence = body[status_at + 1];
        let (temperature, magnetic_gauss) = match format {
            Format::A | Format::B => {
                let raw = i16::from_be_bytes([body[status_at + 2], body[status_at + 3]]);
                (Temperature::Degc(f32::from(raw)), None)
            }
            Format::C => interleaved(sequence, float(body, 28)),
        };
        Some(Self {
            format,
            rotation: [4, 8, 12].map(|at| float(body, at)),
            acceleration_g: [16, 20, 24].map(|at| float(body, at)),
            temperature,
            magnetic_gauss,
            timestamp_us: (format == Format::B).then(|| u32::from_be_bytes(word(body, 28))),
            status,
            sequence,
        })
    }
}

impl BitReport {
    /// Decodes a frame of the announced length; `None` if the sum is wrong.
    pub(super) fn decode(length: usize, frame: &[u8]) -> Option<Self> {
        let (&sum, summed) = frame.split_last()?;
        let data = summed.get(4..4 + length)?;
        if summed.iter().fold(0_u8, |sum, &byte| sum.wrapping_add(byte)) != sum {
            return None;
        }
        let mut bytes = [0; 8];
        bytes.get_mut(..length)?.copy_from_slice(data);
        Some(Self { bytes, length })
    }

    /// The bytes as sent.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    /// Numbers of the tests that failed, seven to a byte, test 0 in bit 0 of the first byte.
    pub fn failed(&self) -> impl Iterator<Item = usize> + '_ {
        (0..7 * self.length).filter(|test| self.bytes[test / 7] >> (test % 7) & 1 == 0)
    }

    /// What a test is of, by its number in [`BitReport::failed`]. These are the names and the order of the 1750, from a public
    /// driver (`TRECVT/ros_kvh1750`); the tables of the 1775 (ICD 56-0298, 5-12 to 5-19) were not at hand. Of the 1775 it is known
    /// that test 16 is the FOG temperature of gyro X, test 45 the offset of the magnetometer and test 48 a voltage of the gyro
    /// control board (GCB).
    pub fn name(test: usize) -> &'static str {
        TEST_NAMES.get(test).copied().unwrap_or("not named")
    }

    /// Whether every test passed.
    pub fn passed(&self) -> bool {
        self.failed().next().is_none()
    }
}

/// Bytes 28 to 31 of format C by sequence modulo 4: temperature, magnetic X, Y, Z.
fn interleaved(sequence: u8, value: f32) -> (Temperature, Option<(usize, f32)>) {
    match sequence % 4 {
        0 => (Temperature::Degc(value), None),
        axis => (Temperature::NotInThisMessage, Some((usize::from(axis) - 1, value))),
    }
}

fn word(bytes: &[u8], at: usize) -> [u8; 4] {
    [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]
}

fn float(bytes: &[u8], at: usize) -> f32 {
    f32::from_be_bytes(word(bytes, at))
}
