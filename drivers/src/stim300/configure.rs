//! Opening: the unit is asked who it is and how it is configured, changed in service mode where it differs, and asked again.

use std::time::Duration;

use super::service::{Text, commands, differences};
use super::{
    Configuration, ForceUnit, Found, Parser, SampleRate, Special, SpecialKind, Stim300, Stim300Identity,
    Stim300Settings,
};
use crate::device::DeviceError;
use crate::framing::read_waiting;
use crate::wire::ByteLine;

/// Times a command is sent before its answer is given up.
const TRIES_COUNT: u32 = 3;
/// Bits of a character without parity: start, eight data bits, stop.
const BITS_PER_BYTE: f64 = 10.0;
/// Share of the line that datagrams may use is one over this (TS1524 rev. 31, equation 12).
const MARGIN: f64 = 1.1;

/// Where the dialogue stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// `N`, `I`, `C`: what is not known yet.
    Ask,
    /// `SERVICEMODE` until the unit is ready.
    Enter,
    /// One of the commands that change the unit.
    Change(usize),
    /// `x N` until the unit returns to Normal mode.
    Leave,
}

/// The dialogue that makes a [`Stim300`]; it never blocks, so [`Opening::poll`] is called until it gives one.
#[derive(Clone, Debug)]
pub struct Opening {
    settings: Stim300Settings,
    step: Step,
    parser: Parser,
    text: Text,
    part_number: Option<String>,
    serial: Option<String>,
    configuration: Option<Configuration>,
    commands: Vec<String>,
    is_changed: bool,
    /// A measurement has come since this step began: the unit is in Normal mode, whatever became of its words.
    has_measured: bool,
    sent_at: Option<Duration>,
    tries_count: u32,
}

impl Opening {
    /// Begins; nothing is sent yet.
    ///
    /// # Errors
    /// [`DeviceError::Setting`] if the unit does not have the sample rate or the measurements do not fit on the line;
    /// [`DeviceError::Field`] for velocities since power-up, whose wrapping is not documented for all ranges.
    pub fn new(settings: Stim300Settings) -> Result<Self, DeviceError> {
        check(&settings)?;
        Ok(Self {
            settings,
            step: Step::Ask,
            parser: Parser::default(),
            text: Text::default(),
            part_number: None,
            serial: None,
            configuration: None,
            commands: Vec::new(),
            is_changed: false,
            has_measured: false,
            sent_at: None,
            tries_count: 0,
        })
    }

    /// Goes on as far as the answers that arrived up to `now` allow.
    ///
    /// # Errors
    /// [`DeviceError::Field`] if the unit is configured otherwise and may or can not be changed, or if an answer does not come
    /// in time.
    pub fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<Stim300>, DeviceError> {
        read_waiting(line, now, |bytes| {
            self.parser.push(bytes);
            self.text.push(bytes);
            while let Some(found) = self.parser.next() {
                match found {
                    Found::Special(special) => self.take_special(&special)?,
                    Found::Measurement(_) => self.has_measured = true,
                }
            }
            Ok(())
        })?;
        match self.step {
            Step::Ask => return self.asked(line, now),
            Step::Enter if self.text.contains("SERIAL NUMBER") && self.text.is_ready() => self.change(0),
            Step::Change(place) if self.text.is_ready() => match self.text.error() {
                Some(error) => return Err(self.refused_command(place, error)),
                None => self.change(place + 1),
            },
            Step::Leave if self.has_measured || self.text.contains("SYSTEM RETURNING TO NORMAL MODE") => {
                self.is_changed = true;
                self.configuration = None;
                self.go(Step::Ask);
            }
            Step::Enter | Step::Change(_) | Step::Leave => {}
        }
        self.send_if_due(line, now)?;
        Ok(None)
    }

    /// Takes what a special datagram says; at power-up they come unasked.
    fn take_special(&mut self, special: &Special) -> Result<(), DeviceError> {
        if self.step != Step::Ask {
            return Ok(());
        }
        let waited_for = self.missing();
        match special.kind() {
            SpecialKind::PartNumber => self.part_number = special.part_number(),
            SpecialKind::SerialNumber => self.serial = special.serial_number(),
            SpecialKind::Configuration => self.configuration = Some(self.decoded(special)?),
            SpecialKind::BiasTrim | SpecialKind::ExtendedError => {}
        }
        if self.missing() != waited_for {
            self.go(Step::Ask);
        }
        Ok(())
    }

    fn decoded(&self, special: &Special) -> Result<Configuration, DeviceError> {
        let payload = special.payload().first_chunk().expect("a configuration has 21 bytes");
        Configuration::decode(payload).map_err(|unknown| {
            let help = "the firmware is newer than the datasheet TS1524 rev. 31: extend the driver";
            self.error(
                unknown.field,
                "a code of the datasheet".to_owned(),
                format!("{:X}h", unknown.code),
                help,
            )
        })
    }

