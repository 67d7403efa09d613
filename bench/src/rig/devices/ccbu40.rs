//! The fast steering mirror with its CCBu40 servo.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::mirror::{self, Actuals, MirrorSettings, Path};
use drivers::wire::{AnalogPort, ByteLine};
use procedures::device::DeviceRole;

use super::mirror::{
    CARD, COMMAND_PATH, FIELDS, Mirror, Servo, check, command_outputs, feedback_inputs, path,
};
use crate::model::device::DeviceEntry;
use crate::rig::driver::{Driver, Made, PortField};

/// Time allowed for an answer on the line.
const ANSWER_TIMEOUT_S: f64 = 0.2;

/// Driver of the mirror's servo.
pub(super) const DRIVER: Driver = Driver {
    name: "ccbu40",
    doc: "Fast steering mirror with its CCBu40 servo, and the other signals on its analog card.",
    role: Some(DeviceRole::Mirror),
    certified_as: None,
    rate_range_rad_per_s: None,
    ports: &[PortField::line("Serial line of the servo."), CARD],
    has_profile: false,
    fields: &FIELDS,
    check,
    make: |entry, _| Made::InTheTick(Box::new(Mirror::<mirror::Mirror>::closed(entry, settings(entry)))),
};

fn settings(entry: &DeviceEntry) -> MirrorSettings {
    MirrorSettings {
        name: entry.name.clone(),
        scale_rad_per_v: [entry.number("scale"); 2],
        stroke_rad: [entry.number("stroke"); 2],
        command: path(entry, COMMAND_PATH),
        feedback: Path::Analog,
        command_outputs: command_outputs(entry),
        feedback_inputs: feedback_inputs(entry),
        reply_timeout_s: ANSWER_TIMEOUT_S,
    }
}

impl Servo for mirror::Mirror {
    type Settings = MirrorSettings;

    fn with(settings: MirrorSettings) -> Result<Self, DeviceError> {
        Self::new(settings)
    }

    fn configure(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<String>, DeviceError> {
        let identity = mirror::Mirror::configure(self, line, now)?;
        Ok(identity.map(|_| "CCBu40 servo, analog and serial channel".to_owned()))
    }

    fn configuration(settings: &MirrorSettings) -> String {
        let MirrorSettings {
            command, feedback, scale_rad_per_v: [scale, _], stroke_rad: [stroke, _], ..
        } = settings;
        let [scale, stroke] = [scale * 1e6, stroke * 1e3];
        format!(
            "commands {command:?}, readings {feedback:?}, {scale} urad/V, stroke {stroke} mrad; the servo has no query for \
             its serial number"
        )
    }

    fn command_path(&self) -> Path {
        mirror::Mirror::command_path(self)
    }

    fn change_command_path(&mut self, path: Path) {
        mirror::Mirror::change_command_path(self, path);
    }

    fn is_changing(&self) -> bool {
        mirror::Mirror::is_changing(self)
    }

    fn exchange(
        &mut self,
        line: &mut dyn ByteLine,
        card: &mut dyn AnalogPort,
        command_rad: [f64; 2],
        now: Duration,
    ) -> Result<Actuals, DeviceError> {
        mirror::Mirror::exchange(self, line, card, command_rad, now)
    }
}
