//! The oscilloscope with current probes on the motors.

use drivers::device::DeviceError;
use drivers::scope::{Capture, Scope, ScopeSettings};
use procedures::device::{DeviceRole, Task};
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::on_line::{ANSWER_TIMEOUT_S, LineDriver, OnLine};
use crate::model::device::DeviceEntry;
use crate::rig::device::Group;
use crate::rig::driver::{Driver, Made, Misfit, PortField, not_above_zero};

/// Driver of oscilloscopes.
pub(super) const DRIVER: Driver = Driver {
    name: "infiniivision",
    doc: "Oscilloscope with current probes on the motors (Keysight InfiniiVision command set).",
    role: Some(DeviceRole::Oscilloscope),
    certified_as: Some("scope"),
    rate_range_rad_per_s: None,
    ports: &[PortField::line("SCPI line.")],
    has_profile: false,
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
            "Range of the motor currents on the screen, plus and minus.",
        ),
    ],
    check,
    make: |entry, _| Made::Instrument(Box::new(OnLine::<Scope>::closed(entry, settings(entry)))),
};

/// Keys of the channels: currents of both motors, synchronisation.
const CHANNELS: [&str; 3] = ["azimuth-channel", "elevation-channel", "sync-channel"];

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let channels = CHANNELS.map(|key| entry.integer(key));
    let [az, el, sync] = channels;
    let mut all = not_above_zero(entry, &["current-range"]);
    if channels.iter().any(|channel| !(1..=4).contains(channel)) || az == el || az == sync || el == sync {
        let message = format!("expected three different channels from 1 to 4, found {az}, {el} and {sync}");
        let help = Some("correct `azimuth-channel`, `elevation-channel` or `sync-channel`".to_owned());
        all.push(Misfit { key: CHANNELS[2], message, help });
    }
    all
}

fn settings(entry: &DeviceEntry) -> ScopeSettings {
    let channel = |key: &str| u8::try_from(entry.integer(key)).expect("checked: channels 1 to 4");
    ScopeSettings {
        name: entry.name.clone(),
        current_channels: [channel(CHANNELS[0]), channel(CHANNELS[1])],
        sync_channel: channel(CHANNELS[2]),
        current_range_a: entry.number("current-range"),
        reply_timeout_s: ANSWER_TIMEOUT_S,
    }
}

impl LineDriver for Scope {
    type Settings = ScopeSettings;

    const GROUP: Group = Group { topic: "scope", message: "Record", channels: Self::CHANNELS };

    fn with(settings: ScopeSettings) -> Result<Self, DeviceError> {
        Self::new(settings)
    }

    fn prepare_for(&mut self, task: &Task, axis: usize) -> Result<bool, DeviceError> {
        let Task::Capture { sample_rate_hz, duration_s, .. } = task else { return Ok(false) };
        let capture = Capture { axis, sample_rate_hz: *sample_rate_hz, duration_s: *duration_s };
        self.prepare(&capture).map(|()| true)
    }

    fn awaits_edge(&self) -> bool {
        self.is_armed()
    }

    fn rows_count(&self) -> usize {
        self.samples_count()
    }

    fn row_to(&self, row: usize, each: &mut dyn FnMut(&[f64])) {
        self.row(row).iter().for_each(|values| each(values));
    }

    fn when_late(&self) -> &'static str {
        if self.is_armed() {
            "no trigger (the excitation did not change, or the cable is missing)"
        } else {
            "the record is not done"
        }
    }
}
