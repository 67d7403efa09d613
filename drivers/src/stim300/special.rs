//! What the special datagrams say: identity, bias trim, errors (TS1524 rev. 31, tables 5-13 to 5-19).

use super::datagram::{SpecialKind, i24};

/// Gyro offsets: counts per °/s.
const GYRO_COUNTS_PER_DEG_PER_S: f64 = 16_384.0;
/// Accelerometer offsets: counts per g. The datasheet refers to the conversion of measurements, which depends on the range;
/// 2¹⁹ is that of the 10 g range, which the public decoder `pystim300` uses for all ranges.
const ACCELEROMETER_COUNTS_PER_G: f64 = 524_288.0;
/// Inclinometer offsets: counts per g.
const INCLINOMETER_COUNTS_PER_G: f64 = 4_194_304.0;

/// A special datagram whose checksum is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Special {
    kind: SpecialKind,
    payload: [u8; 35],
}

impl Special {
    /// Keeps what lies between identifier and checksum; `None` if it is not as long as the kind needs.
    pub(super) fn decode(kind: SpecialKind, payload: &[u8]) -> Option<Self> {
        if payload.len() != kind.payload_bytes() {
            return None;
        }
        let mut kept = [0; 35];
        kept[..payload.len()].copy_from_slice(payload);
        Some(Self { kind, payload: kept })
    }

    /// Which one it is.
    pub fn kind(&self) -> SpecialKind {
        self.kind
    }

    /// Bytes between identifier and checksum.
    pub fn payload(&self) -> &[u8] {
        &self.payload[..self.kind.payload_bytes()]
    }

    /// Part number and revision in the form of the service mode, e.g. `84167-4400003-321 REV K`; `None` for other datagrams.
    pub fn part_number(&self) -> Option<String> {
        if self.kind != SpecialKind::PartNumber {
            return None;
        }
        let p = &self.payload;
        let digits = [
            low(p[0]),
            high(p[1]),
            low(p[1]),
            high(p[2]),
            low(p[2]),
            high(p[4]),
            low(p[4]),
            high(p[5]),
            low(p[5]),
            high(p[6]),
            low(p[6]),
            low(p[10]),
            high(p[8]) + (high(p[10]) << 4),
            low(p[8]),
            high(p[9]) + (low(p[9]) << 4),
        ];
        let mut text = String::new();
        for (place, digit) in digits.into_iter().enumerate() {
            if matches!(place, 5 | 12) {
                text.push('-');
            }
            // Table 5-14: 0 to 9, then A onwards.
            let code = if digit < 10 { digit + 48 } else { digit + 55 };
            text.push(char::from_u32(code).filter(char::is_ascii_graphic).unwrap_or('?'));
        }
        text.push_str(" REV ");
        text.push(if p[14].is_ascii_graphic() { char::from(p[14]) } else { '?' });
        Some(text)
    }

    /// Serial number, e.g. `N25582405002002`; `None` for other datagrams. The bytes behind the digits are for future use: where
    /// they hold text, it follows after a hyphen, as in the number of a simulated unit.
    pub fn serial_number(&self) -> Option<String> {
        if self.kind != SpecialKind::SerialNumber {
            return None;
        }
        let mut text = String::from(if self.payload[0] == b'N' { 'N' } else { '?' });
        for byte in &self.payload[1..8] {
            text.push_str(&format!("{byte:02X}"));
        }
        let note: String =
            self.payload()[8..].iter().map_while(|&b| b.is_ascii_graphic().then(|| char::from(b))).collect();
        if !note.is_empty() {
            text.push('-');
            text.push_str(&note);
        }
        Some(text)
    }

