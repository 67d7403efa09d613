//! Serial protocol of the CEDRAT CCBu40 (manual v1.21, pages 22–26): what both ends must agree on.
//!
//! Host to device: one letter, a decimal number, `E`; 3…20 characters, no CR or LF. Device to host: signed 32-bit
//! words, big-endian, then `X`. One command at a time: the next one waits for the `X`.

use std::io::Write;

/// Ends a command.
pub const TERMINATOR: u8 = b'E';
/// Ends a reply.
pub const ACKNOWLEDGE: u8 = b'X';
/// Shortest and longest command, terminator included.
pub const COMMAND_LENGTH: std::ops::RangeInclusive<usize> = 3..=20;
/// Orders reach ± this voltage.
pub const ORDER_LIMIT_V: f64 = 10.0;
/// Words per volt of orders, feedback and limits.
pub const WORDS_PER_V: f64 = 3276.8;
/// Words per unit of gains.
pub const WORDS_PER_GAIN: f64 = 65536.0;
/// Words of the parameter set.
pub const PARAMETER_WORDS: usize = 15;
/// Longest reply.
pub const LONGEST_REPLY: usize = 4 * PARAMETER_WORDS + 1;
/// Bit rate of the line for a register value n is this over n + 1.
pub const BIT_RATE_CLOCK_HZ: f64 = 11.25e6;

/// Commands. Axes are 0 azimuth = X, 1 elevation = Y; on the wire 1 and 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// `V`: axis that the next orders are for.
    SelectAxis(usize),
    /// `B`: strain gauge loop closed or open.
    CloseLoop(bool),
    /// `T`: digital order or analog input.
    DigitalSource(bool),
    /// `Z`: digital order, volts, at once.
    Order(f64),
    /// `W`: digital order, volts, kept over power-off; slow.
    StoredOrder(f64),
    /// `Q`: strain gauge feedback of an axis.
    Feedback(usize),
    /// `R`: parameter set of an axis.
    Parameters(usize),
    /// `b`: register of the fast bit rate.
    BitRate(u16),
}

/// A command as bytes.
#[derive(Clone, Copy, Debug)]
pub struct Encoded {
    bytes: [u8; *COMMAND_LENGTH.end()],
    length: usize,
}

impl Encoded {
    /// What goes over the line.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }
}

impl Command {
    /// Bytes of the command; orders are limited to ± 10 V, one that is not a number is sent as 0.
    pub fn encode(&self) -> Encoded {
        let mut bytes = [0; *COMMAND_LENGTH.end()];
        let mut rest = &mut bytes[..];
        let volts = |volts: f64| {
            if volts.is_finite() { volts.clamp(-ORDER_LIMIT_V, ORDER_LIMIT_V) } else { 0.0 }
        };
        let written = match *self {
            Self::SelectAxis(axis) => write!(rest, "V{}E", axis + 1),
            Self::CloseLoop(closed) => write!(rest, "B{}E", u8::from(closed)),
            Self::DigitalSource(digital) => write!(rest, "T{}E", u8::from(digital)),
            // 10 µV are 5 nrad at the nominal scale, far below the mirror's own quantum.
            Self::Order(order) => write!(rest, "Z{:.5}E", volts(order)),
            Self::StoredOrder(order) => write!(rest, "W{:.5}E", volts(order)),
            Self::Feedback(axis) => write!(rest, "Q{}E", axis + 1),
            Self::Parameters(axis) => write!(rest, "R{}E", axis + 1),
            Self::BitRate(register) => write!(rest, "b{register}E"),
        };
        let left = rest.len();
        // An axis of more than 19 digits would not fit; then nothing is sent.
        let length = if written.is_ok() { bytes.len() - left } else { 0 };
        Encoded { bytes, length }
    }

