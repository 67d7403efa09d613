//! The impedance analyser at the terminals of the mirror.

use std::time::Duration;

use drivers::analyser::{Analyser, AnalyserSettings, Sweep};
use drivers::device::DeviceError;
use procedures::device::{DeviceRole, Task};
use procedures::table::{Field, Shape};

use crate::model::device::DeviceEntry;
use crate::rig::device::Group;
use crate::rig::driver::{Driver, Made, Misfit, PortField};
use crate::rig::instruments::{Instrument, Measuring};
use crate::rig::wires::Ports;

/// Time allowed for an answer of an instrument on the network.
const ANSWER_TIMEOUT_S: f64 = 2.0;

/// Driver of impedance analysers.
pub(super) const DRIVER: Driver = Driver {
    name: "e4990a",
    doc: "Impedance analyser at the terminals of the mirror (Keysight E4990A command set).",
    role: Some(DeviceRole::ImpedanceAnalyser),
    certified_as: Some("analyser"),
    ports: &[PortField::line("SCPI line.")],
    fields: &[
        Field::default(
            "azimuth-relay",
            Shape::Integer,
            "1",
            "Value of handler port A that connects the azimuth axis of the mirror and disconnects its amplifier.",
        ),
        Field::default(
            "elevation-relay",
            Shape::Integer,
            "2",
            "Value of handler port A that connects the elevation axis; 0 connects none.",
        ),
    ],
    check,
    make: |entry, _| Made::Instrument(Box::new(OnLine::closed(entry))),
};

const RELAYS: [&str; 2] = ["azimuth-relay", "elevation-relay"];

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let out = |key: &&'static str| u8::try_from(entry.integer(key)).is_err();
    let misfit = |key: &'static str| {
        let help = Some("values 0 to 255".to_owned());
        Misfit { key, message: "handler port A has eight bits".to_owned(), help }
    };
    RELAYS.into_iter().filter(out).map(misfit).collect()
}

/// The analyser on its line.
#[derive(Clone)]
struct OnLine {
    settings: AnalyserSettings,
    port: String,
    line: usize,
    driver: Option<Analyser>,
}

impl OnLine {
    fn closed(entry: &DeviceEntry) -> Self {
        let relay = RELAYS.map(|key| u8::try_from(entry.integer(key)).expect("checked: eight bits"));
        let settings =
            AnalyserSettings { name: entry.name.clone(), relay, reply_timeout_s: ANSWER_TIMEOUT_S };
        Self { settings, port: entry.port("line").to_owned(), line: 0, driver: None }
    }

    fn driver(&mut self) -> Result<&mut Analyser, DeviceError> {
        if self.driver.is_none() {
            self.driver = Some(Analyser::new(self.settings.clone())?);
        }
        Ok(self.driver.as_mut().expect("made just now"))
    }
}

impl Instrument for OnLine {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn group(&self) -> Group {
        Group { topic: "analyser", message: "Impedance", channels: Analyser::CHANNELS }
    }

    fn identify(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<String>, DeviceError> {
        self.line = ports.find_line(&self.settings.name, &self.port)?;
        let line = self.line;
        let identity = self.driver()?.identify(ports.line(line), now)?;
        Ok(identity.map(|identity| identity.to_string()))
    }

    fn ready(&self, task: &Task, axis: usize) -> Result<Option<Box<dyn Measuring + Send>>, DeviceError> {
        let Task::Impedance { level_v_ptp, from_hz, to_hz, points, .. } = task else { return Ok(None) };
        let mut own = self.clone();
        let points = usize::try_from(*points).unwrap_or(usize::MAX);
        let sweep = Sweep { axis, level_v_ptp: *level_v_ptp, from_hz: *from_hz, to_hz: *to_hz, points };
        own.driver()?.prepare(&sweep)?;
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

    fn rows_count(&self) -> usize {
        self.driver.as_ref().map_or(0, |driver| driver.points().len())
    }

    fn row(&self, row: usize, each: &mut dyn FnMut(&[f64])) {
        if let Some(values) = self.driver.as_ref().and_then(|driver| driver.row(row)) {
            each(&values);
        }
    }

    fn when_late(&self) -> &'static str {
        "the sweep is not done"
    }
}
