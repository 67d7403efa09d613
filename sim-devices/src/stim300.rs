//! The STIM300 inertial measurement unit at the far end of its line (datasheet TS1524 rev. 31).
//!
//! At power-up it sends part number, serial number and configuration, then measurements, which it calls not valid for 0.5 s.
//! It counts 2000 samples a second on its own clock; a pulse of the bench (the external trigger, if that is configured) makes the
//! measurement that is due, so pulses must not be rarer than measurements. Rates are means since the measurement before for
//! every output unit: the low-pass filters are not simulated.

mod console;
mod datagram;
mod sensors;
mod setup;
#[cfg(test)]
mod tests;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::stim300::{ForceUnit, GyroUnit, SpecialKind};
use drivers::wire::ByteLine;

use self::console::{Console, Order};
use self::datagram::{Body, Cluster, Datagram};
pub(crate) use self::sensors::of_type;
pub use self::setup::Stim300Setup;
pub use crate::inertial_unit::MessageFault;
use crate::inertial_unit::{InertialSensors, Readings};
use crate::motion::Motion;
use crate::physics::noise::SeedAddress;
use crate::transmitter::{Transmitter, nanoseconds, whole_nanoseconds};
use crate::unit::ImuSettings;

/// The g of the datasheet's conversions, m/s².
const STANDARD_GRAVITY_M_PER_S2: f64 = 9.806_65;
/// Internal samples per second.
pub(crate) const INTERNAL_RATE_HZ: f64 = 2000.0;
/// Time from power-up and from a reset to the first datagram (TS1524, table 5-2).
const POWER_UP_S: f64 = 0.3;
const RESET_S: f64 = 0.2;
/// Time for which measurements are called not valid behind Init mode; TS1524 gives 0.7 s from power-up to valid data.
const SETTLING_S: f64 = 0.5;
/// Shortest time from the sampling to the first bit, and how much it varies with the work of the processor, µs. TS1524 allows
/// 1000 µs.
const LATENCY_US: u16 = 100;
const LATENCY_VARIATION_US: u64 = 61;
/// Ranges of gyros (°/s) and inclinometers (g).
const GYRO_RANGE_DEG_PER_S: f64 = 400.0;
const INCLINOMETER_RANGE_G: f64 = 1.7;
/// Bits of the status byte.
const STARTING: u8 = 0x40;
const OVERLOAD: u8 = 0x10;
const CHANNEL_ERROR: u8 = 0x08;
/// Errors of the extended error information: data of gyro X missing, UART too slow, first axes of the overloads.
const GYRO_X_MISSING: u32 = 65;
const UART_TOO_SLOW: u32 = 68;
const GYRO_OVERLOAD: u32 = 101;
const ACCELEROMETER_OVERLOAD: u32 = 104;
const INCLINOMETER_OVERLOAD: u32 = 107;

/// Operating mode (TS1524, figure 7-8).
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    /// Until this time it is silent, then it says who it is.
    Init {
        until_s: f64,
    },
    Normal,
    Service,
}

/// The unit.
#[derive(Clone, Debug)]
pub struct Stim300 {
    sensors: InertialSensors,
    pulse_s: f64,
    setup: Stim300Setup,
    console: Console,
    transmitter: Transmitter,
    mode: Mode,
    /// Time until which measurements are called not valid.
    settled_s: f64,
    /// Tick and motion of the last measurement that was due.
    before: Option<(u64, Motion)>,
    /// Measurements that were due by the unit's clock.
    due_count: u64,
    integrated_deg: [f64; 3],
    requested: VecDeque<SpecialKind>,
    errors: u128,
    silent: bool,
}

impl Stim300 {
    /// A unit that has been running for long when the point begins. Measurements are called not valid for the start-up time of
    /// `imu`; its bit and data rate are those of `setup`.
    pub fn new(imu: &ImuSettings, setup: Stim300Setup, address: &SeedAddress, pulse_rate_hz: f64) -> Self {
        let pulse_s = 1.0 / pulse_rate_hz;
        Self {
            sensors: InertialSensors::new(imu, address, pulse_s),
            pulse_s,
            setup,
            console: Console::new(setup),
            transmitter: Transmitter::new(f64::from(setup.bit_rate)),
            mode: Mode::Normal,
            settled_s: imu.startup_s,
            before: None,
            due_count: 0,
            integrated_deg: [0.0; 3],
            requested: VecDeque::new(),
            errors: 0,
            silent: false,
        }
    }

    /// The unit as it is when it is switched on at time 0.
    #[must_use]
    pub fn powered_up(mut self) -> Self {
        self.mode = Mode::Init { until_s: POWER_UP_S };
        self
    }

    /// The unit at a point that begins so long after the beginning of the campaign, by the plan.
    #[must_use]
    pub fn after(mut self, planned_s: f64) -> Self {
        self.sensors.begin_after(planned_s);
        self
    }