    /// What must still be asked for.
    fn missing(&self) -> Option<SpecialKind> {
        match () {
            () if self.part_number.is_none() => Some(SpecialKind::PartNumber),
            () if self.serial.is_none() => Some(SpecialKind::SerialNumber),
            () if self.configuration.is_none() => Some(SpecialKind::Configuration),
            () => None,
        }
    }

    /// Asks for what is missing, or compares what is known.
    fn asked(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<Stim300>, DeviceError> {
        let (Some(part_number), Some(serial), Some(unit)) =
            (&self.part_number, &self.serial, &self.configuration)
        else {
            // Left in service mode by somebody else, it does not know the commands of Normal mode.
            if self.text.contains("E001 UNKNOWN COMMAND") {
                self.text.clear();
                line.write(now, b"x N\r")?;
            }
            self.send_if_due(line, now)?;
            return Ok(None);
        };
        let differing = differences(&self.settings, unit);
        let Some(first) = differing.first() else {
            let identity = Stim300Identity {
                part_number: part_number.clone(),
                serial: serial.clone(),
                configuration: unit.clone(),
            };
            return Ok(Some(Stim300::new(self.settings.clone(), identity)));
        };
        let unchangeable = differing.iter().find(|one| one.command.is_none());
        if self.is_changed || !self.settings.may_change_unit || unchangeable.is_some() {
            let one = unchangeable.unwrap_or(first);
            let help = match one.field {
                "bit rate" => "set it in service mode (t), then the line to the same rate",
                _ if self.is_changed => "the unit did not keep what it was told in service mode",
                _ => "change it in service mode, or allow the driver to",
            };
            return Err(self.error(one.field, one.expected.clone(), one.found.clone(), help));
        }
        self.commands = commands(&self.settings, &differing);
        self.go(Step::Enter);
        self.send_if_due(line, now)?;
        Ok(None)
    }

    fn change(&mut self, place: usize) {
        self.go(if place < self.commands.len() { Step::Change(place) } else { Step::Leave });
    }

    fn go(&mut self, step: Step) {
        (self.step, self.sent_at, self.tries_count) = (step, None, 0);
        self.has_measured = false;
        self.text.clear();
    }

    fn send_if_due(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        if let Some(sent_at) = self.sent_at {
            if now.saturating_sub(sent_at).as_secs_f64() < self.settings.answer_timeout_s {
                return Ok(());
            }
            if self.tries_count >= TRIES_COUNT {
                let found = format!("no answer to {} commands {:?}", self.tries_count, self.command());
                let help = "check power, wiring (pairs may be swapped) and bit rate of the line";
                return Err(self.error("answer", "one".to_owned(), found, help));
            }
        }
        (self.sent_at, self.tries_count) = (Some(now), self.tries_count + 1);
        let command = format!("{}\r", self.command());
        line.write(now, command.as_bytes())
    }

    fn command(&self) -> String {
        match self.step {
            Step::Ask => self.missing().map(|kind| kind.letter().to_string()).unwrap_or_default(),
            Step::Enter => "SERVICEMODE".to_owned(),
            Step::Change(place) => self.commands[place].clone(),
            Step::Leave => "x N".to_owned(),
        }
    }

    fn refused_command(&self, place: usize, error: String) -> DeviceError {
        let expected = format!("{:?} to be accepted", self.commands[place]);
        self.error("service mode", expected, error, "not every unit and bit rate allows every setting")
    }

    fn error(&self, field: &'static str, expected: String, found: String, help: &'static str) -> DeviceError {
        DeviceError::Field { device: self.settings.name.clone(), field, expected, found, help }
    }
}

fn check(settings: &Stim300Settings) -> Result<(), DeviceError> {
    if let SampleRate::Internal(rate_hz) = settings.sample_rate {
        if settings.sample_rate.code().is_none() {
            return Err(DeviceError::Setting {
                device: settings.name.clone(),
                setting: "sample rate, Hz",
                value: f64::from(rate_hz),
                allowed: "allowed are 125, 250, 500, 1000 and 2000 Hz".to_owned(),
            });
        }
        let needed = MARGIN * BITS_PER_BYTE * settings.content.bytes() as f64 * f64::from(rate_hz);
        if needed > f64::from(settings.bit_rate) {
            return Err(DeviceError::Setting {
                device: settings.name.clone(),
                setting: "bit rate, bit/s",
                value: f64::from(settings.bit_rate),
                allowed: format!(
                    "datagram {:02X}h at {rate_hz} Hz needs at least {needed:.0} bit/s",
                    settings.content.id()
                ),
            });
        }
    }
    if matches!(settings.accelerometer_unit, ForceUnit::IntegratedVelocity | ForceUnit::IntegratedVelocityGs)
    {
        return Err(DeviceError::Field {
            device: settings.name.clone(),
            field: "accelerometer output unit",
            expected: "acceleration, average acceleration or incremental velocity".to_owned(),
            found: format!("{:?}", settings.accelerometer_unit),
            help: "velocities since power-up wrap at a bound that this driver does not know",
        });
    }
    Ok(())
}
