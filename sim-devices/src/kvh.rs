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

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

pub use self::command::BAUDS;
use self::command::Interpreter;
use self::configuration::Configuration;
use crate::inertial_unit::InertialSensors;
pub use crate::inertial_unit::MessageFault;
use crate::motion::Motion;
use crate::physics::noise::{Noise, SeedAddress};
use crate::transmitter::{Transmitter, nanoseconds, whole_nanoseconds};
use crate::unit::ImuSettings;
use drivers::device::DeviceError;
use drivers::wire::ByteLine;

/// All sensors valid.
const HEALTHY: u8 = 0x77;
/// Accelerometers valid, gyros not yet.
const STARTING: u8 = 0x70;
/// Size of what stands in the gyro fields before the gyros are valid, rad/s (a real capture: 2 rad/s).
const GARBAGE_RAD_PER_S: f64 = 2.0;

/// A pulse on the MSYNC input that made a message.
#[derive(Clone, Copy, Debug)]
struct Pulse {
    tick: u64,
    /// Instant of pulse 0 by the grid that the pulses had then.
    phase_s: f64,
    motion: Motion,
}

/// The unit.
#[derive(Clone, Debug)]
pub struct Kvh {
    sensors: InertialSensors,
    garbage: Noise,
    pulse_s: f64,
    /// Instant of pulse 0, as the last pulse has it.
    phase_s: f64,
    startup_s: f64,
    configuration: Configuration,
    interpreter: Interpreter,
    transmitter: Transmitter,
    /// Pulse of the last message.
    before: Option<Pulse>,
    /// Instants of the own data rate that have passed.
    data_count: u64,
    sequence: u8,
    silent: bool,
    /// Bytes of the built-in test, bit 1 = passed.
    self_tests: [u8; 8],
}

impl Kvh {
    /// A unit that was powered up at time 0 in its configuration from the factory, and gets `pulse_rate_hz` pulses
    /// on its MSYNC input.
    pub fn new(imu: &ImuSettings, address: &SeedAddress, pulse_rate_hz: f64) -> Self {
        let pulse_s = 1.0 / pulse_rate_hz;
        let mut unit = Self {
            sensors: InertialSensors::new(imu, address, pulse_s),
            garbage: Noise::new(address, "imu.garbage", GARBAGE_RAD_PER_S),
            pulse_s,
            phase_s: 0.0,
            startup_s: imu.startup_s,
            configuration: Configuration::factory(imu),
            interpreter: Interpreter::default(),
            transmitter: Transmitter::new(imu.baud_count),
            before: None,
            data_count: 0,
            sequence: 0,
            silent: false,
            self_tests: [0x7F; 8],
        };
        unit.interpreter.ask_for_bit(6);
        unit
    }

    /// The unit at a point that begins so long after the beginning of the campaign, by the plan.
    pub(crate) fn after(mut self, planned_s: f64) -> Self {
        self.sensors.begin_after(planned_s);
        self
    }

    /// From the next pulse on, pulse 0 of this grid was at an instant other than 0 of the world.
    pub(crate) fn set_phase(&mut self, phase_s: f64) {
        self.phase_s = phase_s;
    }

    /// The MSYNC pulse number `tick`; pulses may be missing.
    pub fn pulse(&mut self, tick: u64, motion: &Motion) {
        let now_s = tick as f64 * self.pulse_s + self.phase_s;
        if !self.is_due(now_s) {
            return;
        }
        let before = self.before.replace(Pulse { tick, phase_s: self.phase_s, motion: *motion });
        let (averaging_s, mean) = match before {
            Some(before) if before.tick < tick => {
                let averaging_s =
                    (tick - before.tick) as f64 * self.pulse_s + (self.phase_s - before.phase_s);
                (averaging_s, motion.mean_since(&before.motion, averaging_s))
            }
            _ => (self.period_s(), *motion),
        };
        if self.interpreter.in_config_mode() {
            return;
        }
        self.report(tick, now_s, averaging_s, &mean);
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

    fn report(&mut self, tick: u64, now_s: f64, averaging_s: f64, mean: &Motion) {
        let mut measured = self.sensors.measure(tick, now_s, averaging_s, mean);
        let mut status = HEALTHY;
        if now_s < self.startup_s {
            status = STARTING;
            measured.rate_rad_per_s = [0, 1, 2].map(|k| self.garbage.at(3 * tick + k));
        }
        let reported = self.sensors.report(measured);
        let fault = self.sensors.take_fault();
        if fault == Some(MessageFault::InvalidStatus) {
            status &= !1;
        }
        let sequence = self.sequence;
        self.sequence = (sequence + 1) & 0x7F;
        if self.silent || fault == Some(MessageFault::Dropped) {
            return;
        }
        let content = message::Content {
            rotation: self.configuration.rotation(reported.rate_rad_per_s, averaging_s),
            acceleration: self.configuration.acceleration(reported.force_m_per_s2, averaging_s),
            temperature: self.configuration.temperature(self.sensors.temperature_degc(now_s)),
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
            let report = message::bit_report(&self.self_tests, length);
            self.transmitter.append(nanoseconds(now_s), report.bytes());
        }
    }

    /// A test of the built-in test fails from now on: 0 to 55, seven to a byte; the first 42 are in the short report too.
    pub fn fail_self_test(&mut self, test: usize) {
        if let Some(byte) = self.self_tests.get_mut(test / 7) {
            *byte &= !(1 << (test % 7));
        }
    }

    /// Spoils the next `count` messages.
    pub fn inject(&mut self, fault: MessageFault, count: u32) {
        self.sensors.inject(fault, count);
    }

    /// The unit sends no message any more.
    pub(crate) fn fall_silent(&mut self) {
        self.silent = true;
    }

    /// The unit goes on sending the rates and accelerations of its last message, numbered and summed as they should be.
    pub(crate) fn freeze(&mut self) {
        self.sensors.freeze();
    }

    /// The gyros read this much more from now on, rad/s.
    pub(crate) fn shift_gyros(&mut self, by_rad_per_s: f64) {
        self.sensors.shift_gyros(by_rad_per_s);
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
