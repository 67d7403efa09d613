//! Opening: the unit is put into Config mode, asked, changed where it differs, read back, and set going again.

use std::time::Duration;

use super::{BITS_PER_BYTE, Kvh, KvhIdentity, KvhSettings, Synchronisation};
use crate::device::DeviceError;
use crate::wire::ByteLine;

/// Times a command is sent before its answer is given up.
const TRIES_COUNT: u32 = 3;
/// Longest line of text that an answer can be.
const LINE_BYTES: usize = 160;

/// One entry of the unit's configuration.
#[derive(Clone, Debug)]
struct Field {
    /// Name of the command.
    name: &'static str,
    /// What it must be; `None` takes what is there (serial number).
    wanted: Option<String>,
    /// Whether the driver may change it.
    settable: bool,
}

/// Where the dialogue stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// `=CONFIG,1` until it is answered.
    Enter,
    /// `?NAME`; `changed` if it was set before.
    Ask {
        field: usize,
        changed: bool,
    },
    /// `=NAME,value`.
    Change {
        field: usize,
    },
    Done,
}

/// The dialogue that makes a [`Kvh`]; it never blocks, so [`Opening::poll`] is called until it gives one.
#[derive(Clone, Debug)]
pub struct Opening {
    settings: KvhSettings,
    fields: Vec<Field>,
    step: Step,
    sent_at: Option<Duration>,
    tries_count: u32,
    text: Vec<u8>,
    serial: String,
    /// Entries that were found to be what they must be.
    configuration: Vec<(&'static str, String)>,
}

impl Opening {
    /// Begins; nothing is sent yet.
    ///
    /// # Errors
    /// [`DeviceError::Setting`] if the messages do not fit on the line.
    pub fn new(settings: KvhSettings) -> Result<Self, DeviceError> {
        let bits_per_s = settings.format.bytes() as f64 * BITS_PER_BYTE * settings.message_rate_hz;
        if bits_per_s.is_nan() || settings.message_rate_hz <= 0.0 || bits_per_s > f64::from(settings.baud) {
            let rate_hz = f64::from(settings.baud) / (settings.format.bytes() as f64 * BITS_PER_BYTE);
            return Err(DeviceError::Setting {
                device: settings.name,
                setting: "message_rate_hz",
                value: settings.message_rate_hz,
                allowed: format!("above 0 and at most {rate_hz:.0} Hz at {} baud", settings.baud),
            });
        }
        let fields = fields(&settings);
        let text = Vec::with_capacity(LINE_BYTES);
        let sent_at = None;
        let tries_count = 0;
        let serial = String::new();
        let configuration = Vec::new();
        let step = Step::Enter;
        Ok(Self { settings, fields, step, sent_at, tries_count, text, serial, configuration })
    }

    /// Goes on as far as the answers that arrived up to `now` allow.
    ///
    /// # Errors
    /// [`DeviceError::Field`] if an entry cannot be made what it must be or an answer does not come in time.
    pub fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<Kvh>, DeviceError> {
        let mut bytes = [0; LINE_BYTES];
        loop {
            let count = line.read(now, &mut bytes)?;
            for &byte in &bytes[..count] {
                if let Some(text) = self.completed(byte) {
                    self.answered(&text, line, now)?;
                }
            }
            if count < bytes.len() {
                break;
            }
        }
        self.send_if_due(line, now)?;
        Ok((self.step == Step::Done).then(|| {
            let (serial, configuration) = (self.serial.clone(), self.configuration.clone());
            Kvh::new(self.settings.clone(), KvhIdentity { serial, configuration })
        }))
    }

    /// The line of text that this byte ends. What is not text is the binary output that still runs.
    fn completed(&mut self, byte: u8) -> Option<String> {
        match byte {
            b'\r' | b'\n' => {
                let text = String::from_utf8_lossy(&self.text).trim().to_owned();
                self.text.clear();
                (!text.is_empty()).then_some(text)
            }
            b' '..=b'~' if self.text.len() < LINE_BYTES => {
                self.text.push(byte);
                None
            }
            _ => {
                self.text.clear();
                None
            }
        }
    }

