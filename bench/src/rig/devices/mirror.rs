//! The fast steering mirror on its serial line and the analog card, and what else is wired to the card with it.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::mirror::{self, MirrorSettings, Path};
use procedures::case::MirrorChannel;
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::auxiliary::{AuxiliaryChannels, AuxiliarySettings};
use crate::model::device::DeviceEntry;
use crate::rig::PointSettings;
use crate::rig::device::{Device, Group, SteeringMirror};
use crate::rig::driver::{Driver, Made, PortField, no_channels, not_above_zero};
use crate::rig::wires::Ports;

/// Time allowed for an answer on the line.
const ANSWER_TIMEOUT_S: f64 = 0.2;

const fn channel(key: &'static str, default: &'static str, doc: &'static str) -> Field {
    Field::default(key, Shape::Integer, default, doc)
}

/// Driver of the mirror's servo.
pub const DRIVER: Driver = Driver {
    name: "ccbu40",
    doc: "Fast steering mirror with its CCBu40 servo, and the other signals on its analog card.",
    role: Some(DeviceRole::Mirror),
    certified_as: None,
    ports: &[
        PortField::line("Serial line of the servo."),
        PortField::card(
            "Analog card with commands, strain gauges, autocollimator, synchronisation and loop-back.",
        ),
    ],
    has_profile: false,
    fields: &[
        Field::default(
            COMMAND_PATH,
            Shape::Choice(&["analog", "serial"]),
            "analog",
            "Channel of the commands.",
        ),
        Field::default(
            "scale",
            Shape::Quantity(K::AngleScale),
            "500 urad/V",
            "Mirror angle per volt, of commands and of readings.",
        ),
        Field::default(
            "stroke",
            Shape::Quantity(K::Angle),
            "1.05 mrad",
            "Commands stay within plus and minus this angle.",
        ),
        Field::default(
            "reference-scale",
            Shape::Quantity(K::AngleScale),
            "200 urad/V",
            "Mirror tilt per volt of the autocollimator that looks at it.",
        ),
        channel(OUTPUTS[0], "0", "Analog output of the azimuth command."),
        channel(OUTPUTS[1], "1", "Analog output of the elevation command."),
        channel(OUTPUTS[2], "2", "Analog output of the synchronisation signal of the oscilloscope."),
        channel(OUTPUTS[3], "3", "Analog output of the loop-back signal."),
        channel(INPUTS[0], "0", "Analog input of the azimuth strain gauge."),
        channel(INPUTS[1], "1", "Analog input of the elevation strain gauge."),
        channel(INPUTS[2], "2", "Analog input of the autocollimator, azimuth."),
        channel(INPUTS[3], "3", "Analog input of the autocollimator, elevation."),
        channel(INPUTS[4], "4", "Analog input that the loop-back output is wired to."),
    ],
    check: |entry| {
        let scales = not_above_zero(entry, &["scale", "stroke", "reference-scale"]);
        [scales, no_channels(entry, &OUTPUTS), no_channels(entry, &INPUTS)].concat()
    },
    make: |entry, _| Made::InTheTick(Box::new(Mirror::closed(entry))),
};

/// Key of the way of the commands, which a procedure may change for a point.
pub const COMMAND_PATH: &str = "command";
const OUTPUTS: [&str; 4] = ["azimuth-output", "elevation-output", "sync-output", "echo-output"];
const INPUTS: [&str; 5] = [
    "azimuth-input",
    "elevation-input",
    "azimuth-reference-input",
    "elevation-reference-input",
    "echo-input",
];

fn settings(entry: &DeviceEntry) -> MirrorSettings {
    MirrorSettings {
        name: entry.name.clone(),
        scale_rad_per_v: [entry.number("scale"); 2],
        stroke_rad: [entry.number("stroke"); 2],
        command: if entry.text(COMMAND_PATH) == "serial" { Path::Serial } else { Path::Analog },
        feedback: Path::Analog,
        command_outputs: [entry.channel(OUTPUTS[0]), entry.channel(OUTPUTS[1])],
        feedback_inputs: [entry.channel(INPUTS[0]), entry.channel(INPUTS[1])],
        reply_timeout_s: ANSWER_TIMEOUT_S,
    }
}

