//! The impedance analyser at the terminals of the mirror.

use drivers::analyser::{Analyser, AnalyserSettings, Sweep};
use drivers::device::DeviceError;
use procedures::device::{DeviceRole, Task};
use procedures::table::{Field, Shape};

use super::on_line::{ANSWER_TIMEOUT_S, LineDriver, OnLine};
use crate::model::device::DeviceEntry;
use crate::rig::device::Group;
use crate::rig::driver::{Driver, Made, Misfit, PortField};

/// Driver of impedance analysers.
pub(super) const DRIVER: Driver = Driver {
    name: "e4990a",
    doc: "Impedance analyser at the terminals of the mirror (Keysight E4990A command set).",
    role: Some(DeviceRole::ImpedanceAnalyser),
    certified_as: Some("analyser"),
    rate_range_rad_per_s: None,
    ports: &[PortField::line("SCPI line.")],
    has_profile: false,
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
    make: |entry, _| Made::Instrument(Box::new(OnLine::<Analyser>::closed(entry, settings(entry)))),
};

const RELAYS: [&str; 2] = ["azimuth-relay", "elevation-relay"];

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let out = |key: &&'static str| u8::try_from(entry.integer(key)).is_err();
    let misfit = |key: &'static str| {
        let message = format!("`{key}` must be from 0 to 255, found {}", entry.integer(key));
        Misfit { key, message, help: Some("handler port A of the analyser has eight bits".to_owned()) }
    };
    RELAYS.into_iter().filter(out).map(misfit).collect()
}

fn settings(entry: &DeviceEntry) -> AnalyserSettings {
    let relay = RELAYS.map(|key| u8::try_from(entry.integer(key)).expect("checked: eight bits"));
    AnalyserSettings { name: entry.name.clone(), relay, reply_timeout_s: ANSWER_TIMEOUT_S }
}

impl LineDriver for Analyser {
    type Settings = AnalyserSettings;

    const GROUP: Group = Group { topic: "analyser", message: "Impedance", channels: Self::CHANNELS };

    fn with(settings: AnalyserSettings) -> Result<Self, DeviceError> {
        Self::new(settings)
    }

    fn prepare_for(&mut self, task: &Task, axis: usize) -> Result<bool, DeviceError> {
        let Task::Impedance { level_v_ptp, from_hz, to_hz, points, .. } = task else { return Ok(false) };
        let points = usize::try_from(*points).unwrap_or(usize::MAX);
        let sweep = Sweep { axis, level_v_ptp: *level_v_ptp, from_hz: *from_hz, to_hz: *to_hz, points };
        self.prepare(&sweep).map(|()| true)
    }

    fn rows_count(&self) -> usize {
        self.points().len()
    }

    fn row_to(&self, row: usize, each: &mut dyn FnMut(&[f64])) {
        self.row(row).iter().for_each(|values| each(values));
    }

    fn when_late(&self) -> &'static str {
        "the sweep is not done"
    }
}