    /// The pulse number `tick`; pulses may be missing.
    pub fn pulse(&mut self, tick: u64, motion: &Motion) {
        let now_s = tick as f64 * self.pulse_s;
        if let Mode::Init { until_s } = self.mode
            && now_s >= until_s
        {
            self.finish_init(now_s);
        }
        // The guard keeps a sample that coincides with a pulse from waiting for the next one.
        let counter = (now_s * INTERNAL_RATE_HZ + 1e-6) as u64;
        if !self.is_due(counter) {
            return;
        }
        let before = self.before.replace((tick, *motion));
        let Some((earlier, before)) = before.filter(|(earlier, _)| *earlier < tick) else { return };
        let averaging_s = (tick - earlier) as f64 * self.pulse_s;
        let mean = motion.mean_since(&before, averaging_s);
        if self.mode == Mode::Normal {
            let measured = self.sensors.measure(tick, now_s, averaging_s, &mean);
            self.send_measurement(now_s, counter, averaging_s, measured);
        }
    }

    /// Whether this pulse makes a measurement.
    fn is_due(&mut self, counter: u64) -> bool {
        let Some(samples) = self.setup.samples_per_measurement() else { return true };
        let count = counter / u64::from(samples) + 1;
        let due = count != self.due_count;
        self.due_count = count;
        due
    }

    /// The end of Init mode: the special datagrams, then Normal mode.
    fn finish_init(&mut self, now_s: f64) {
        self.mode = Mode::Normal;
        self.settled_s = now_s + SETTLING_S;
        self.send_special(now_s, SpecialKind::PartNumber);
        self.send_special(now_s, SpecialKind::SerialNumber);
        self.send_special(now_s, SpecialKind::Configuration);
        if self.setup.sends_bias_trim {
            self.send_special(now_s, SpecialKind::BiasTrim);
        }
    }

    fn send_special(&mut self, now_s: f64, kind: SpecialKind) {
        if self.silent {
            return;
        }
        let payload = match kind {
            SpecialKind::PartNumber => datagram::part_number().to_vec(),
            SpecialKind::SerialNumber => datagram::serial_number().to_vec(),
            SpecialKind::Configuration => self.setup.payload().to_vec(),
            // No trim, 10000 saves left.
            SpecialKind::BiasTrim => [&[0; 31][..], &10_000_u16.to_be_bytes(), &[0; 2]].concat(),
            SpecialKind::ExtendedError => std::mem::take(&mut self.errors).to_be_bytes().to_vec(),
        };
        let datagram = Datagram::special(kind, &payload, self.setup.line_end);
        self.transmitter.append(nanoseconds(now_s), datagram.bytes());
    }

    /// Sends a measurement, or what was asked for instead. What is due while the line is busy is lost.
    fn send_measurement(&mut self, now_s: f64, counter: u64, averaging_s: f64, measured: Readings) {
        let reported = self.sensors.report(measured);
        let fault = self.sensors.take_fault();
        let latency_us = LATENCY_US + (37 * counter % LATENCY_VARIATION_US) as u16;
        let mut body = Body {
            counter: counter as u8,
            latency_us,
            input: (now_s.fract() * 1e6) as i32,
            temperature: (256.0 * self.sensors.temperature_degc(now_s)).round() as i16,
            ..self.body(&reported, averaging_s)
        };
        if now_s < self.settled_s {
            body.unit_status = STARTING;
        }
        for cluster in [&mut body.gyros, &mut body.accelerometers, &mut body.inclinometers] {
            cluster.status |= body.unit_status;
        }
        if fault == Some(MessageFault::InvalidStatus) {
            body.gyros.status |= CHANNEL_ERROR | 1;
            self.errors |= 1 << GYRO_X_MISSING;
        }
        let start_ns = nanoseconds(now_s + 1e-6 * f64::from(latency_us));
        if self.silent || fault == Some(MessageFault::Dropped) {
            return;
        }
        if !self.transmitter.is_free(start_ns) {
            self.errors |= 1 << UART_TOO_SLOW;
            return;
        }
        if let Some(kind) = self.requested.pop_front() {
            self.send_special(now_s, kind);
            return;
        }
        let mut datagram = Datagram::measurement(self.setup.content, &body, self.setup.line_end);
        if fault == Some(MessageFault::Checksum) {
            datagram.spoil_checksum(self.setup.line_end);
        }
        self.transmitter.append(start_ns, datagram.bytes());
    }

