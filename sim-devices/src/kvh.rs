//! The KVH inertial measurement unit at the far end of its line.
//!
//! In `MSYNC,EXT` each pulse makes a message with the mean motion since the pulse before (the unit then filters with
//! uniform averagers); in `MSYNC,IMU` the unit's own data rate does, at the first pulse after each of its instants,
//! and its Butterworth filter is not simulated: the mean is over the data period.

mod command;
mod configuration;
mod message;
#[cfg(test)]
mod tests;
mod transmitter;

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

pub use self::command::BAUDS;
use self::command::Interpreter;
use self::configuration::Configuration;
use self::transmitter::Transmitter;
use crate::motion::Motion;
use crate::physics::inertial::{Felt, Mount, Sensor, SensorErrors};
use crate::physics::noise::{Noise, SeedAddress};
use crate::unit::{ImuSettings, warmed_degc};
use drivers::device::DeviceError;
use drivers::wire::ByteLine;

/// All sensors valid.
const HEALTHY: u8 = 0x77;
/// Accelerometers valid, gyros not yet.
const STARTING: u8 = 0x70;
/// Size of what stands in the gyro fields before the gyros are valid, rad/s (a real capture: 2 rad/s).
const GARBAGE_RAD_PER_S: f64 = 2.0;
const GYROS: [&str; 3] = ["imu.gyro-x", "imu.gyro-y", "imu.gyro-z"];
const ACCELEROMETERS: [&str; 3] = ["imu.accelerometer-x", "imu.accelerometer-y", "imu.accelerometer-z"];

/// What can go wrong with a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageFault {
    /// A bit of the checksum is wrong.
    Checksum,
    /// The message is not sent; its number is used up.
    Dropped,
    /// The unit says that gyro X is not valid.
    InvalidStatus,
}

/// The unit.
#[derive(Clone, Debug)]
pub struct Kvh {
    mount: Mount,
    gyros: [Sensor; 3],
    gyro_signs: [f64; 3],
    accelerometers: [Sensor; 3],
    garbage: Noise,
    pulse_s: f64,
    startup_s: f64,
    temperature_degc: f64,
    warming: Warming,
    configuration: Configuration,
    interpreter: Interpreter,
    transmitter: Transmitter,
    /// Tick and motion of the last message.
    before: Option<(u64, Motion)>,
    /// Instants of the own data rate that have passed.
    data_count: u64,
    sequence: u8,
    fault: Option<(MessageFault, u32)>,
    silent: bool,
    frozen: bool,
    offset_rad_per_s: f64,
    /// What the last message said.
    said: ([f64; 3], [f64; 3]),
}

impl Kvh {
    /// A unit that was powered up at time 0 in its configuration from the factory, and gets `pulse_rate_hz` pulses
    /// on its MSYNC input.
    pub fn new(imu: &ImuSettings, address: &SeedAddress, pulse_rate_hz: f64) -> Self {
        let pulse_s = 1.0 / pulse_rate_hz;
        let sensors = |names: [&str; 3], errors: [SensorErrors; 3]| {
            [0, 1, 2].map(|k| Sensor::new(&errors[k], address, names[k], pulse_s))
        };
        let mut unit = Self {
            mount: Mount::new(imu),
            gyros: sensors(GYROS, gyro_errors(imu)),
            gyro_signs: imu.gyro_sign_factor.map(f64::signum),
            accelerometers: sensors(ACCELEROMETERS, accelerometer_errors(imu)),
            garbage: Noise::new(address, "imu.garbage", GARBAGE_RAD_PER_S),
            pulse_s,
            startup_s: imu.startup_s,
            temperature_degc: imu.temperature_degc,
            warming: Warming::new(imu),
            configuration: Configuration::factory(imu),
            interpreter: Interpreter::default(),
            transmitter: Transmitter::new(imu.baud_count),
            before: None,
            data_count: 0,
            sequence: 0,
            fault: None,
            silent: false,
            frozen: false,
            offset_rad_per_s: 0.0,
            said: Default::default(),
        };
        unit.interpreter.ask_for_bit(6);
        unit
    }

    /// The unit at a point that begins so long after the beginning of the campaign, by the plan.
    pub(crate) fn after(mut self, planned_s: f64) -> Self {
        self.warming.planned_s = planned_s;
        self
    }

