//! DC power supply: voltage, current and state of one output (Keysight E36300 command set).
//!
//! The driver reads and never switches an output. It may be given set points: they are compared with those of the instrument,
//! or written to it while the output is off, and read back either way.
//!
//! Sources: E36300 Series Programming Guide (E36311-90008) for `VOLT`, `CURR`, `MEAS`, `OUTP` with channel lists; bits of the
//! questionable instrument summary as in the guide of the E364xA (bit 0: constant current, bit 1: constant voltage, both:
//! unregulated, none: off). The E36300's own table of these bits was not at hand.

mod script;
#[cfg(test)]
mod tests;

use std::time::Duration;

pub use script::SetPoints;
use script::Want;

use crate::device::{Channel, DeviceError, Width};
use crate::scpi::{Dialogue, FormatError, Identity, Instrument, LONGEST_ANSWER, Progress, Session, number};
use crate::wire::ByteLine;

/// Models that speak these commands.
pub const MODELS: [&str; 3] = ["E36311A", "E36312A", "E36313A"];
/// Outputs of these models are 1 to this.
pub const OUTPUTS: u8 = 3;

/// Set points agree within this share of the set point, and within this much more: the instruments resolve 1 mV and 1 mA or
/// better.
const AGREEMENT_RATIO: f64 = 1e-3;
const AGREEMENT: f64 = 1e-3;

/// What the driver must know of a supply.
#[derive(Clone, Debug, PartialEq)]
pub struct SupplySettings {
    /// Name in errors and topics.
    pub name: String,
    /// Output that is read, from 1.
    pub output: u8,
    /// Set points that the output must have.
    pub set_points: SetPoints,
    /// Whether the driver writes the set points while the output is off. Otherwise it compares them only.
    pub writes_set_points: bool,
    /// From the start of one reading to the start of the next.
    pub period_s: f64,
    /// Time allowed for an answer.
    pub reply_timeout_s: f64,
}

/// What an output regulates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Regulation {
    /// The output is off.
    #[default]
    Off,
    /// Constant voltage.
    Voltage,
    /// Constant current: the load takes more than the limit.
    Current,
    /// Neither.
    Unregulated,
}

impl Regulation {
    /// Number in the log: 0 off, 1 constant voltage, 2 constant current, 3 unregulated.
    pub fn code(self) -> u8 {
        match self {
            Self::Off => 0,
            Self::Voltage => 1,
            Self::Current => 2,
            Self::Unregulated => 3,
        }
    }
}

/// One reading of an output.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Voltage at the output.
    pub voltage_v: f64,
    /// Current out of it.
    pub current_a: f64,
    /// Whether it is switched on.
    pub is_on: bool,
    /// What it regulates.
    pub regulation: Regulation,
    /// Whether the over-voltage protection (OVP) has tripped.
    pub over_voltage: bool,
    /// Whether the over-current protection (OCP) has tripped.
    pub over_current: bool,
}

/// A supply behind its line.
#[derive(Clone, Debug)]
pub struct Supply {
    settings: SupplySettings,
    dialogue: Dialogue<Want>,
    /// Whether the set points have been asked for.
    asks_set_points: bool,
    /// The readings that are asked for again and again.
    cycle: Session<Want>,
    due: Duration,
    /// A reading failed: its queries begin anew.
    begins_anew: bool,
    /// The reading under way, and the last one that was whole with its time.
    next: Reading,
    last: Reading,
    read_at: Option<Duration>,
    readings_count: u32,
    age_s: f64,
}

