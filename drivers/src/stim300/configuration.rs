//! What the configuration datagram says (TS1524 rev. 31, table 5-16): it decides what the numbers of a measurement mean.

use super::datagram::{Content, Input};

/// Samples that the unit takes in a second, whatever it sends (TS1524, table 5-2 note 5).
pub(super) const INTERNAL_RATE_HZ: f64 = 2000.0;

/// When a measurement is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleRate {
    /// By the unit's own clock: 125, 250, 500, 1000 or 2000 Hz.
    Internal(u32),
    /// At each falling edge of the external trigger.
    External,
}

impl SampleRate {
    /// In the order of their codes, in the configuration datagram and in the service mode command `m`.
    const ALL: [Self; 6] = [
        Self::Internal(125),
        Self::Internal(250),
        Self::Internal(500),
        Self::Internal(1000),
        Self::Internal(2000),
        Self::External,
    ];

    /// Code of the rate; `None` for one that the unit does not have.
    pub(super) fn code(self) -> Option<usize> {
        Self::ALL.iter().position(|known| *known == self)
    }

    /// Internal samples between two measurements; `None` with an external trigger.
    pub(super) fn samples_per_measurement(self) -> Option<u32> {
        match self {
            Self::Internal(rate_hz) => (INTERNAL_RATE_HZ as u32).checked_div(rate_hz),
            Self::External => None,
        }
    }
}

/// What the gyro fields are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GyroUnit {
    /// Filtered angular rate.
    Rate,
    /// Angle since the measurement before.
    IncrementalAngle,
    /// Mean angular rate since the measurement before.
    AverageRate,
    /// Angle since power-up, modulo 8°.
    IntegratedAngle,
}

impl GyroUnit {
    const ALL: [Self; 4] = [Self::Rate, Self::IncrementalAngle, Self::AverageRate, Self::IntegratedAngle];

    /// Code in the configuration datagram and in the service mode command `u`; the delayed variant is 8 higher.
    pub(super) const fn code(self) -> u8 {
        self as u8
    }
}

/// What the fields of accelerometers and inclinometers are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceUnit {
    /// Filtered specific force.
    Acceleration,
    /// Velocity since the measurement before.
    IncrementalVelocity,
    /// Mean specific force since the measurement before.
    AverageAcceleration,
    /// Velocity since power-up in g·s, which wraps.
    IntegratedVelocityGs,
    /// Velocity since power-up in m/s, which wraps.
    IntegratedVelocity,
}

impl ForceUnit {
    const ALL: [Self; 5] = [
        Self::Acceleration,
        Self::IncrementalVelocity,
        Self::AverageAcceleration,
        Self::IntegratedVelocityGs,
        Self::IntegratedVelocity,
    ];

    /// Code in the configuration datagram and in the service mode command `u`.
    pub(super) const fn code(self) -> u8 {
        self as u8
    }
}

/// What the PPS field is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PpsUnit {
    /// Filtered level of the input, 0 to 1.
    Filtered,
    /// Filtered level of the input, delayed by 5 ms.
    FilteredDelayed,
    /// Time since the input was last found low, µs.
    TimeSinceLow,
    /// Time since the input was last found high, µs.
    TimeSinceHigh,
}

impl PpsUnit {
    const ALL: [Self; 4] = [Self::Filtered, Self::FilteredDelayed, Self::TimeSinceLow, Self::TimeSinceHigh];

    /// Whether the field is a time.
    pub(super) fn is_time(self) -> bool {
        matches!(self, Self::TimeSinceLow | Self::TimeSinceHigh)
    }
}

/// Parity bit of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Parity {
    None,
    Even,
    Odd,
}

/// Range of an accelerometer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AccelerometerRange {
    /// ± 5 g.
    G5,
    /// ± 10 g.
    G10,
    /// ± 30 g.
    G30,
    /// ± 80 g.
    G80,
}

impl AccelerometerRange {
    /// Codes of table 5-16, bytes 17 and 18.
    const BY_CODE: [(u8, Self); 4] = [(0, Self::G10), (3, Self::G5), (4, Self::G30), (6, Self::G80)];

    /// Counts per g of an acceleration.
    pub(super) const fn counts_per_g(self) -> f64 {
        match self {
            Self::G5 => 1_048_576.0,
            Self::G10 => 524_288.0,
            Self::G30 => 262_144.0,
            Self::G80 => 65_536.0,
        }
    }

    /// Counts per m/s of a velocity increment.
    pub(super) const fn counts_per_m_per_s(self) -> f64 {
        8.0 * self.counts_per_g()
    }
}