    fn answered(&mut self, text: &str, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        match self.step {
            // The tail of a binary message can precede the first answer on its line.
            Step::Enter if text.ends_with("CONFIG,1") => {
                self.go(Step::Ask { field: 0, changed: false });
            }
            Step::Enter | Step::Done => {}
            Step::Ask { field, .. } | Step::Change { field } => {
                let name = self.fields[field].name;
                match text.strip_prefix(name).and_then(|rest| rest.strip_prefix(',')) {
                    Some(value) => self.told(field, value)?,
                    None if text.starts_with("INVALID") => return Err(self.refused(field, text)),
                    None => {}
                }
            }
        }
        if self.step == Step::Done && self.sent_at.is_none() {
            self.sent_at = Some(now);
            line.write(now, b"=CONFIG,0\r\n")?;
        }
        Ok(())
    }

    /// The unit said what an entry is.
    fn told(&mut self, at: usize, value: &str) -> Result<(), DeviceError> {
        let field = &self.fields[at];
        let Some(wanted) = &field.wanted else {
            value.clone_into(&mut self.serial);
            self.go_past(at);
            return Ok(());
        };
        let right = value.eq_ignore_ascii_case(wanted);
        match self.step {
            // An echo proves nothing: it is read back.
            Step::Change { .. } => self.go(Step::Ask { field: at, changed: true }),
            _ if right => {
                self.configuration.push((field.name, value.to_owned()));
                self.go_past(at);
            }
            Step::Ask { changed: false, .. } if field.settable => self.go(Step::Change { field: at }),
            _ => return Err(self.refused(at, value)),
        }
        Ok(())
    }

    fn go_past(&mut self, field: usize) {
        let next = field + 1;
        let more = next < self.fields.len();
        self.go(if more { Step::Ask { field: next, changed: false } } else { Step::Done });
    }

    fn go(&mut self, step: Step) {
        (self.step, self.sent_at, self.tries_count) = (step, None, 0);
    }

    fn send_if_due(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        if self.step == Step::Done {
            return Ok(());
        }
        if let Some(sent_at) = self.sent_at {
            if now.saturating_sub(sent_at).as_secs_f64() < self.settings.answer_timeout_s {
                return Ok(());
            }
            if self.tries_count >= TRIES_COUNT {
                return Err(self.silent());
            }
        }
        (self.sent_at, self.tries_count) = (Some(now), self.tries_count + 1);
        line.write(now, self.command().as_bytes())
    }

    fn command(&self) -> String {
        match self.step {
            Step::Enter => "=CONFIG,1\r\n".to_owned(),
            Step::Ask { field, .. } => format!("?{}\r\n", self.fields[field].name),
            Step::Change { field } => {
                let Field { name, wanted, .. } = &self.fields[field];
                format!("={name},{}\r\n", wanted.as_deref().unwrap_or_default())
            }
            Step::Done => String::new(),
        }
    }

    fn refused(&self, at: usize, found: &str) -> DeviceError {
        let Field { name, wanted, .. } = &self.fields[at];
        self.error(name, wanted.clone().unwrap_or_else(|| "a value".to_owned()), found.to_owned())
    }

    fn silent(&self) -> DeviceError {
        let found = format!("no answer to {} commands", self.tries_count);
        match self.step {
            Step::Ask { field, .. } | Step::Change { field } => self.refused(field, &found),
            Step::Enter | Step::Done => self.error("CONFIG", "1".to_owned(), found),
        }
    }

    fn error(&self, field: &'static str, expected: String, found: String) -> DeviceError {
        let help = match field {
            "BAUD" => "set it with =BAUD or with the Config-RST pin, then the line to the same rate",
            "CONFIG" => "check power, wiring (pairs may be swapped) and bit rate of the line",
            _ => "check model and firmware: not every unit knows every value",
        };
        DeviceError::Field { device: self.settings.name.clone(), field, expected, found, help }
    }
}

/// Everything that decides what the bytes of a message mean, in the order it is asked for.
fn fields(settings: &KvhSettings) -> Vec<Field> {
    let field = |name, wanted: &str, settable| Field { name, wanted: Some(wanted.to_owned()), settable };
    let mut fields = vec![
        Field { name: "IS", wanted: None, settable: false },
        field("BAUD", &settings.baud.to_string(), false),
        field("OUTPUTFMT", &settings.format.letter().to_string(), true),
        field("ROTFMT", if settings.rate_output { "RATE" } else { "DELTA" }, true),
        field("ROTUNITS", "RAD", true),
        field("LINFMT", "ACCEL", true),
        field("TEMPUNITS", "C", true),
    ];
    match settings.synchronisation {
        Synchronisation::External => fields.push(field("MSYNC", "EXT", true)),
        Synchronisation::Internal(rate_hz) => {
            fields.push(field("MSYNC", "IMU", true));
            fields.push(field("DR", &rate_hz.to_string(), true));
        }
    }
    fields
}