    /// The MSYNC pulse number `tick`; pulses may be missing.
    pub fn pulse(&mut self, tick: u64, motion: &Motion) {
        let now_s = tick as f64 * self.pulse_s;
        if !self.is_due(now_s) {
            return;
        }
        let before = self.before.replace((tick, *motion));
        let (averaging_s, mean) = match before {
            Some((earlier, before)) if earlier < tick => {
                let averaging_s = (tick - earlier) as f64 * self.pulse_s;
                (averaging_s, motion.mean_since(&before, averaging_s))
            }
            _ => (self.period_s(), *motion),
        };
        if self.interpreter.in_config_mode() {
            return;
        }
        let felt = self.mount.feel(&mean);
        self.report(tick, now_s, averaging_s, &felt);
    }

    /// Whether this pulse makes a message.
    fn is_due(&mut self, now_s: f64) -> bool {
        if self.configuration.external {
            return true;
        }
        // The guard keeps an instant that coincides with a pulse from waiting for the next one.
        let count = (now_s * self.configuration.data_rate_hz + 1e-6) as u64 + 1;
        let due = count != self.data_count;
        self.data_count = count;
        due
    }

    fn period_s(&self) -> f64 {
        if self.configuration.external { self.pulse_s } else { 1.0 / self.configuration.data_rate_hz }
    }

    fn report(&mut self, tick: u64, now_s: f64, averaging_s: f64, felt: &Felt) {
        let mut rates = [0.0; 3];
        let mut forces = [0.0; 3];
        let warmer_degc = self.warming.degc(now_s);
        for k in 0..3 {
            let felt_rate = self.warming.of_rate(felt.rate_rad_per_s[k], warmer_degc);
            let rate = self.gyros[k].read(tick, averaging_s, felt_rate);
            rates[k] = self.gyro_signs[k] * rate;
            forces[k] = self.accelerometers[k].read(tick, averaging_s, felt.specific_force_m_per_s2[k]);
        }
        let mut status = HEALTHY;
        if now_s < self.startup_s {
            status = STARTING;
            rates = [0, 1, 2].map(|k| self.garbage.at(3 * tick + k));
        }
        rates = rates.map(|rate| rate + self.offset_rad_per_s);
        if self.frozen {
            (rates, forces) = self.said;
        }
        self.said = (rates, forces);
        let fault = self.take_fault();
        if fault == Some(MessageFault::InvalidStatus) {
            status &= !1;
        }
        let sequence = self.sequence;
        self.sequence = (sequence + 1) & 0x7F;
        if self.silent || fault == Some(MessageFault::Dropped) {
            return;
        }
        let content = message::Content {
            rotation: self.configuration.rotation(rates, averaging_s),
            acceleration: self.configuration.acceleration(forces, averaging_s),
            temperature: self.configuration.temperature(self.temperature_degc + warmer_degc),
            time_s: now_s,
            status,
            sequence,
        };
        let mut frame = content.frame(self.configuration.format);
        if fault == Some(MessageFault::Checksum) {
            frame.spoil_checksum();
        }
        if self.transmitter.send(nanoseconds(now_s), frame.bytes()) {
            self.send_bit_report(now_s);
        }
    }

    /// A report of the built-in test that is due goes out after a message.
    fn send_bit_report(&mut self, now_s: f64) {
        if let Some(length) = self.interpreter.take_bit_request() {
            let mut report = [0x7F; 13];
            report[..4].copy_from_slice(&[0xFE, 0x81, 0x00, if length == 6 { 0xAA } else { 0xAB }]);
            let sum = report[..4 + length].iter().fold(0_u8, |sum, &byte| sum.wrapping_add(byte));
            report[4 + length] = sum;
            self.transmitter.append(nanoseconds(now_s), &report[..5 + length]);
        }
    }

    fn take_fault(&mut self) -> Option<MessageFault> {
        let (fault, count) = self.fault.take()?;
        self.fault = (count > 1).then(|| (fault, count - 1));
        Some(fault)
    }

    /// Spoils the next `count` messages.
    pub fn inject(&mut self, fault: MessageFault, count: u32) {
        self.fault = (count > 0).then_some((fault, count));
    }

    /// The unit sends no message any more.
    pub(crate) fn fall_silent(&mut self) {
        self.silent = true;
    }

    /// The unit goes on sending the rates and accelerations of its last message, numbered and summed as they should be.
    pub(crate) fn freeze(&mut self) {
        self.frozen = true;
    }

