//! Controllers that speak PI's General Command Set, GCS 2.0, over a byte line (E-727 user manual E727T0005, PIPython 2.13):
//! closed-loop commands, positions and the data recorder of a two-axis mirror.
//!
//! Commands are text that a line feed ends. A query has one reply; what sets something has none, so the driver asks for the
//! error number behind it. One request is under way at a time.

mod error;
mod mirror;
mod record;
mod request;
#[cfg(test)]
mod tests;

use std::time::Duration;

pub use self::mirror::{GcsMirror, GcsMirrorSettings};
pub use self::record::Record;
pub use self::request::{RecordOption, Request, TriggerSource};

use self::error::error_meaning;
use self::request::Form;
use crate::answer::FormatError;
use crate::device::DeviceError;
use crate::wire::ByteLine;

/// Bytes read from the line at once.
const READ_BYTES: usize = 256;
/// Most bytes of a reply: two tables of the recorder with 262144 points do not reach it.
const MOST_BYTES: usize = 16 << 20;
/// Question for the number of the last error, which it clears.
const ERROR_QUERY: &[u8] = b"ERR?\n";

/// Error number that a stop leaves behind.
const STOPPED: i32 = 10;

/// What the driver must know of a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct GcsSettings {
    /// Name in errors, e.g. `fsm`.
    pub name: String,
    /// Identifiers of the axes of azimuth and elevation, e.g. `1` and `2`.
    pub axes: [String; 2],
    /// Time without a byte after which a reply is given up, s.
    pub answer_timeout_s: f64,
}

/// What a request brought back.
#[derive(Clone, Debug, PartialEq)]
pub enum Reply {
    /// The controller has accepted it.
    Done,
    /// Text: the identity.
    Text(String),
    /// Names, one a line: the axes.
    Lines(Vec<String>),
    /// A value of each axis, in the order of the settings.
    Values([f64; 2]),
    /// A single number.
    Number(f64),
    /// Tables of the data recorder.
    Record(Record),
}

/// Where a request stands.
#[derive(Clone, Debug, PartialEq)]
enum Stage {
    Idle,
    /// The reply is awaited; for what sets something it is the error number.
    Waiting(Request),
    /// A query was not answered: the controller is asked why.
    AskingWhy(Request),
}

/// A controller on a line.
#[derive(Clone, Debug)]
pub struct Gcs {
    settings: GcsSettings,
    stage: Stage,
    reply: Vec<u8>,
    /// When the last byte came or the request went out.
    last_byte_at: Duration,
}