    /// Bias trim offsets; `None` for other datagrams.
    pub fn bias_trim(&self) -> Option<BiasTrim> {
        if self.kind != SpecialKind::BiasTrim {
            return None;
        }
        let p = &self.payload;
        let triad = |first: usize, counts_per_unit: f64| {
            [0, 1, 2].map(|axis| {
                let at = first + 3 * axis;
                f64::from(i24([p[at], p[at + 1], p[at + 2]])) / counts_per_unit
            })
        };
        Some(BiasTrim {
            gyro_rad_per_s: triad(0, GYRO_COUNTS_PER_DEG_PER_S).map(f64::to_radians),
            accelerometer_g: triad(9, ACCELEROMETER_COUNTS_PER_G),
            inclinometer_g: triad(18, INCLINOMETER_COUNTS_PER_G),
            reference: u32::from_be_bytes([p[27], p[28], p[29], p[30]]),
            saves_left_count: u16::from_be_bytes([p[31], p[32]]),
        })
    }

    /// Errors since they were last read; `None` for other datagrams.
    pub fn extended_errors(&self) -> Option<ExtendedErrors> {
        let bits = self.payload.first_chunk::<16>().map(|bytes| u128::from_be_bytes(*bytes))?;
        (self.kind == SpecialKind::ExtendedError).then_some(ExtendedErrors { bits })
    }
}

/// The four upper bits.
fn high(byte: u8) -> u32 {
    u32::from(byte >> 4)
}

/// The four lower bits.
fn low(byte: u8) -> u32 {
    u32::from(byte & 0x0F)
}

/// Offsets that the unit adds to its compensated values, X, Y, Z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BiasTrim {
    /// Gyros.
    pub gyro_rad_per_s: [f64; 3],
    /// Accelerometers, in g of the 10 g range (see the source: the scale for other ranges is not documented).
    pub accelerometer_g: [f64; 3],
    /// Inclinometers, g.
    pub inclinometer_g: [f64; 3],
    /// Number that the user gave to the last adjustment.
    pub reference: u32,
    /// How often offsets can still be saved.
    pub saves_left_count: u16,
}

/// Errors that the self-test has seen since they were last read, E0 to E127 (table 5-19).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExtendedErrors {
    bits: u128,
}

impl ExtendedErrors {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.bits == 0
    }

    /// Numbers of the errors, lowest first.
    pub fn numbers(&self) -> impl Iterator<Item = u8> + '_ {
        (0..128).filter(|number| self.bits >> number & 1 == 1)
    }

    /// What an error means; the number is printed where it is for future use.
    pub fn meaning(number: u8) -> &'static str {
        match number {
            0..=2 => "gyro excitation frequency",
            3 | 97 => "temperature of the microcontroller",
            4..=6 => "temperature of a gyro circuit",
            7..=9 => "temperature sensor of a gyro",
            10..=12 => "gyro clipped",
            13..=15 => "communication with a gyro",
            16 => "start-up phase",
            17..=19 | 111 => "reference voltage",
            20 => "supply voltage",
            21..=23 => "regulated voltage",
            24..=44 => "gyro circuit",
            45..=47 => "accelerometer clipped",
            48..=50 => "temperature sensor of an accelerometer",
            51..=53 => "inclinometer clipped",
            54 | 55 => "temperature sensor of an inclinometer",
            56 => "check of the RAM",
            57 => "check of the flash",
            58 => "internal D/A converter",
            59 => "supply overvoltage",
            60..=64 => "stack of the firmware",
            65..=67 => "data of a gyro missing",
            68 => "UART cannot transmit: bit rate too low for rate and length of the datagrams",
            70..=72 => "A/D converter of an accelerometer",
            73..=75 => "A/D converter of an inclinometer",
            77..=79 => "temperature of a gyro clipped",
            80..=84 => "A/D converter of a temperature",
            85 => "self-test not running",
            86..=96 => "deviation between temperatures",
            98..=100 => "configuration of a gyro",
            101..=103 => "gyro overload: rate beyond the range",
            104..=106 => "accelerometer overload: acceleration beyond the range",
            107..=109 => "inclinometer overload: acceleration beyond the range",
            112 => "time since the last PPS edge beyond its range",
            _ => "reserved",
        }
    }
}
