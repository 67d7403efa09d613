//! The fast steering mirror behind any of its controllers, on a line and the analog card, and what else is wired to the card with it.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::mirror::{Actuals, Path};
use drivers::wire::{AnalogPort, ByteLine};
use procedures::case::MirrorChannel;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::auxiliary::{AuxiliaryChannels, AuxiliarySettings};
use crate::model::device::DeviceEntry;
use crate::rig::PointSettings;
use crate::rig::device::{Device, Group, SteeringMirror};
use crate::rig::driver::{Misfit, PortField, no_channels, not_above_zero};
use crate::rig::wires::Ports;

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

/// The analog card of any mirror.
pub(super) const CARD: PortField = PortField::card(
    "Analog card with commands, strain gauges, autocollimator, synchronisation and loop-back.",
);

const fn channel(key: &'static str, default: &'static str, doc: &'static str) -> Field {
    Field::default(key, Shape::Integer, default, doc)
}

/// Settings of any mirror.
pub(super) const FIELDS: [Field; 13] = [
    Field::default(COMMAND_PATH, Shape::Choice(&["analog", "serial"]), "analog", "Channel of the commands."),
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
];

/// Settings of any mirror that cannot be.
pub(super) fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let scales = not_above_zero(entry, &["scale", "stroke", "reference-scale"]);
    [scales, no_channels(entry, &OUTPUTS), no_channels(entry, &INPUTS)].concat()
}

/// The path that a word of the rig file names.
pub(super) fn path(entry: &DeviceEntry, key: &str) -> Path {
    if entry.text(key) == "serial" { Path::Serial } else { Path::Analog }
}

/// Outputs of the commands on the card: azimuth, elevation.
pub(super) fn command_outputs(entry: &DeviceEntry) -> [usize; 2] {
    [entry.channel(OUTPUTS[0]), entry.channel(OUTPUTS[1])]
}

/// Inputs of the strain gauges on the card: azimuth, elevation.
pub(super) fn feedback_inputs(entry: &DeviceEntry) -> [usize; 2] {
    [entry.channel(INPUTS[0]), entry.channel(INPUTS[1])]
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

/// The driver of a controller of a mirror.
pub(super) trait Servo: Sized {
    /// What it must know of the controller.
    type Settings: Clone;

    /// A driver that has not spoken to its controller yet.
    fn with(settings: Self::Settings) -> Result<Self, DeviceError>;

    /// Goes on with the configuration; who the controller is, once that is done.
    fn configure(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<String>, DeviceError>;

    /// Its settings in words.
    fn configuration(settings: &Self::Settings) -> String;

    /// The way that commands are sent.
    fn command_path(&self) -> Path;

    /// Begins to send commands another way; [`Servo::configure`] goes on with it.
    fn change_command_path(&mut self, path: Path);

    /// Whether [`Servo::configure`] must be called until it is done.
    fn is_changing(&self) -> bool;

    /// One tick.
    fn exchange(
        &mut self,
        line: &mut dyn ByteLine,
        card: &mut dyn AnalogPort,
        command_rad: [f64; 2],
        now: Duration,
    ) -> Result<Actuals, DeviceError>;
}

/// The mirror, and the last of what it was told and showed.
pub(super) struct Mirror<S: Servo> {
    name: String,
    settings: S::Settings,
    port: String,
    card_port: String,
    line: usize,
    card: usize,
    driver: Option<S>,
    identity: Option<String>,
    auxiliary: AuxiliaryChannels,
    command_rad: [f64; 2],
    actuals: Actuals,
}

impl<S: Servo> Mirror<S> {
    /// On ports that are not open yet.
    pub(super) fn closed(entry: &DeviceEntry, settings: S::Settings) -> Self {
        Self {
            name: entry.name.clone(),
            settings,
            port: entry.port("line").to_owned(),
            card_port: entry.port("card").to_owned(),
            line: 0,
            card: 0,
            driver: None,
            identity: None,
            auxiliary: AuxiliaryChannels::new(auxiliary_settings(entry)),
            command_rad: [0.0; 2],
            actuals: Actuals::default(),
        }
    }
}

impl<S: Servo> Device for Mirror<S> {
    fn name(&self) -> &str {
        &self.name
    }

    fn open(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<()>, DeviceError> {
        let driver = match &mut self.driver {
            Some(driver) => driver,
            None => {
                self.line = ports.find_line(&self.name, &self.port)?;
                self.card = ports.find_card(&self.name, &self.card_port)?;
                self.driver.insert(S::with(self.settings.clone())?)
            }
        };
        self.identity = driver.configure(ports.line(self.line), now)?;
        Ok(self.identity.is_some().then_some(()))
    }

    fn identity(&self) -> Option<String> {
        self.identity.clone()
    }

    fn configuration(&self) -> Option<String> {
        Some(S::configuration(&self.settings))
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
        // A serial line that fails takes neither the card's signals nor the command on the card along.
        let exchanged = driver.exchange(line, card, self.command_rad, now);
        let seen = self.auxiliary.exchange(card, now);
        self.actuals = exchanged?;
        seen
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

impl<S: Servo> SteeringMirror for Mirror<S> {
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