fn auxiliary_settings(entry: &DeviceEntry) -> AuxiliarySettings {
    AuxiliarySettings {
        reference_scale_rad_per_v: entry.number("reference-scale"),
        reference_inputs: [entry.channel(INPUTS[2]), entry.channel(INPUTS[3])],
        sync_output: entry.channel(OUTPUTS[2]),
        echo_output: entry.channel(OUTPUTS[3]),
        echo_input: entry.channel(INPUTS[4]),
    }
}

/// The mirror, and the last of what it was told and showed.
pub(super) struct Mirror {
    settings: MirrorSettings,
    port: String,
    card_port: String,
    line: usize,
    card: usize,
    driver: Option<mirror::Mirror>,
    auxiliary: AuxiliaryChannels,
    command_rad: [f64; 2],
    actuals: mirror::Actuals,
}

impl Mirror {
    /// On ports that are not open yet.
    fn closed(entry: &DeviceEntry) -> Self {
        Self {
            settings: settings(entry),
            port: entry.port("line").to_owned(),
            card_port: entry.port("card").to_owned(),
            line: 0,
            card: 0,
            driver: None,
            auxiliary: AuxiliaryChannels::new(auxiliary_settings(entry)),
            command_rad: [0.0; 2],
            actuals: mirror::Actuals::default(),
        }
    }
}

impl Device for Mirror {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn open(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<()>, DeviceError> {
        let driver = match &mut self.driver {
            Some(driver) => driver,
            None => {
                self.line = ports.find_line(&self.settings.name, &self.port)?;
                self.card = ports.find_card(&self.settings.name, &self.card_port)?;
                self.driver.insert(mirror::Mirror::new(self.settings.clone())?)
            }
        };
        Ok(driver.configure(ports.line(self.line), now)?.map(|_| ()))
    }

    fn identity(&self) -> Option<String> {
        self.driver.as_ref().map(|_| "CCBu40 servo, analog and serial channel".to_owned())
    }

    fn configuration(&self) -> Option<String> {
        let MirrorSettings {
            command, feedback, scale_rad_per_v: [scale, _], stroke_rad: [stroke, _], ..
        } = &self.settings;
        let [scale, stroke] = [scale * 1e6, stroke * 1e3];
        Some(format!(
            "commands {command:?}, readings {feedback:?}, {scale} urad/V, stroke {stroke} mrad; the servo has no query for \
             its serial number"
        ))
    }

    fn change(&mut self, settings: &PointSettings) -> Result<(), DeviceError> {
        let path = match settings.mirror_channel {
            Some(MirrorChannel::Serial) => Path::Serial,
            Some(MirrorChannel::Analog) | None => Path::Analog,
        };
        if let Some(driver) = self.driver.as_mut().filter(|driver| driver.command_path() != path) {
            driver.change_command_path(path);
        }
        Ok(())
    }

    fn poll_change(&mut self, ports: &mut Ports, now: Duration) -> Result<bool, DeviceError> {
        let Some(driver) = &mut self.driver else { return Ok(true) };
        Ok(!driver.is_changing() || driver.configure(ports.line(self.line), now)?.is_some())
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let Some(driver) = &mut self.driver else { return Ok(()) };
        let (line, card) = ports.line_and_card(self.line, self.card);
        self.actuals = driver.exchange(line, card, self.command_rad, now)?;
        self.auxiliary.exchange(card, now)
    }

    fn group(&self) -> Group {
        Group { topic: "fsm", message: "Mirror", channels: AuxiliaryChannels::MIRROR_CHANNELS }
    }

    fn row(&mut self, row: &mut [f64]) {
        let own = self.actuals.row();
        let seen = self.auxiliary.row();
        row[..own.len()].copy_from_slice(&own);
        row[own.len()..own.len() + seen.len()].copy_from_slice(&seen);
    }

    fn mirror(&mut self) -> Option<&mut dyn SteeringMirror> {
        Some(self)
    }
}

impl SteeringMirror for Mirror {
    fn angle_rad(&self) -> [f64; 2] {
        self.actuals.angle_rad
    }

    fn command(&mut self, command_rad: [f64; 2]) {
        self.command_rad = command_rad;
    }

    fn synchronise(&mut self, ports: &mut Ports, now: Duration, high: bool) -> Result<(), DeviceError> {
        self.auxiliary.synchronise(ports.card(self.card), now, high)
    }
}