impl Gcs {
    /// A driver that has not spoken to its controller yet.
    ///
    /// # Errors
    /// [`DeviceError::Setting`] for a timeout that is not above 0; [`DeviceError::Field`] for an axis identifier that is empty, has
    /// other characters than letters, digits, `_` and `-`, or stands twice.
    pub fn new(settings: GcsSettings) -> Result<Self, DeviceError> {
        if settings.answer_timeout_s.is_nan() || settings.answer_timeout_s <= 0.0 {
            return Err(DeviceError::Setting {
                device: settings.name,
                setting: "answer_timeout_s",
                value: settings.answer_timeout_s,
                allowed: "it must be above 0".to_owned(),
            });
        }
        let is_name = |axis: &String| {
            !axis.is_empty() && axis.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'))
        };
        if !settings.axes.iter().all(is_name) || settings.axes[0] == settings.axes[1] {
            return Err(DeviceError::Field {
                device: settings.name,
                field: "axes",
                expected: "two different identifiers".to_owned(),
                found: format!("{:?}", settings.axes),
                help: "SAI? lists the axes of the controller",
            });
        }
        Ok(Self { settings, stage: Stage::Idle, reply: Vec::new(), last_byte_at: Duration::ZERO })
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &GcsSettings {
        &self.settings
    }

    /// Whether a request may be sent.
    pub fn is_idle(&self) -> bool {
        self.stage == Stage::Idle
    }

    /// Sends a request; a request under way is forgotten. [`Gcs::poll`] gives the reply.
    ///
    /// # Errors
    /// When the line is gone, or [`DeviceError::Setting`] for a value that is not finite.
    pub fn send(
        &mut self,
        line: &mut dyn ByteLine,
        request: Request,
        now: Duration,
    ) -> Result<(), DeviceError> {
        let mut text = request.text(&self.settings.axes).map_err(|value| DeviceError::Setting {
            device: self.settings.name.clone(),
            setting: "value of a command",
            value,
            allowed: "it must be finite".to_owned(),
        })?;
        text.push('\n');
        let mut bytes = text.into_bytes();
        if request.form() == Form::Nothing {
            bytes.extend(ERROR_QUERY);
        }
        // What still comes of a request that was forgotten must not be taken for the reply.
        let mut late = [0; READ_BYTES];
        while line.read(now, &mut late)? == READ_BYTES {}
        self.reply.clear();
        self.stage = Stage::Waiting(request);
        self.last_byte_at = now;
        line.write(now, &bytes)
    }

    /// The reply, once it is complete; `None` until then and while nothing is under way.
    ///
    /// # Errors
    /// [`DeviceError::Instrument`] with the number and the meaning of the error that the controller reports,
    /// [`DeviceError::Answer`] for a reply that is not what the request demands, [`DeviceError::Field`] for silence.
    pub fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<Reply>, DeviceError> {
        if self.is_idle() {
            return Ok(None);
        }
        let mut bytes = [0; READ_BYTES];
        let mut is_complete = is_complete(&self.reply);
        while !is_complete {
            let count = line.read(now, &mut bytes)?.min(READ_BYTES);
            if count > 0 {
                self.last_byte_at = now;
            }
            self.reply.extend(&bytes[..count]);
            is_complete = self::is_complete(&self.reply);
            if count < READ_BYTES {
                break;
            }
        }
        if self.reply.len() > MOST_BYTES {
            return Err(self.end_with(FormatError::TooLong { limit: MOST_BYTES }));
        }
        if is_complete {
            return self.finish().map(Some);
        }
        if now.saturating_sub(self.last_byte_at).as_secs_f64() > self.settings.answer_timeout_s {
            self.give_up(line, now)?;
        }
        Ok(None)
    }

    /// Silence: a controller does not answer a query that it refuses, so it is asked for the error once.
    fn give_up(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        match std::mem::replace(&mut self.stage, Stage::Idle) {
            Stage::Waiting(request) if request.form() != Form::Nothing && self.reply.is_empty() => {
                self.stage = Stage::AskingWhy(request);
                self.last_byte_at = now;
                line.write(now, ERROR_QUERY)
            }
            Stage::Waiting(request) | Stage::AskingWhy(request) => Err(DeviceError::Field {
                device: self.settings.name.clone(),
                field: "reply",
                expected: format!("one to {:?}", self.text_of(&request)),
                found: format!("{} bytes in {} s", self.reply.len(), self.settings.answer_timeout_s),
                help: "check power, cable and bit rate, and that the controller speaks GCS 2.0",
            }),
            Stage::Idle => Ok(()),
        }
    }

    fn finish(&mut self) -> Result<Reply, DeviceError> {
        let stage = std::mem::replace(&mut self.stage, Stage::Idle);
        let text = String::from_utf8_lossy(&self.reply).into_owned();
        let (request, is_error_number) = match stage {
            Stage::Waiting(request) => {
                let is_error_number = request.form() == Form::Nothing;
                (request, is_error_number)
            }
            Stage::AskingWhy(request) => (request, true),
            Stage::Idle => return Ok(Reply::Done),
        };
        let command = self.text_of(&request);
        if !is_error_number {
            let reply = request.read(&text, &self.settings.axes);
            return reply.map_err(|source| self.wrong_answer(command, source));
        }
        let code: i32 = text.trim().parse().map_err(|_| {
            let expected = "an error number";
            self.wrong_answer(
                "ERR?".to_owned(),
                FormatError::Text { expected, found: text.trim().to_owned() },
            )
        })?;
        match (code, request.form()) {
            (0, Form::Nothing) => Ok(Reply::Done),
            (STOPPED, _) if request == Request::Stop => Ok(Reply::Done),
            (0, _) => {
                let (expected, found) = ("a reply", String::from("silence, and no error"));
                Err(self.wrong_answer(command, FormatError::Text { expected, found }))
            }
            _ => Err(DeviceError::Instrument {
                device: self.settings.name.clone(),
                command,
                code,
                message: error_meaning(code).to_owned(),
            }),
        }
    }

    fn end_with(&mut self, source: FormatError) -> DeviceError {
        let command = match std::mem::replace(&mut self.stage, Stage::Idle) {
            Stage::Waiting(request) | Stage::AskingWhy(request) => self.text_of(&request),
            Stage::Idle => String::new(),
        };
        self.wrong_answer(command, source)
    }

    fn wrong_answer(&self, command: String, source: FormatError) -> DeviceError {
        DeviceError::Answer { device: self.settings.name.clone(), command, source }
    }

    fn text_of(&self, request: &Request) -> String {
        request.text(&self.settings.axes).unwrap_or_default()
    }
}

/// A line feed ends a reply unless a space stands before it.
fn is_complete(reply: &[u8]) -> bool {
    matches!(reply, [b'\n'] | [.., b'\0'..=b'\x1F' | b'!'..=b'\xFF', b'\n'])
}
