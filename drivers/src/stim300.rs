//! Sensonor/Safran STIM300 inertial measurement unit on an RS-422 line (datasheet TS1524 rev. 31): datagrams, checksum,
//! configuration.
//!
//! What the numbers in a datagram mean (rate or angle, range of the accelerometers) is state of the unit and not in the
//! datagram, so [`Opening`] asks for the configuration before [`Stim300`] exists, and a configuration datagram that differs ends
//! the use of the unit with an error.

mod configuration;
mod configure;
mod datagram;
mod parser;
mod scale;
mod service;
mod special;
#[cfg(test)]
mod tests;

use std::time::Duration;

pub use self::configuration::{
    AccelerometerRange, Configuration, ForceUnit, GyroUnit, Parity, PpsUnit, SampleRate, UnknownCode,
};
pub use self::configure::Opening;
pub use self::datagram::{Content, Input, Measurement, SpecialKind, Triad, checksum};
pub use self::parser::{Found, Parser};
pub use self::special::{BiasTrim, ExtendedErrors, Special};
pub use crate::framing::Tally;

use self::configuration::INTERNAL_RATE_HZ;
use self::scale::Scales;
use crate::device::{Channel, DeviceError, Width};
use crate::framing::{Arrival, Freshness, STALE_PERIODS, read_waiting};
use crate::wire::ByteLine;

/// Silence after which a unit with an external trigger is stale; the driver does not know how often it is triggered.
const STALE_TRIGGERED_S: f64 = 0.02;
/// Numbers of measurements begin anew after so many.
const SEQUENCE_MODULUS: u32 = 128;
/// Bits of a status byte that speak of the whole unit: system integrity, start-up, outside operating conditions.
const WHOLE_UNIT_BITS: u8 = 0b1110_0000;
/// Bits of a status byte that say that something is wrong with the channels of bits 0 to 2: overload, error.
const CHANNEL_BITS: u8 = 0b0001_1000;

/// What the unit must be told and checked against.
#[derive(Clone, Debug, PartialEq)]
pub struct Stim300Settings {
    /// Name in errors and topics, e.g. `imu`.
    pub name: String,
    /// Bit rate of the line, bit/s: 374400, 460800, 921600, 1843200 or what the user has defined.
    pub bit_rate: u32,
    /// What a measurement carries. Datagrams with accelerometers or inclinometers only (91h, 92h) have a checksum without filling.
    pub content: Content,
    /// When a measurement is sent.
    pub sample_rate: SampleRate,
    /// What the gyro fields are. With an external trigger an increment is divided by the time since the last measurement that
    /// came; if one was lost on the line, which cannot be seen there, the rate is too low.
    pub gyro_unit: GyroUnit,
    /// What the accelerometer fields are; the same holds for increments.
    pub accelerometer_unit: ForceUnit,
    /// Whether [`Opening`] may change what differs, until the unit is switched off. Otherwise it refuses the unit.
    pub may_change_unit: bool,
    /// Time allowed for each answer, s. The listing at the begin of service mode takes 60 ms at 374400 bit/s.
    pub answer_timeout_s: f64,
}

/// Identity as read from the unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stim300Identity {
    /// Part number and revision, e.g. `84167-4400003-321 REV K`.
    pub part_number: String,
    /// Serial number, e.g. `N25582405002002`; that of a simulated unit contains `SIM`.
    pub serial: String,
    /// Configuration as read back.
    pub configuration: Configuration,
}

