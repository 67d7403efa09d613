//! KVH 1750/1775 inertial measurement unit on an RS-422 line (ICD 56-0298): frames, checksum, configuration.
//!
//! What the numbers in a frame mean (rate or angle increment, radian or degree) is state of the device and not in
//! the frame, so [`Opening`] asks for it, changes what differs and reads it back before [`Kvh`] exists.

mod configure;
mod frame;
mod parser;
#[cfg(test)]
mod tests;

use std::time::Duration;

pub use self::configure::Opening;
pub use self::frame::{BitReport, Format, Message, Temperature};
pub use self::parser::{Found, Parser};
pub use crate::framing::{STALE_PERIODS, Tally};

use crate::device::{Channel, DeviceError, Width};
use crate::framing::{Arrival, Freshness, read_waiting};
use crate::wire::ByteLine;

/// The g in which the unit reports specific force, m/s²: standard gravity (CGPM 1901).
pub const STANDARD_GRAVITY_M_PER_S2: f64 = 9.806_65;
/// Status byte of a unit whose six sensors are all valid.
pub const HEALTHY_STATUS: u8 = 0x77;
/// Bits of the status byte: gyro X, Y, Z, accelerometer X, Y, Z.
const STATUS_BITS: [u8; 6] = [0, 1, 2, 4, 5, 6];
/// Bits of a character on the line: start, eight data bits, stop (ICD 56-0298).
const BITS_PER_BYTE: f64 = 10.0;

/// Who decides when a message is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Synchronisation {
    /// `MSYNC,EXT`: one message per pulse.
    External,
    /// `MSYNC,IMU`: the unit's own data rate, Hz.
    Internal(u32),
}

/// What the unit must be told and checked against.
#[derive(Clone, Debug, PartialEq)]
pub struct KvhSettings {
    /// Name in errors and topics, e.g. `imu`.
    pub name: String,
    /// Bit rate of the line; 36-byte messages at 4 kHz need 4147200.
    pub baud: u32,
    /// Output format.
    pub format: Format,
    /// Who decides when a message is sent.
    pub synchronisation: Synchronisation,
    /// Messages per second, Hz: an angle increment times this is a rate.
    pub message_rate_hz: f64,
    /// Whether the unit sends rates. Otherwise it sends angle increments, which the driver divides by the message period.
    pub rate_output: bool,
    /// Time allowed for each answer, s.
    pub answer_timeout_s: f64,
}

/// Identity as read from the unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KvhIdentity {
    /// Serial number (`?IS`).
    pub serial: String,
    /// Entries of its configuration by their commands, as read back when it was opened.
    pub configuration: Vec<(&'static str, String)>,
}

/// One message in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Angular rates about X, Y, Z, positive by the right-hand rule.
    pub rate_rad_per_s: [f64; 3],
    /// Specific force along X, Y, Z: at rest +1 g on an axis that points up.
    pub acceleration_m_per_s2: [f64; 3],
    /// Temperature of the unit, °C.
    pub temperature_degc: f64,
    /// Whether gyro X, Y, Z and accelerometer X, Y, Z are valid.
    pub valid: [bool; 6],
    /// Raw status byte.
    pub status: u8,
    /// Number of the message, 0..=127.
    pub sequence: u8,
    /// Time of the unit in µs, modulo 2³²; format B only.
    pub timestamp_us: Option<u32>,
    /// Latest time since the start of the run at which its transmission can have begun: that of the poll less the time of
    /// its bytes, and of those behind it, on the wire. The transmission may have begun earlier by the time between two polls at
    /// the most. What the unit needs from the sampling to the first bit is not known and not taken off.
    pub sent_at: Duration,
}

