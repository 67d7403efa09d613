//! The fast steering mirror behind a controller that speaks PI's GCS 2.0.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::gcs::{GcsMirror, GcsMirrorSettings};
use drivers::mirror::{Actuals, Path};
use drivers::wire::{AnalogPort, ByteLine};
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::mirror::{
    self, CARD, COMMAND_PATH, FIELDS, Mirror, Servo, command_outputs, feedback_inputs, path,
};
use crate::model::device::DeviceEntry;
use crate::rig::driver::{Driver, Made, Misfit, PortField, no_channels, not_above_zero};

/// Name of the driver in rig files.
pub(crate) const NAME: &str = "gcs";

/// Time without a byte after which a reply is given up.
const ANSWER_TIMEOUT_S: f64 = 0.2;
/// Key of the way of the feedback.
const FEEDBACK_PATH: &str = "feedback";
const AXES: [&str; 2] = ["azimuth-axis", "elevation-axis"];
const TARGETS: [&str; 2] = ["azimuth-target", "elevation-target"];

/// Settings of this controller beside those of any mirror.
const OWN: [Field; 6] = [
    Field::default(
        FEEDBACK_PATH,
        Shape::Choice(&["analog", "serial"]),
        "analog",
        "Channel of the feedback: position monitors on the analog card, or `POS?` on the line.",
    ),
    Field::default(
        "position-unit",
        Shape::Quantity(K::Angle),
        "1 urad",
        "Mirror angle of one unit of position, as `MOV` and `POS?` have it.",
    ),
    Field::default(AXES[0], Shape::Text, "1", "Identifier of the azimuth axis, as `SAI?` lists it."),
    Field::default(AXES[1], Shape::Text, "2", "Identifier of the elevation axis, as `SAI?` lists it."),
    Field::default(
        TARGETS[0],
        Shape::Integer,
        "5",
        "Input channel of the controller to which the analog azimuth command is wired (parameter 06000500h).",
    ),
    Field::default(
        TARGETS[1],
        Shape::Integer,
        "6",
        "Input channel of the controller to which the analog elevation command is wired.",
    ),
];

const ALL: [Field; 19] = {
    let mut all = [OWN[0]; 19];
    let mut k = 0;
    while k < all.len() {
        all[k] = if k < FIELDS.len() { FIELDS[k] } else { OWN[k - FIELDS.len()] };
        k += 1;
    }
    all
};

/// Driver of the controller.
pub(super) const DRIVER: Driver = Driver {
    name: NAME,
    doc: "Fast steering mirror behind a controller that speaks PI's GCS 2.0 (E-727), and the other signals on its analog card.",
    role: Some(DeviceRole::Mirror),
    certified_as: None,
    rate_range_rad_per_s: None,
    ports: &[PortField::line("Line of the controller: serial, or TCP port 50000."), CARD],
    has_profile: false,
    fields: &ALL,
    check,
    make: |entry, _| Made::InTheTick(Box::new(Mirror::<GcsMirror>::closed(entry, settings(entry)))),
};

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let mut all = mirror::check(entry);
    all.extend(not_above_zero(entry, &["position-unit"]));
    all.extend(no_channels(entry, &TARGETS));
    let zero = TARGETS.into_iter().find(|key| entry.integer(key) == 0);
    if let Some(key) = zero {
        let message = format!("`{key}` must be an input channel from 1: 0 takes the target from commands");
        all.push(Misfit { key, message, help: None });
    }
    if all.is_empty()
        && let Err(error) = GcsMirror::new(settings(entry))
    {
        let key = if matches!(error, DeviceError::Field { .. }) { AXES[0] } else { "stroke" };
        all.push(Misfit { key, message: error.to_string(), help: None });
    }
    all
}

fn settings(entry: &DeviceEntry) -> GcsMirrorSettings {
    GcsMirrorSettings {
        name: entry.name.clone(),
        axes: AXES.map(|key| entry.text(key).to_owned()),
        position_unit_rad: entry.number("position-unit"),
        scale_rad_per_v: [entry.number("scale"); 2],
        stroke_rad: [entry.number("stroke"); 2],
        command: path(entry, COMMAND_PATH),
        feedback: path(entry, FEEDBACK_PATH),
        target_inputs: TARGETS.map(|key| u32::try_from(entry.integer(key)).unwrap_or(0)),
        command_outputs: command_outputs(entry),
        feedback_inputs: feedback_inputs(entry),
        answer_timeout_s: ANSWER_TIMEOUT_S,
    }
}

impl Servo for GcsMirror {
    type Settings = GcsMirrorSettings;

    fn with(settings: GcsMirrorSettings) -> Result<Self, DeviceError> {
        Self::new(settings)
    }

    fn configure(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<String>, DeviceError> {
        GcsMirror::configure(self, line, now)
    }

    fn configuration(settings: &GcsMirrorSettings) -> String {
        let GcsMirrorSettings {
            axes: [az, el],
            command,
            feedback,
            scale_rad_per_v: [scale, _],
            stroke_rad: [stroke, _],
            position_unit_rad,
            ..
        } = settings;
        let [scale, stroke, unit] = [scale * 1e6, stroke * 1e3, position_unit_rad * 1e6];
        format!(
            "axes {az} and {el}, commands {command:?}, readings {feedback:?}, {scale} urad/V, {unit} urad a unit of position, \
             stroke {stroke} mrad"
        )
    }

    fn command_path(&self) -> Path {
        GcsMirror::command_path(self)
    }

    fn change_command_path(&mut self, path: Path) {
        GcsMirror::change_command_path(self, path);
    }

    fn is_changing(&self) -> bool {
        GcsMirror::is_changing(self)
    }

    fn exchange(
        &mut self,
        line: &mut dyn ByteLine,
        card: &mut dyn AnalogPort,
        command_rad: [f64; 2],
        now: Duration,
    ) -> Result<Actuals, DeviceError> {
        GcsMirror::exchange(self, line, card, command_rad, now)
    }
}