/// One measurement in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Angular rates about X, Y, Z, positive by the right-hand rule; 0 where they cannot be told.
    pub rate_rad_per_s: [f64; 3],
    /// Specific force along X, Y, Z; 0 where it is not part of the datagram or cannot be told.
    pub acceleration_m_per_s2: [f64; 3],
    /// Specific force along X, Y, Z of the inclinometers.
    pub inclination_m_per_s2: Option<[f64; 3]>,
    /// Mean temperature of the gyros, °C.
    pub temperature_degc: Option<f64>,
    /// Time from the last edge of PPS to the sampling, s.
    pub since_pps_s: Option<f64>,
    /// Voltage at the AUX input of older units.
    pub aux_v: Option<f64>,
    /// Whether gyro X, Y, Z and accelerometer X, Y, Z are valid.
    pub valid: [bool; 6],
    /// Raw status byte of the gyros; 0 is healthy.
    pub gyro_status: u8,
    /// Raw status byte of the accelerometers.
    pub accelerometer_status: u8,
    /// Number of the internal sample, 2000 per second, modulo 256.
    pub counter: u8,
    /// Number of the measurement modulo 128. Lost measurements and those that special datagrams replaced are counted, with an
    /// external trigger only those that came.
    pub sequence: u8,
    /// Time from the sampling to the first bit, as the unit says.
    pub latency_s: f64,
    /// Latest time of the sampling since the start of the run: that of the poll less the time of the bytes on the wire and less
    /// the latency. The sampling may have been earlier by the time between two polls at the most. Filters and the delayed gyro
    /// units add their group delay; it is not taken off.
    pub sampled_at: Duration,
}

/// A unit whose configuration has been verified and which sends measurements.
#[derive(Clone, Debug)]
pub struct Stim300 {
    settings: Stim300Settings,
    identity: Stim300Identity,
    scales: Scales,
    parser: Parser,
    arrival: Arrival,
    byte_s: f64,
    last: Sample,
    /// Gyro counts of the newest measurement.
    last_gyros: [i32; 3],
    /// Whether any measurement has come yet.
    seen: bool,
    /// Measurements that the special datagrams since the newest one can have replaced.
    replaceable_count: u32,
    /// Whether a special datagram has come since the newest measurement.
    special_came: bool,
    freshness: Freshness,
    /// Valid rates of the poll that brought the newest measurement, and how many they are.
    rate_sums_rad_per_s: [f64; 3],
    rates_count: u32,
    missed_count: u64,
    replaced_count: u64,
    special: Option<Special>,
    errors: Option<ExtendedErrors>,
    bias_trim: Option<BiasTrim>,
}

