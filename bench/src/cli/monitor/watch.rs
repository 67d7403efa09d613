//! The device that is looked at, and what was seen of it.

use std::rc::Rc;
use std::time::Duration;

use controllers::DirectorGains;
use drivers::device::{Channel, DeviceError};

use crate::clock::Clock;
use crate::cycle::recorder::MAX_CHANNELS;
use crate::model::rig::Rig;
use crate::rig::ArmedRig;
use crate::rig::device::Device;
use crate::rig::devices::{Devices, closed};
use crate::rig::wires::{Ports, Traffic};
use crate::site::{Purpose, Site};

/// A device that was opened, on ports of its own or on the bus of the drives.
pub(super) struct Watched {
    on: On,
    clock: Clock,
    period: Duration,
    due: Duration,
    traffic: Rc<Traffic>,
}

/// A device on ports of its own.
struct OnPorts {
    devices: Devices,
    ports: Ports,
}

enum On {
    Ports(Box<OnPorts>),
    Bus(Box<ArmedRig>),
}

impl Watched {
    /// Opens the device of a rig that has no other one, on its own lines.
    pub(super) fn lines(site: &dyn Site, rig: &Rig) -> Result<Self, DeviceError> {
        let opened = site.open_ports(rig, &purpose())?;
        let clock = opened.clock;
        let (mut ports, traffic) = opened.ports.counted();
        let begins = clock.now();
        let (mut devices, now) = Devices::open(closed(rig).devices, &mut ports, &clock, begins)?;
        devices.start_of_ticks(now);
        Ok(Self::at(now, rig, clock, On::Ports(Box::new(OnPorts { devices, ports })), traffic))
    }

    /// Opens the rig up to SAFE-OP, in which inputs are valid and outputs are ignored.
    pub(super) fn bus(site: &dyn Site, rig: &Rig, gains: &DirectorGains) -> Result<Self, DeviceError> {
        let mut opened = site.open(rig, gains, &purpose())?;
        let clock = opened.clock;
        let traffic = opened.rig.count_traffic();
        let armed = opened.rig.arm(&clock)?;
        Ok(Self::at(armed.ready(), rig, clock, On::Bus(Box::new(armed)), traffic))
    }

    fn at(due: Duration, rig: &Rig, clock: Clock, on: On, traffic: Rc<Traffic>) -> Self {
        Self { on, clock, period: Duration::from_secs_f64(1.0 / rig.loop_rate_hz), due, traffic }
    }

    /// Time of the next tick.
    pub(super) fn now(&self) -> Duration {
        self.due
    }

    /// Waits for the next tick and polls the device; the time of the tick.
    ///
    /// # Errors
    /// When its port is gone, or it does not answer any more.
    pub(super) fn tick(&mut self) -> Result<Duration, DeviceError> {
        let now = self.clock.wait_until(self.due);
        self.due = self.due.max(now) + self.period;
        match &mut self.on {
            On::Ports(own) => own.devices.poll(&mut own.ports, now),
            On::Bus(armed) => armed.exchange(now),
        }
        match self.devices().failure() {
            Some(error) => Err(error.clone()),
            None => Ok(now),
        }
    }

    fn devices(&mut self) -> &mut Devices {
        match &mut self.on {
            On::Ports(own) => &mut own.devices,
            On::Bus(armed) => armed.devices_mut(),
        }
    }

    /// The device of this name.
    pub(super) fn device(&mut self, name: &str) -> Option<&mut Box<dyn Device>> {
        self.devices().named(name)
    }
}

fn purpose() -> Purpose<'static> {
    Purpose { procedure: "monitor", ..Purpose::default() }
}

/// What was seen of a device since it is looked at.
pub(super) struct Seen {
    start: Duration,
    ticks_count: u64,
    samples_count: u64,
    sampled_at: Option<Duration>,
    /// At the last report: time, samples.
    before: (Duration, u64),
}

/// What is shown of a device.
pub(super) struct Report {
    /// Since the beginning, s.
    pub(super) time_s: f64,
    /// Samples per second since the last report.
    pub(super) rate_hz: f64,
    /// Time since the newest sample, s; `None` before the first.
    pub(super) age_s: Option<f64>,
    /// Channels and their values.
    pub(super) values: Vec<(Channel, f64)>,
    /// What was counted on its line.
    pub(super) counts: Vec<(&'static str, u64)>,
}

impl Seen {
    /// Nothing yet of the device of this name; what was counted while it was opened does not belong to its rate.
    pub(super) fn begin(watched: &mut Watched, name: &str) -> Self {
        let start = watched.now();
        let counts = watched.device(name).map(|device| device.counts()).unwrap_or_default();
        let samples_count = counts.first().map_or(0, |(_, count)| *count);
        Self { start, ticks_count: 0, samples_count, sampled_at: None, before: (start, samples_count) }
    }

    /// Looks for new samples after a tick. What counts nothing is read in every tick.
    pub(super) fn look(&mut self, watched: &mut Watched, name: &str, now: Duration) {
        self.ticks_count += 1;
        let counts = watched.device(name).map(|device| device.counts()).unwrap_or_default();
        let samples_count = counts.first().map_or(self.ticks_count, |(_, count)| *count);
        if samples_count != self.samples_count {
            (self.samples_count, self.sampled_at) = (samples_count, Some(now));
        }
    }

    /// Sums up since the last report.
    pub(super) fn report(&mut self, watched: &mut Watched, name: &str, now: Duration) -> Report {
        let (before, samples_before) = std::mem::replace(&mut self.before, (now, self.samples_count));
        let passed_s = now.saturating_sub(before).as_secs_f64();
        let new_count = self.samples_count.saturating_sub(samples_before);
        let mut counts = Vec::new();
        let mut values = Vec::new();
        if let Some(device) = watched.device(name) {
            let mut row = [0.0; MAX_CHANNELS];
            device.row(&mut row);
            values.extend(device.group().channels.iter().copied().zip(row));
            counts = device.counts();
        }
        let [received, sent] = watched.traffic.bytes();
        if received + sent > 0 {
            counts.extend([("received_bytes", received), ("sent_bytes", sent)]);
        }
        Report {
            time_s: now.saturating_sub(self.start).as_secs_f64(),
            rate_hz: if passed_s > 0.0 { new_count as f64 / passed_s } else { 0.0 },
            age_s: self.sampled_at.map(|at| now.saturating_sub(at).as_secs_f64()),
            values,
            counts,
        }
    }
}