    /// The command in these bytes, terminator included; `None` for anything the manual does not allow.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let (&letter, rest) = bytes.split_first()?;
        let (&last, number) = rest.split_last()?;
        if last != TERMINATOR || !COMMAND_LENGTH.contains(&bytes.len()) {
            return None;
        }
        if !number.iter().all(|byte| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.')) {
            return None;
        }
        let number: f64 = std::str::from_utf8(number).ok()?.parse().ok()?;
        let axis = || [1.0, 2.0].iter().position(|&n| n == number);
        let switch = || [0.0, 1.0].iter().position(|&n| n == number).map(|n| n == 1);
        let order = || (number.abs() <= ORDER_LIMIT_V).then_some(number);
        match letter {
            b'V' => axis().map(Self::SelectAxis),
            b'B' => switch().map(Self::CloseLoop),
            b'T' => switch().map(Self::DigitalSource),
            b'Z' => order().map(Self::Order),
            b'W' => order().map(Self::StoredOrder),
            b'Q' => axis().map(Self::Feedback),
            b'R' => axis().map(Self::Parameters),
            b'b' if number.fract() == 0.0 && (0.0..=65535.0).contains(&number) => {
                Some(Self::BitRate(number as u16))
            }
            _ => None,
        }
    }

    /// Bytes of the reply, acknowledge included.
    pub const fn reply_length(&self) -> usize {
        match self {
            Self::Feedback(_) => 5,
            Self::Parameters(_) => LONGEST_REPLY,
            _ => 1,
        }
    }
}

/// What `R` reads: the parameter set of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParameterSet {
    /// Digital order rules, not the analog input.
    pub digital_source: bool,
    /// Digital order.
    pub order_v: f64,
    /// Strain gauge loop closed.
    pub closed_loop: bool,
    /// Proportional gain.
    pub proportional_gain: f64,
    /// Integral gain.
    pub integral_gain: f64,
    /// Differential gain.
    pub differential_gain: f64,
    /// Filter: 0 none, 1 low-pass at the first frequency, 2 notch at it, 3 fourth-order notch, 4 two notches.
    pub filter: i32,
    /// First and second frequency of the filter.
    pub filter_hz: [i32; 2],
    /// Upper and lower limit of orders.
    pub limits_v: [f64; 2],
    /// Gain of the sensor.
    pub sensor_gain: f64,
    /// Firmware, 100 = 1.00.
    pub firmware: i32,
    /// Serial number, 15001 = 15-001.
    pub serial_number: i32,
}

impl ParameterSet {
    /// As on the wire.
    pub fn to_words(&self) -> [i32; PARAMETER_WORDS] {
        let gain = |gain: f64| (gain * WORDS_PER_GAIN).round() as i32;
        [
            i32::from(self.digital_source),
            volts_to_word(self.order_v),
            i32::from(self.closed_loop),
            gain(self.proportional_gain),
            gain(self.integral_gain),
            gain(self.differential_gain),
            self.filter,
            self.filter_hz[0],
            self.filter_hz[1],
            volts_to_word(self.limits_v[0]),
            volts_to_word(self.limits_v[1]),
            gain(self.sensor_gain),
            self.firmware,
            self.serial_number,
            0,
        ]
    }

    /// From the wire.
    pub fn from_words(words: &[i32; PARAMETER_WORDS]) -> Self {
        let gain = |word: i32| f64::from(word) / WORDS_PER_GAIN;
        Self {
            digital_source: words[0] != 0,
            order_v: word_to_volts(words[1]),
            closed_loop: words[2] != 0,
            proportional_gain: gain(words[3]),
            integral_gain: gain(words[4]),
            differential_gain: gain(words[5]),
            filter: words[6],
            filter_hz: [words[7], words[8]],
            limits_v: [word_to_volts(words[9]), word_to_volts(words[10])],
            sensor_gain: gain(words[11]),
            firmware: words[12],
            serial_number: words[13],
        }
    }
}

/// Volts as a word of the wire.
pub fn volts_to_word(volts: f64) -> i32 {
    (volts * WORDS_PER_V).round() as i32
}

/// A word of the wire in volts.
pub fn word_to_volts(word: i32) -> f64 {
    f64::from(word) / WORDS_PER_V
}