    /// The gyros read this much more from now on, rad/s.
    pub(crate) fn shift_gyros(&mut self, by_rad_per_s: f64) {
        self.offset_rad_per_s += by_rad_per_s;
    }

    /// Bytes that have arrived at the host by `now`.
    pub fn read(&mut self, now: Duration, into: &mut [u8]) -> usize {
        self.transmitter.take(whole_nanoseconds(now), into)
    }

    /// Bytes from the host; what they ask for is answered from `now` on.
    pub fn write(&mut self, now: Duration, bytes: &[u8]) {
        for &byte in bytes {
            if let Some(reply) = self.interpreter.feed(byte, &mut self.configuration) {
                // The answer to =BAUD comes at the new rate already.
                self.transmitter.set_baud(self.configuration.baud);
                self.transmitter.append(whole_nanoseconds(now), reply.as_bytes());
            }
        }
    }
}

/// How the unit warms up over a campaign, and what that makes of its gyros.
#[derive(Clone, Copy, Debug)]
struct Warming {
    planned_s: f64,
    rise_degc: f64,
    time_constant_s: f64,
    scale_per_k_ratio: f64,
    bias_per_k_rad_per_s: f64,
}

impl Warming {
    fn new(imu: &ImuSettings) -> Self {
        Self {
            planned_s: 0.0,
            rise_degc: imu.warm_up_degc,
            time_constant_s: imu.warm_up_time_s,
            scale_per_k_ratio: imu.gyro_scale_per_k_ratio,
            bias_per_k_rad_per_s: imu.gyro_bias_per_k_rad_per_s,
        }
    }

    /// What the unit is warmer at a time of the point than when the campaign began.
    fn degc(&self, now_s: f64) -> f64 {
        if self.rise_degc == 0.0 {
            return 0.0;
        }
        warmed_degc(self.rise_degc, self.time_constant_s, self.planned_s + now_s)
    }

    /// What a gyro that is so much warmer makes of a rate.
    fn of_rate(&self, rate_rad_per_s: f64, warmer_degc: f64) -> f64 {
        if warmer_degc == 0.0 {
            return rate_rad_per_s;
        }
        (1.0 + self.scale_per_k_ratio * warmer_degc) * rate_rad_per_s
            + self.bias_per_k_rad_per_s * warmer_degc
    }
}

fn gyro_errors(imu: &ImuSettings) -> [SensorErrors; 3] {
    [0, 1, 2].map(|k| SensorErrors {
        random_walk_per_sqrt_hz: imu.gyro_random_walk_rad_per_sqrt_s * imu.gyro_noise_factor,
        bias_instability: imu.gyro_bias_instability_rad_per_s,
        // K·√t is what a random walk gathers in t.
        rate_walk_per_sqrt_s: imu.gyro_hourly_walk_rad_per_s / 3600.0_f64.sqrt(),
        bias: imu.gyro_bias_rad_per_s[k],
        scale_error_ratio: imu.gyro_scale_error_ratio[k],
        quantum: imu.gyro_quantum_rad_per_s,
        spike: imu.gyro_spike_rad_per_s,
        spike_rate_hz: imu.gyro_spike_rate_hz,
    })
}

fn accelerometer_errors(imu: &ImuSettings) -> [SensorErrors; 3] {
    [0, 1, 2].map(|k| SensorErrors {
        random_walk_per_sqrt_hz: imu.accelerometer_random_walk_m_per_s_per_sqrt_s,
        bias_instability: imu.accelerometer_bias_instability_m_per_s2,
        rate_walk_per_sqrt_s: 0.0,
        bias: imu.accelerometer_bias_m_per_s2[k],
        scale_error_ratio: imu.accelerometer_scale_error_ratio[k],
        quantum: 0.0,
        spike: 0.0,
        spike_rate_hz: 0.0,
    })
}

fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

fn whole_nanoseconds(now: Duration) -> u64 {
    u64::try_from(now.as_nanos()).unwrap_or(u64::MAX)
}

/// The host's end of the line to a unit that others hold too.
#[derive(Clone, Debug)]
pub struct KvhLine(pub Rc<RefCell<Kvh>>);

impl ByteLine for KvhLine {
    fn name(&self) -> &str {
        "imu line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        Ok(self.0.borrow_mut().read(now, into))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.0.borrow_mut().write(now, bytes);
        Ok(())
    }
}