impl Stim300 {
    /// What the driver publishes each tick, in the order of [`Stim300::row`]. `status` holds the status byte of the gyros, plus 256
    /// times that of the accelerometers.
    pub const CHANNELS: &'static [Channel] = &[
        channel("temperature_degc", "degC", Width::F32),
        channel("rate_x_rad_per_s", "rad/s", Width::F32),
        channel("rate_y_rad_per_s", "rad/s", Width::F32),
        channel("rate_z_rad_per_s", "rad/s", Width::F32),
        channel("acceleration_x_m_per_s2", "m/s^2", Width::F32),
        channel("acceleration_y_m_per_s2", "m/s^2", Width::F32),
        channel("acceleration_z_m_per_s2", "m/s^2", Width::F32),
        channel("latency_s", "s", Width::F32),
        channel("status", "", Width::U16),
        channel("counter", "", Width::U16),
        channel("sequence", "", Width::U16),
        channel("age_ticks", "", Width::U16),
    ];

    /// The channels of a unit whose datagram carries no temperature: all but the first.
    pub const CHANNELS_WITHOUT_TEMPERATURE: &'static [Channel] = Self::CHANNELS.split_at(1).1;

    fn new(settings: Stim300Settings, identity: Stim300Identity) -> Self {
        let byte_s = identity.configuration.bits_per_byte() / f64::from(settings.bit_rate);
        Self {
            scales: Scales::new(&identity.configuration),
            settings,
            identity,
            parser: Parser::default(),
            arrival: Arrival::default(),
            byte_s,
            last: Sample::default(),
            last_gyros: [0; 3],
            seen: false,
            replaceable_count: 0,
            special_came: false,
            freshness: Freshness::default(),
            rate_sums_rad_per_s: [0.0; 3],
            rates_count: 0,
            missed_count: 0,
            replaced_count: 0,
            special: None,
            errors: None,
            bias_trim: None,
        }
    }

    /// Reads what arrived up to `now` and keeps the newest measurement. Returns the number of new measurements. Call once per
    /// tick.
    ///
    /// # Errors
    /// When the line is gone, or when the unit has another configuration than it was opened with.
    pub fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<u32, DeviceError> {
        let mut measurements_count = 0;
        let before = (self.rate_sums_rad_per_s, self.rates_count);
        (self.rate_sums_rad_per_s, self.rates_count) = ([0.0; 3], 0);
        let read = read_waiting(line, now, |bytes| {
            measurements_count += self.take(bytes)?;
            Ok(())
        });
        if measurements_count > 0 {
            let sent_at = self.arrival.began(now, self.byte_s);
            self.last.sampled_at = sent_at.saturating_sub(Duration::from_secs_f64(self.last.latency_s));
        }
        if measurements_count == 0 {
            (self.rate_sums_rad_per_s, self.rates_count) = before;
        }
        // A line that is gone brings nothing: what came before it ages.
        self.freshness.polled(now, measurements_count);
        read.map(|()| measurements_count)
    }

    /// Parses the next bytes of the stream, in pieces of any size. Returns the number of measurements that they completed.
    fn take(&mut self, bytes: &[u8]) -> Result<u32, DeviceError> {
        self.parser.push(bytes);
        self.arrival.bytes_came(bytes.len());
        let mut measurements_count = 0;
        while let Some(found) = self.parser.next() {
            match found {
                Found::Measurement(measurement) => {
                    self.check_content(measurement.content)?;
                    self.arrival.frame_found(measurement.content.bytes(), self.parser.waiting_bytes());
                    self.accept(&measurement);
                    self.sum_rates();
                    measurements_count += 1;
                }
                Found::Special(special) => self.accept_special(&special)?,
            }
        }
        Ok(measurements_count)
    }

    fn check_content(&self, content: Content) -> Result<(), DeviceError> {
        let expected = self.identity.configuration.content;
        if content == expected {
            return Ok(());
        }
        Err(self.error(
            "datagram",
            format!("{:02X}h", expected.id()),
            format!("{:02X}h", content.id()),
            "the unit was reset or configured anew: open it again",
        ))
    }

    fn accept_special(&mut self, special: &Special) -> Result<(), DeviceError> {
        // Longer than a period, it replaces more than one measurement (TS1524, section 8).
        let wire_s = (1 + special.payload().len() + 4) as f64 * self.byte_s;
        let periods = match self.identity.configuration.sample_rate {
            SampleRate::Internal(rate_hz) => (wire_s * f64::from(rate_hz)).ceil() as u32,
            SampleRate::External => 0,
        };
        self.replaceable_count = self.replaceable_count.saturating_add(periods.max(1));
        self.special_came = true;
        self.special = Some(*special);
        self.errors = special.extended_errors().or(self.errors);
        self.bias_trim = special.bias_trim().or(self.bias_trim);
        let Some(payload) = special.payload().first_chunk::<21>() else { return Ok(()) };
        if special.kind() != SpecialKind::Configuration
            || Configuration::decode(payload).as_ref() == Ok(&self.identity.configuration)
        {
            return Ok(());
        }
        Err(self.error(
            "configuration",
            "that of the opening".to_owned(),
            "another one".to_owned(),
            "the unit was configured anew while it was in use: open it again",
        ))
    }

    fn accept(&mut self, measurement: &Measurement) {
        // The same number twice means 256 samples: the unit counts on.
        let passed = u32::from(measurement.counter.wrapping_sub(self.last.counter).wrapping_sub(1)) + 1;
        let samples = self.identity.configuration.sample_rate.samples_per_measurement();
        let special_came = std::mem::take(&mut self.special_came);
        self.count_lost(passed, samples);
        let numbers = match samples {
            Some(samples) if self.seen => (passed / samples.max(1)).max(1),
            _ => 1,
        };
        let elapsed_s = self.seen.then(|| f64::from(passed) / INTERNAL_RATE_HZ);
        // What passed while a special datagram was sent is not in the increments behind it (TS1524, section 8).
        let interval_s = match samples {
            Some(samples) => Some(f64::from(samples) / INTERNAL_RATE_HZ),
            None => elapsed_s.filter(|_| !special_came),
        };
        let before = self.seen.then_some(self.last_gyros);
        let scales = &self.scales;
        let rates = scales.rates(&measurement.gyros, before, interval_s, elapsed_s);
        let content = measurement.content;
        let accelerations =
            scales.accelerations(&measurement.accelerometers, interval_s).filter(|_| content.accelerometers);
        let gyros_valid = valid(measurement.gyros.status).map(|valid| valid && rates.is_some());
        let accelerometers_valid =
            valid(measurement.accelerometers.status).map(|valid| valid && accelerations.is_some());
        let [a, b, c] = gyros_valid;
        let [d, e, f] = accelerometers_valid;
        self.last = Sample {
            rate_rad_per_s: rates.unwrap_or_default(),
            acceleration_m_per_s2: accelerations.unwrap_or_default(),
            inclination_m_per_s2: scales
                .inclinations(&measurement.inclinometers, interval_s)
                .filter(|_| content.inclinometers),
            temperature_degc: scales.temperature_degc(measurement),
            since_pps_s: scales.since_pps_s(measurement),
            aux_v: scales.aux_v(measurement),
            valid: [a, b, c, d, e, f],
            gyro_status: measurement.gyros.status,
            accelerometer_status: measurement.accelerometers.status,
            counter: measurement.counter,
            sequence: ((u32::from(self.last.sequence) + numbers) % SEQUENCE_MODULUS) as u8,
            latency_s: 1e-6 * f64::from(measurement.latency_us),
            sampled_at: self.last.sampled_at,
        };
        self.last_gyros = measurement.gyros.counts;
        self.seen = true;
    }

    /// Counts the measurements that should have come in `passed` internal samples and did not.
    fn count_lost(&mut self, passed: u32, samples: Option<u32>) {
        let replaceable_count = std::mem::take(&mut self.replaceable_count);
        let Some(samples) = samples.filter(|samples| self.seen && *samples > 0) else { return };
        let lost_count = (passed / samples).max(1) - 1;
        let replaced_count = lost_count.min(replaceable_count);
        self.replaced_count += u64::from(replaced_count);
        self.missed_count += u64::from(lost_count - replaced_count);
    }

    /// Asks for a special datagram; it replaces the next measurement or several.
    ///
    /// # Errors
    /// When the line is gone.
    pub fn request(
        &self,
        line: &mut dyn ByteLine,
        kind: SpecialKind,
        now: Duration,
    ) -> Result<(), DeviceError> {
        line.write(now, &[kind.letter() as u8, b'\r'])
    }

    /// Resets the unit: it sends its identity, then measurements, which are not valid for about half a second.
    ///
    /// # Errors
    /// When the line is gone.
    pub fn reset(&self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        line.write(now, b"R\r")
    }

    fn sum_rates(&mut self) {
        if self.last.valid[..3] == [true; 3] {
            let sums = self.rate_sums_rad_per_s.iter_mut();
            sums.zip(self.last.rate_rad_per_s).for_each(|(sum, rate)| *sum += rate);
            self.rates_count += 1;
        }
    }

    /// Mean rates of the valid measurements that came with the newest one, rad/s; those of the newest one if none is valid. Picking
    /// one of several measurements of a tick would fold their noise.
    pub fn mean_rates_rad_per_s(&self) -> [f64; 3] {
        match self.rates_count {
            0 => self.last.rate_rad_per_s,
            count => self.rate_sums_rad_per_s.map(|sum| sum / f64::from(count)),
        }
    }

    /// The newest measurement; `None` before the first.
    pub fn sample(&self) -> Option<&Sample> {
        self.seen.then_some(&self.last)
    }

    /// The newest measurement if all gyros are valid in it. Accelerometers and the age are not checked.
    ///
    /// # Errors
    /// [`DeviceError::Field`] with the status byte if a gyro is not valid or nothing arrived yet.
    pub fn valid_sample(&self) -> Result<&Sample, DeviceError> {
        if self.seen && self.last.valid[..3] == [true; 3] {
            return Ok(&self.last);
        }
        let found =
            if self.seen { format!("{:02X}h", self.last.gyro_status) } else { "no measurement".to_owned() };
        let help = "a unit that has just been powered needs 1 s; then ask for the extended errors (E)";
        Err(self.error("status byte of the gyros", "00h".to_owned(), found, help))
    }

    /// Whether no measurement has come for ten periods (20 ms with an external trigger), or none at all.
    pub fn is_stale(&self, now: Duration) -> bool {
        let limit_s = match self.identity.configuration.sample_rate {
            SampleRate::Internal(rate_hz) => STALE_PERIODS / f64::from(rate_hz),
            SampleRate::External => STALE_TRIGGERED_S,
        };
        !self.seen || self.silent_s(now) > limit_s
    }

    /// How long no measurement has come, s; 0 before the first.
    pub fn silent_s(&self, now: Duration) -> f64 {
        if self.seen { self.freshness.silent_s(now) } else { 0.0 }
    }

    /// Ticks since the newest measurement arrived.
    pub fn age_ticks(&self) -> u16 {
        self.freshness.age_ticks
    }

    /// Measurements that came with the last poll.
    pub fn new_count(&self) -> u32 {
        self.freshness.new_count
    }

    /// Measurements lost so far, by the gaps in the counter. It stays 0 with an external trigger: the counter does not number
    /// the triggers.
    pub fn missed_count(&self) -> u64 {
        self.missed_count
    }

    /// Measurements that were not sent because special datagrams took their place.
    pub fn replaced_count(&self) -> u64 {
        self.replaced_count
    }

    /// What the parser threw away so far.
    pub fn tally(&self) -> Tally {
        self.parser.tally()
    }

    /// The newest special datagram of any kind.
    pub fn special(&self) -> Option<&Special> {
        self.special.as_ref()
    }

    /// The newest extended error information.
    pub fn extended_errors(&self) -> Option<ExtendedErrors> {
        self.errors
    }

    /// The newest bias trim offsets.
    pub fn bias_trim(&self) -> Option<&BiasTrim> {
        self.bias_trim.as_ref()
    }

    /// Identity as read from the unit.
    pub fn identity(&self) -> &Stim300Identity {
        &self.identity
    }

    /// The settings it was opened with.
    pub fn settings(&self) -> &Stim300Settings {
        &self.settings
    }

    /// The values in the order of [`Stim300::CHANNELS`]; all 0 but the temperature before the first measurement. The temperature is
    /// not a number if the datagram carries none.
    pub fn row(&self) -> [f64; 12] {
        let last = &self.last;
        let [x, y, z] = last.rate_rad_per_s;
        let [ax, ay, az] = last.acceleration_m_per_s2;
        let temperature_degc = last.temperature_degc.unwrap_or(f64::NAN);
        let status = f64::from(last.gyro_status) + 256.0 * f64::from(last.accelerometer_status);
        let [counter, sequence] = [last.counter, last.sequence].map(f64::from);
        let age_ticks = f64::from(self.freshness.age_ticks);
        [temperature_degc, x, y, z, ax, ay, az, last.latency_s, status, counter, sequence, age_ticks]
    }

    fn error(&self, field: &'static str, expected: String, found: String, help: &'static str) -> DeviceError {
        DeviceError::Field { device: self.settings.name.clone(), field, expected, found, help }
    }
}

/// Which of X, Y, Z a status byte calls valid (TS1524, table 5-23).
fn valid(status: u8) -> [bool; 3] {
    let axes = status & 0b111;
    let whole_unit_bad = status & WHOLE_UNIT_BITS != 0 || (status & CHANNEL_BITS != 0 && axes == 0);
    [0, 1, 2].map(|axis| !whole_unit_bad && axes >> axis & 1 == 0)
}

const fn channel(name: &'static str, unit: &'static str, width: Width) -> Channel {
    Channel { name, unit, width }
}
