//! The oscilloscope with current probes on the motors.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::scope::{Capture, Scope, ScopeSettings};
use procedures::device::{DeviceRole, Task};
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use crate::model::device::DeviceEntry;
use crate::rig::device::Group;
use crate::rig::driver::{Driver, Made, Misfit, PortField, not_above_zero};
use crate::rig::instruments::{Instrument, Measuring};
use crate::rig::wires::Ports;

/// Time allowed for an answer of an instrument on the network.
const ANSWER_TIMEOUT_S: f64 = 2.0;

/// Driver of oscilloscopes.
pub(super) const DRIVER: Driver = Driver {
    name: "infiniivision",
    doc: "Oscilloscope with current probes on the motors (Keysight InfiniiVision command set).",
    role: Some(DeviceRole::Oscilloscope),
    certified_as: Some("scope"),
    ports: &[PortField::line("SCPI line.")],
    fields: &[
        Field::default(
            CHANNELS[0],
            Shape::Integer,
            "1",
            "Channel of the current probe on the azimuth motor.",
        ),
        Field::default(
            CHANNELS[1],
            Shape::Integer,
            "3",
            "Channel of the current probe on the elevation motor.",
        ),
        Field::default(
            CHANNELS[2],
            Shape::Integer,
            "2",
            "Channel of the synchronisation signal, an analog output of the mirror's card.",
        ),
        Field::default(
            "current-range",
            Shape::Quantity(K::Current),
            "50 A",
            "Motor currents up to plus and minus this are on the screen.",
        ),
    ],
    check,
    make: |entry, _| Made::Instrument(Box::new(OnLine::closed(entry))),
};

/// Keys of the channels: currents of both motors, synchronisation.
const CHANNELS: [&str; 3] = ["azimuth-channel", "elevation-channel", "sync-channel"];

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let channels = CHANNELS.map(|key| entry.integer(key));
    let [az, el, sync] = channels;
    let mut all = not_above_zero(entry, &["current-range"]);
    if channels.iter().any(|channel| !(1..=4).contains(channel)) || az == el || az == sync || el == sync {
        let help = Some("channels are 1 to 4, one for each signal".to_owned());
        let message = "the signals do not have a channel each".to_owned();
        all.push(Misfit { key: CHANNELS[2], message, help });
    }
    all
}

/// The oscilloscope on its line.
#[derive(Clone)]
struct OnLine {
    settings: ScopeSettings,
    port: String,
    line: usize,
    driver: Option<Scope>,
}

impl OnLine {
    fn closed(entry: &DeviceEntry) -> Self {
        let channel = |key: &str| u8::try_from(entry.integer(key)).expect("checked: channels 1 to 4");
        let settings = ScopeSettings {
            name: entry.name.clone(),
            current_channels: [channel(CHANNELS[0]), channel(CHANNELS[1])],
            sync_channel: channel(CHANNELS[2]),
            current_range_a: entry.number("current-range"),
            reply_timeout_s: ANSWER_TIMEOUT_S,
        };
        Self { settings, port: entry.port("line").to_owned(), line: 0, driver: None }
    }

    fn driver(&mut self) -> Result<&mut Scope, DeviceError> {
        if self.driver.is_none() {
            self.driver = Some(Scope::new(self.settings.clone())?);
        }
        Ok(self.driver.as_mut().expect("made just now"))
    }
}

impl Instrument for OnLine {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn group(&self) -> Group {
        Group { topic: "scope", message: "Record", channels: Scope::CHANNELS }
    }

    fn identify(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<String>, DeviceError> {
        self.line = ports.find_line(&self.settings.name, &self.port)?;
        let line = self.line;
        let identity = self.driver()?.identify(ports.line(line), now)?;
        Ok(identity.map(|identity| identity.to_string()))
    }

    fn ready(&self, task: &Task, axis: usize) -> Result<Option<Box<dyn Measuring + Send>>, DeviceError> {
        let Task::Capture { sample_rate_hz, duration_s, .. } = task else { return Ok(None) };
        let mut own = self.clone();
        let capture = Capture { axis, sample_rate_hz: *sample_rate_hz, duration_s: *duration_s };
        own.driver()?.prepare(&capture)?;
        Ok(Some(Box::new(own)))
    }

    fn copy(&self) -> Box<dyn Instrument + Send> {
        Box::new(self.clone())
    }
}

impl Measuring for OnLine {
    fn start(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let line = self.line;
        self.driver()?.start(ports.line(line), now)
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<bool, DeviceError> {
        let line = self.line;
        self.driver()?.poll(ports.line(line), now)
    }

    fn abort(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let line = self.line;
        self.driver()?.abort(ports.line(line), now)
    }

    fn awaits_edge(&self) -> bool {
        self.driver.as_ref().is_some_and(|driver| driver.is_running() && driver.is_armed())
    }

    fn rows_count(&self) -> usize {
        self.driver.as_ref().map_or(0, Scope::samples_count)
    }

    fn row(&self, row: usize, each: &mut dyn FnMut(&[f64])) {
        if let Some(values) = self.driver.as_ref().and_then(|driver| driver.row(row)) {
            each(&values);
        }
    }

    fn when_late(&self) -> &'static str {
        if self.driver.as_ref().is_some_and(Scope::is_armed) {
            "no trigger: the excitation did not change, or the cable is missing;"
        } else {
            "the record is not done"
        }
    }
}