impl Supply {
    /// What the driver publishes each tick, in the order of [`Supply::row`].
    pub const CHANNELS: &'static [Channel] = &[
        channel("voltage_v", "V", Width::F64),
        channel("current_a", "A", Width::F64),
        channel("age_s", "s", Width::F32),
        channel("readings", "count", Width::U32),
        channel("is_on", "", Width::I8),
        channel("regulation", "", Width::I8),
        channel("over_voltage", "", Width::I8),
        channel("over_current", "", Width::I8),
    ];

    /// A driver that has not spoken to its instrument yet.
    ///
    /// # Errors
    /// [`DeviceError::Setting`] for an output, a period, a timeout or a set point that cannot be.
    pub fn new(settings: SupplySettings) -> Result<Self, DeviceError> {
        script::check(&settings)?;
        let SupplySettings { name, reply_timeout_s, .. } = &settings;
        let dialogue = Dialogue::new(name, Want::Identity, *reply_timeout_s);
        let cycle = Session::new(name, script::reading(&settings), LONGEST_ANSWER, *reply_timeout_s);
        Ok(Self {
            settings,
            dialogue,
            asks_set_points: false,
            cycle,
            due: Duration::ZERO,
            begins_anew: true,
            next: Reading::default(),
            last: Reading::default(),
            read_at: None,
            readings_count: 0,
            age_s: 0.0,
        })
    }

    /// Goes on with the dialogue that identifies the instrument and compares or writes its set points; the identity once that is
    /// done.
    ///
    /// # Errors
    /// No answer in time, a model that the driver does not know, an error that the instrument reports, a set point that differs.
    pub fn open(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<Identity>, DeviceError> {
        if !self.asks_set_points {
            if self.identify(line, now)?.is_none() {
                return Ok(None);
            }
            let SupplySettings { name, reply_timeout_s, .. } = &self.settings;
            self.dialogue.session =
                Session::new(name, script::set_points(&self.settings), LONGEST_ANSWER, *reply_timeout_s);
            self.dialogue.session.start(line, now)?;
            self.asks_set_points = true;
        }
        Ok(if Instrument::poll(self, line, now)? { self.dialogue.identity.clone() } else { None })
    }

    /// Goes on with the readings as far as it gets without waiting; `true` if one was completed. Call once per tick.
    ///
    /// # Errors
    /// When the line is gone, or the instrument does not answer in time or reports an error. The next call begins anew.
    pub fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<bool, DeviceError> {
        let outcome = self.go_on(line, now);
        self.begins_anew |= outcome.is_err();
        let is_new = outcome?;
        if is_new {
            (self.last, self.read_at) = (self.next, Some(now));
            self.readings_count = self.readings_count.saturating_add(1);
        }
        self.age_s = now.saturating_sub(self.read_at.unwrap_or_default()).as_secs_f64();
        Ok(is_new)
    }

    fn go_on(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<bool, DeviceError> {
        if self.begins_anew || !self.cycle.is_running() {
            if now < self.due {
                return Ok(false);
            }
            self.due = now + Duration::from_secs_f64(self.settings.period_s);
            self.cycle.start(line, now)?;
            self.begins_anew = false;
        }
        loop {
            match self.cycle.poll(line, now)? {
                Progress::Waiting => return Ok(false),
                Progress::Done => return Ok(true),
                Progress::Answered(want) => self.take_reading(want)?,
            }
        }
    }

    fn take_reading(&mut self, want: Want) -> Result<(), DeviceError> {
        let value = number::number(self.cycle.answer(), 1).map_err(|source| self.cycle.unusable(source))?;
        let is_set = value != 0.0;
        match want {
            Want::Voltage => self.next.voltage_v = value,
            Want::Current => self.next.current_a = value,
            Want::Output => self.next.is_on = is_set,
            Want::Condition => self.next.regulation = regulation(value),
            Want::OverVoltage => self.next.over_voltage = is_set,
            Want::OverCurrent => self.next.over_current = is_set,
            Want::Identity | Want::IsOff | Want::Complete | Want::SetPoint(_) => {}
        }
        Ok(())
    }

    /// The newest reading, and how many there were; `None` before the first.
    pub fn reading(&self) -> Option<&Reading> {
        self.read_at.map(|_| &self.last)
    }

    /// Readings so far.
    pub fn readings_count(&self) -> u32 {
        self.readings_count
    }

    /// The values in the order of [`Supply::CHANNELS`]; 0 before the first reading.
    pub fn row(&self) -> [f64; 8] {
        let Reading { voltage_v, current_a, is_on, regulation, over_voltage, over_current } = self.last;
        let flag = |is_set: bool| f64::from(u8::from(is_set));
        [
            voltage_v,
            current_a,
            self.age_s,
            f64::from(self.readings_count),
            flag(is_on),
            f64::from(regulation.code()),
            flag(over_voltage),
            flag(over_current),
        ]
    }
}

impl Instrument for Supply {
    type Query = Want;

    const ABORT: &'static str = "*CLS";

    fn dialogue(&mut self) -> &mut Dialogue<Want> {
        &mut self.dialogue
    }

    fn check(&self, identity: &Identity) -> Result<(), DeviceError> {
        if MODELS.iter().any(|model| identity.model.starts_with(model)) {
            return Ok(());
        }
        Err(DeviceError::Field {
            device: self.settings.name.clone(),
            field: "model in *IDN?",
            expected: MODELS.join(", "),
            found: format!("`{identity}`"),
            help: "check the address of the instrument, or add its command set to the driver",
        })
    }

    fn take(&mut self, want: Want, _: Duration) -> Result<(), DeviceError> {
        let value = number::number(self.dialogue.session.answer(), 1)
            .map_err(|source| self.dialogue.unusable(source))?;
        match want {
            Want::IsOff if value != 0.0 => Err(self.refused(
                "output",
                "off, so that set points can be written".to_owned(),
                "on".to_owned(),
                "switch the output off at the instrument, or only compare the set points",
            )),
            Want::Complete if value != 1.0 => {
                let found = String::from_utf8_lossy(self.dialogue.session.answer()).into_owned();
                let expected = "`1`, all operations complete";
                Err(self.dialogue.unusable(FormatError::Text { expected, found }))
            }
            Want::SetPoint(which) => {
                let wanted = which.of(&self.settings.set_points).unwrap_or(value);
                if (value - wanted).abs() <= AGREEMENT + AGREEMENT_RATIO * wanted.abs() {
                    return Ok(());
                }
                let unit = which.unit();
                let help = "set it at the instrument, or correct the rig file";
                Err(self.refused(which.name(), format!("{wanted} {unit}"), format!("{value} {unit}"), help))
            }
            _ => Ok(()),
        }
    }
}

impl Supply {
    fn refused(
        &self,
        field: &'static str,
        expected: String,
        found: String,
        help: &'static str,
    ) -> DeviceError {
        let device = format!("{}, output {}", self.settings.name, self.settings.output);
        DeviceError::Field { device, field, expected, found, help }
    }
}

/// The lower bits of the questionable instrument summary.
fn regulation(condition: f64) -> Regulation {
    match condition as u32 & 3 {
        0 => Regulation::Off,
        1 => Regulation::Current,
        2 => Regulation::Voltage,
        _ => Regulation::Unregulated,
    }
}

const fn channel(name: &'static str, unit: &'static str, width: Width) -> Channel {
    Channel { name, unit, width }
}