/// Configuration of a unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// Revision letter of the part number.
    pub revision: char,
    /// Revision of the firmware.
    pub firmware: u8,
    /// When a measurement is sent.
    pub sample_rate: SampleRate,
    /// What a measurement carries.
    pub content: Content,
    /// Whether CR LF follows each datagram.
    pub line_end: bool,
    /// Bit rate of the line, bit/s; `None` for one that the user has defined.
    pub bit_rate: Option<u32>,
    /// Stop bits of a character, 1 or 2.
    pub stop_bits_count: u8,
    /// Parity bit of a character.
    pub parity: Parity,
    /// Whether the unit terminates the line with 120 Ω.
    pub is_terminated: bool,
    /// Gyros X, Y, Z that are active.
    pub gyros_active: [bool; 3],
    /// What the gyro fields are.
    pub gyro_unit: GyroUnit,
    /// Whether the gyros are delayed by 4 ms, to the group delay of the accelerometers.
    pub is_gyro_delayed: bool,
    /// Low-pass filters (−3 dB) of gyros X, Y, Z, Hz.
    pub gyro_filter_hz: [u16; 3],
    /// Code of the compensation of the gyros for acceleration.
    pub g_compensation: u8,
    /// Accelerometers X, Y, Z that are active.
    pub accelerometers_active: [bool; 3],
    /// What the accelerometer fields are.
    pub accelerometer_unit: ForceUnit,
    /// Low-pass filters (−3 dB) of accelerometers X, Y, Z, Hz.
    pub accelerometer_filter_hz: [u16; 3],
    /// Ranges of accelerometers X, Y, Z.
    pub accelerometer_range: [AccelerometerRange; 3],
    /// Inclinometers X, Y, Z that are active.
    pub inclinometers_active: [bool; 3],
    /// What the inclinometer fields are.
    pub inclinometer_unit: ForceUnit,
    /// Low-pass filters (−3 dB) of inclinometers X, Y, Z, Hz.
    pub inclinometer_filter_hz: [u16; 3],
    /// What the PPS field is.
    pub pps_unit: PpsUnit,
    /// Whether the bias trim datagram is sent at start-up.
    pub sends_bias_trim: bool,
}

/// A code that the datasheet does not list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownCode {
    /// What it should say.
    pub field: &'static str,
    /// The code.
    pub code: u8,
}

impl Configuration {
    /// From the 21 bytes between identifier and checksum.
    ///
    /// # Errors
    /// The first code that the datasheet does not list: its meaning must not be guessed.
    pub fn decode(payload: &[u8; 21]) -> Result<Self, UnknownCode> {
        let p = payload;
        let bit = |byte: u8, place: u8| byte >> place & 1 == 1;
        let axes = |byte: u8| [bit(byte, 6), bit(byte, 5), bit(byte, 4)];
        let has_pps = bit(p[13], 3);
        Ok(Self {
            revision: char::from(p[0]),
            firmware: p[1],
            sample_rate: listed(&SampleRate::ALL, "sample rate", p[2] >> 5)?,
            content: Content {
                accelerometers: bit(p[2], 1),
                inclinometers: bit(p[2], 2),
                temperatures: bit(p[2], 3),
                input: match (bit(p[2], 4), has_pps) {
                    (false, _) => Input::None,
                    (true, true) => Input::Pps,
                    (true, false) => Input::Aux,
                },
            },
            line_end: bit(p[2], 0),
            bit_rate: bit_rate(p[3] >> 4)?,
            stop_bits_count: if bit(p[3], 3) { 2 } else { 1 },
            parity: listed(&[Parity::None, Parity::Even, Parity::Odd], "parity", p[3] >> 1 & 3)?,
            is_terminated: bit(p[3], 0),
            gyros_active: axes(p[4]),
            gyro_unit: listed(&GyroUnit::ALL, "gyro output unit", p[4] & 7)?,
            is_gyro_delayed: bit(p[4], 3),
            gyro_filter_hz: filters(p[5], p[6])?,
            g_compensation: p[6] & 0x0F,
            accelerometers_active: axes(p[7]),
            accelerometer_unit: listed(&ForceUnit::ALL, "accelerometer output unit", p[7] & 0x0F)?,
            accelerometer_filter_hz: filters(p[8], p[9])?,
            accelerometer_range: [range(p[16] >> 4)?, range(p[16] & 0x0F)?, range(p[17] >> 4)?],
            inclinometers_active: axes(p[10]),
            inclinometer_unit: listed(&ForceUnit::ALL, "inclinometer output unit", p[10] & 0x0F)?,
            inclinometer_filter_hz: filters(p[11], p[12])?,
            pps_unit: listed(&PpsUnit::ALL, "PPS output unit", p[12] & 0x0F)?,
            sends_bias_trim: bit(p[20], 1),
        })
    }

    /// Bits of a character on the line: start, eight data bits, parity, stop.
    pub(super) fn bits_per_byte(&self) -> f64 {
        let parity = if self.parity == Parity::None { 0.0 } else { 1.0 };
        9.0 + parity + f64::from(self.stop_bits_count)
    }
}

fn listed<T: Copy>(values: &[T], field: &'static str, code: u8) -> Result<T, UnknownCode> {
    values.get(usize::from(code)).copied().ok_or(UnknownCode { field, code })
}

fn bit_rate(code: u8) -> Result<Option<u32>, UnknownCode> {
    if code == 15 {
        return Ok(None);
    }
    listed(&[374_400, 460_800, 921_600, 1_843_200], "bit rate", code).map(Some)
}

/// Filters of X and Y in one byte, of Z in the upper half of the next.
fn filters(xy: u8, z: u8) -> Result<[u16; 3], UnknownCode> {
    let hz = |code: u8| listed(&[16, 33, 66, 131, 262], "low-pass filter", code);
    Ok([hz(xy >> 4 & 7)?, hz(xy & 7)?, hz(z >> 4 & 7)?])
}

fn range(code: u8) -> Result<AccelerometerRange, UnknownCode> {
    let known = AccelerometerRange::BY_CODE.iter().find(|(known, _)| *known == code);
    known.map(|&(_, range)| range).ok_or(UnknownCode { field: "accelerometer range", code })
}