    /// The readings in counts, limited to the ranges.
    fn body(&mut self, reported: &Readings, interval_s: f64) -> Body {
        let rates_deg_per_s = reported.rate_rad_per_s.map(f64::to_degrees);
        let forces_g = reported.force_m_per_s2.map(|force| force / STANDARD_GRAVITY_M_PER_S2);
        let per_g = datagram::counts_per_g(self.setup.accelerometer_range);
        let range_g = datagram::range_g(self.setup.accelerometer_range);
        let rates = self.limited(rates_deg_per_s, GYRO_RANGE_DEG_PER_S, GYRO_OVERLOAD);
        let forces = self.limited(forces_g, range_g, ACCELEROMETER_OVERLOAD);
        let tilts = self.limited(forces_g, INCLINOMETER_RANGE_G, INCLINOMETER_OVERLOAD);
        for (angle, rate) in self.integrated_deg.iter_mut().zip(rates.values) {
            *angle += rate * interval_s;
        }
        let gyros = match self.setup.gyro_unit {
            GyroUnit::Rate | GyroUnit::AverageRate => rates.values.map(|rate| counts(rate, power(14))),
            GyroUnit::IncrementalAngle => rates.values.map(|rate| counts(rate * interval_s, power(21))),
            GyroUnit::IntegratedAngle => self.integrated_deg.map(|angle| counts(angle, power(21))),
        };
        let accelerometers = match self.setup.accelerometer_unit {
            ForceUnit::IncrementalVelocity => {
                forces.values.map(|g| counts(g * STANDARD_GRAVITY_M_PER_S2 * interval_s, 8.0 * per_g))
            }
            _ => forces.values.map(|g| counts(g, per_g)),
        };
        let inclinometers = tilts.values.map(|g| counts(g, power(22)));
        Body {
            gyros: Cluster { counts: gyros, status: rates.status },
            accelerometers: Cluster { counts: accelerometers, status: forces.status },
            inclinometers: Cluster { counts: inclinometers, status: tilts.status },
            ..Body::default()
        }
    }

    /// Values within a range; the status byte and the error information tell which were beyond it.
    fn limited(&mut self, values: [f64; 3], range: f64, first_error: u32) -> Limited {
        let mut status = 0;
        for (axis, value) in (0..3_u32).zip(values) {
            if value.abs() > range {
                status |= OVERLOAD | 1 << axis;
                self.errors |= 1 << (first_error + axis);
            }
        }
        Limited { values: values.map(|value| value.clamp(-range, range)), status }
    }

    /// Spoils the next `count` measurements.
    pub fn inject(&mut self, fault: MessageFault, count: u32) {
        self.sensors.inject(fault, count);
    }

    /// The unit sends nothing any more.
    pub fn fall_silent(&mut self) {
        self.silent = true;
    }

    /// The unit goes on with the rates and accelerations of its last measurement, numbered and summed as they should be.
    pub fn freeze(&mut self) {
        self.sensors.freeze();
    }

    /// The gyros read this much more from now on, rad/s.
    pub fn shift_gyros(&mut self, by_rad_per_s: f64) {
        self.sensors.shift_gyros(by_rad_per_s);
    }

    /// Bytes that have arrived at the host by `now`.
    pub fn read(&mut self, now: Duration, into: &mut [u8]) -> usize {
        self.transmitter.take(whole_nanoseconds(now), into)
    }

    /// Bytes from the host; what they ask for is done from `now` on.
    pub fn write(&mut self, now: Duration, bytes: &[u8]) {
        for &byte in bytes {
            let order = match self.mode {
                Mode::Init { .. } => None,
                Mode::Normal => self.console.normal_mode(byte),
                Mode::Service => {
                    let (reply, order) = self.console.service_mode(byte, &mut self.setup);
                    self.transmitter.append(whole_nanoseconds(now), &reply);
                    order
                }
            };
            if let Some(order) = order {
                self.carry_out(order, now);
            }
        }
    }

    fn carry_out(&mut self, order: Order, now: Duration) {
        match order {
            Order::Send(kind) => self.requested.push_back(kind),
            Order::Reset => self.begin_anew(now),
            Order::Leave { to_init: true } => self.begin_anew(now),
            Order::Leave { to_init: false } => self.mode = Mode::Normal,
            Order::EnterService => {
                self.mode = Mode::Service;
                self.requested.clear();
                let banner = Console::banner(&self.setup);
                self.transmitter.append(whole_nanoseconds(now), banner.as_bytes());
            }
        }
    }

    /// Init mode, with what is stored.
    fn begin_anew(&mut self, now: Duration) {
        self.setup = self.console.flash();
        self.integrated_deg = [0.0; 3];
        self.requested.clear();
        self.mode = Mode::Init { until_s: now.as_secs_f64() + RESET_S };
    }
}

/// Values within a range, and the status byte that tells which were not.
struct Limited {
    values: [f64; 3],
    status: u8,
}

/// A value in counts; wraps at 24 bits as an integrated angle does.
fn counts(value: f64, per_unit: f64) -> i32 {
    ((value * per_unit).round() as i64 as i32) << 8 >> 8
}

fn power(exponent: u32) -> f64 {
    f64::from(1_u32 << exponent)
}

/// The host's end of the line to a unit that others hold too.
#[derive(Clone, Debug)]
pub struct Stim300Line(pub Rc<RefCell<Stim300>>);

impl ByteLine for Stim300Line {
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