/// A unit whose configuration has been verified and which sends messages.
#[derive(Clone, Debug)]
pub struct Kvh {
    settings: KvhSettings,
    identity: KvhIdentity,
    parser: Parser,
    arrival: Arrival,
    /// Factor from a rotation field to rad/s: 1 for rates in rad/s, the message rate in Hz for increments in rad.
    rotation_factor: f64,
    /// The newest message; all 0 before the first.
    last: Sample,
    /// Whether any message has come yet.
    seen: bool,
    freshness: Freshness,
    /// Messages lost so far.
    missed_count: u64,
    /// The newest report of the built-in test (BIT).
    bit: Option<BitReport>,
}

impl Kvh {
    /// What the driver publishes each tick, in the order of [`Kvh::row`].
    pub const CHANNELS: &'static [Channel] = &[
        channel("rate_x_rad_per_s", "rad/s", Width::F32),
        channel("rate_y_rad_per_s", "rad/s", Width::F32),
        channel("rate_z_rad_per_s", "rad/s", Width::F32),
        channel("acceleration_x_m_per_s2", "m/s^2", Width::F32),
        channel("acceleration_y_m_per_s2", "m/s^2", Width::F32),
        channel("acceleration_z_m_per_s2", "m/s^2", Width::F32),
        channel("temperature_degc", "degC", Width::F32),
        channel("status", "", Width::U16),
        channel("sequence", "", Width::U16),
        channel("age_ticks", "", Width::U16),
    ];

    fn new(settings: KvhSettings, identity: KvhIdentity) -> Self {
        let rotation_factor = if settings.rate_output { 1.0 } else { settings.message_rate_hz };
        Self {
            settings,
            identity,
            parser: Parser::default(),
            arrival: Arrival::default(),
            rotation_factor,
            last: Sample::default(),
            seen: false,
            freshness: Freshness::default(),
            missed_count: 0,
            bit: None,
        }
    }

    /// Reads what arrived up to `now` and keeps the newest message. Returns the number of new messages. Call once per tick.
    ///
    /// # Errors
    /// When the line is gone.
    pub fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<u32, DeviceError> {
        let mut messages_count = 0;
        let read = read_waiting(line, now, |bytes| {
            messages_count += self.take(bytes);
            Ok(())
        });
        if messages_count > 0 {
            self.last.sent_at = self.arrival.began(now, BITS_PER_BYTE / f64::from(self.settings.baud));
        }
        // A line that is gone brings nothing: what came before it ages.
        self.freshness.polled(now, messages_count);
        read.map(|()| messages_count)
    }

    /// Parses the next bytes of the stream, in pieces of any size. Returns the number of messages that they completed.
    fn take(&mut self, bytes: &[u8]) -> u32 {
        self.parser.push(bytes);
        self.arrival.bytes_came(bytes.len());
        let mut messages_count = 0;
        while let Some(found) = self.parser.next() {
            match found {
                Found::Message(message) => {
                    self.arrival.frame_found(message.format.bytes(), self.parser.waiting_bytes());
                    self.accept(&message);
                    messages_count += 1;
                }
                Found::Bit(report) => self.bit = Some(report),
            }
        }
        messages_count
    }

    fn accept(&mut self, message: &Message) {
        if self.seen {
            self.missed_count += u64::from(missed_between(self.last.sequence, message.sequence));
        }
        self.seen = true;
        let [x, y, z] = message.rotation;
        let [ax, ay, az] = message.acceleration_g;
        // In the order of `STATUS_BITS`.
        let readings = [x, y, z, ax, ay, az];
        let temperature_degc = match message.temperature {
            Temperature::Degc(value) => f64::from(value),
            Temperature::NotInThisMessage => self.last.temperature_degc,
        };
        self.last = Sample {
            rate_rad_per_s: message.rotation.map(|value| f64::from(value) * self.rotation_factor),
            acceleration_m_per_s2: message
                .acceleration_g
                .map(|value| f64::from(value) * STANDARD_GRAVITY_M_PER_S2),
            temperature_degc,
            valid: std::array::from_fn(|sensor| {
                let reported_valid = (message.status >> STATUS_BITS[sensor]) & 1 == 1;
                reported_valid && readings[sensor].is_finite()
            }),
            status: message.status,
            sequence: message.sequence,
            timestamp_us: message.timestamp_us,
            sent_at: self.last.sent_at,
        };
    }

    /// The newest message; `None` before the first.
    pub fn sample(&self) -> Option<&Sample> {
        self.seen.then_some(&self.last)
    }

    /// The newest message if all gyros are valid in it. Accelerometers and the age of the message are not checked.
    ///
    /// # Errors
    /// [`DeviceError::Field`] with the status byte if a gyro is not valid or nothing arrived yet.
    pub fn valid_sample(&self) -> Result<&Sample, DeviceError> {
        if self.seen && self.last.valid[..3] == [true; 3] {
            return Ok(&self.last);
        }
        let found = if self.seen { format!("{:02X}h", self.last.status) } else { "no message".to_owned() };
        Err(DeviceError::Field {
            device: self.settings.name.clone(),
            field: "status byte",
            expected: format!("{HEALTHY_STATUS:02X}h"),
            found,
            help: "a gyro that has just been powered needs its start-up time; then query ?BIT",
        })
    }

    /// Whether no message has come for ten periods, or none at all.
    pub fn is_stale(&self, now: Duration) -> bool {
        !self.seen || self.silent_s(now) > STALE_PERIODS / self.settings.message_rate_hz
    }

    /// How long no message has come, s; 0 before the first. A unit that sends a message for each pulse is silent by the polls
    /// that found none: where polls were missed, so were pulses.
    pub fn silent_s(&self, now: Duration) -> f64 {
        match self.settings.synchronisation {
            _ if !self.seen => 0.0,
            Synchronisation::External => f64::from(self.freshness.age_ticks) / self.settings.message_rate_hz,
            Synchronisation::Internal(_) => self.freshness.silent_s(now),
        }
    }

    /// Ticks since the newest message arrived.
    pub fn age_ticks(&self) -> u16 {
        self.freshness.age_ticks
    }

    /// Messages that came with the last poll.
    pub fn new_count(&self) -> u32 {
        self.freshness.new_count
    }

    /// Messages lost so far, counted by the gaps in the sequence numbers.
    pub fn missed_count(&self) -> u64 {
        self.missed_count
    }

    /// What the parser threw away so far.
    pub fn tally(&self) -> Tally {
        self.parser.tally()
    }

    /// The newest report of the built-in test: one comes after power-up, others on [`Kvh::request_bit`].
    pub fn bit(&self) -> Option<&BitReport> {
        self.bit.as_ref()
    }

    /// Asks for the built-in test; the report follows a message within about 100 ms.
    ///
    /// # Errors
    /// When the line is gone.
    pub fn request_bit(&self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        line.write(now, b"?BIT,2\r\n")
    }

    /// Identity as read from the unit.
    pub fn identity(&self) -> &KvhIdentity {
        &self.identity
    }

    /// The settings it was opened with.
    pub fn settings(&self) -> &KvhSettings {
        &self.settings
    }

    /// The values in the order of [`Kvh::CHANNELS`]; status 0 ("nothing valid") before the first message.
    pub fn row(&self) -> [f64; 10] {
        let Sample { rate_rad_per_s: [x, y, z], acceleration_m_per_s2: [ax, ay, az], .. } = self.last;
        let status = f64::from(self.last.status);
        let sequence = f64::from(self.last.sequence);
        [
            x,
            y,
            z,
            ax,
            ay,
            az,
            self.last.temperature_degc,
            status,
            sequence,
            f64::from(self.freshness.age_ticks),
        ]
    }
}

/// Messages lost between two sequence numbers, which count modulo 128. The same number twice means 127 lost messages,
/// because the unit numbers every message anew.
fn missed_between(last: u8, next: u8) -> u8 {
    next.wrapping_sub(last).wrapping_sub(1) & 0x7F
}

const fn channel(name: &'static str, unit: &'static str, width: Width) -> Channel {
    Channel { name, unit, width }
}
