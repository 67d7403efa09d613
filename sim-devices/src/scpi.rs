//! Instrument side of SCPI: messages in, answers out, error queue (IEEE 488.2, SCPI-1999).
//!
//! Headers are matched by short or long form, `;` joins message units relative to the last node, `*OPC?` is answered when
//! nothing is under way any more. A message that comes before an answer was read interrupts it (−410). Answers leave
//! after the instrument's reaction time, at the pace of its interface.

mod error;
mod header;
mod number;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::time::Duration;

pub(crate) use error::{Error, code};
pub(crate) use header::{matches, word_matches};
pub(crate) use number::nr3;

/// From the end of a message to the first byte of its answer.
const REACTION: Duration = Duration::from_micros(500);
/// Pace of the interface.
const BYTES_PER_S: f64 = 10e6;
/// Entries of the error queue; the last one then says that it is full.
const QUEUE: usize = 20;
/// Longest message.
const LONGEST_MESSAGE: usize = 4096;
/// Version of the standard that `SYSTem:VERSion?` names.
const SCPI_VERSION: &str = "1999.0";

/// Bits of the event status register.
const OPERATION_COMPLETE: u8 = 1 << 0;
const QUERY_ERROR: u8 = 1 << 2;
const DEVICE_ERROR: u8 = 1 << 3;
const EXECUTION_ERROR: u8 = 1 << 4;
const COMMAND_ERROR: u8 = 1 << 5;
const POWER_ON: u8 = 1 << 7;

/// Bits of the status byte.
const ERROR_QUEUE: u8 = 1 << 2;
const MESSAGE_AVAILABLE: u8 = 1 << 4;
const EVENT_SUMMARY: u8 = 1 << 5;
const MASTER_SUMMARY: u8 = 1 << 6;

/// One command or query of a message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unit {
    /// Header from the root on, without leading colon and question mark, in capitals.
    pub(crate) header: String,
    /// Whether it asks.
    pub(crate) query: bool,
    /// Parameters, in capitals, without blanks around them.
    pub(crate) parameters: Vec<String>,
}

impl Unit {
    /// The only parameter.
    pub(crate) fn only(&self) -> Result<&str, Error> {
        match &self.parameters[..] {
            [] => Err(code::MISSING_PARAMETER),
            [one] => Ok(one),
            _ => Err(code::PARAMETER_NOT_ALLOWED),
        }
    }

    /// The only parameter, a number in this range.
    pub(crate) fn number(&self, range: [f64; 2]) -> Result<f64, Error> {
        let value: f64 = self.only()?.parse().map_err(|_| code::ILLEGAL_PARAMETER)?;
        if (range[0]..=range[1]).contains(&value) { Ok(value) } else { Err(code::OUT_OF_RANGE) }
    }

    /// The only parameter, one of these words; its place among them.
    pub(crate) fn choice(&self, words: &[&str]) -> Result<usize, Error> {
        let only = self.only()?;
        words.iter().position(|word| word_matches(word, only)).ok_or(code::ILLEGAL_PARAMETER)
    }
}

/// The interface of an instrument.
#[derive(Clone, Debug)]
pub(crate) struct Port {
    identity: &'static str,
    input: Vec<u8>,
    /// The message under way is too long: what is left of it is thrown away.
    overruns: bool,
    /// Rest of the message under way.
    units: VecDeque<Unit>,
    path: String,
    answer: Vec<u8>,
    output: VecDeque<u8>,
    /// When the output begins to leave, and how much of it has left.
    leaves: Duration,
    left_count: usize,
    waits_for_completion: bool,
    errors: VecDeque<Error>,
    event_status: u8,
    /// Masks of the event status register and of the status byte.
    event_mask: u8,
    service_mask: u8,
}

impl Port {
    pub(crate) fn new(identity: &'static str) -> Self {
        Self {
            identity,
            input: Vec::new(),
            overruns: false,
            units: VecDeque::new(),
            path: String::new(),
            answer: Vec::new(),
            output: VecDeque::new(),
            leaves: Duration::ZERO,
            left_count: 0,
            waits_for_completion: false,
            errors: VecDeque::new(),
            event_status: POWER_ON,
            event_mask: 0,
            service_mask: 0,
        }
    }

    /// Bytes from the host. A message that is too long is thrown away whole, and is an error.
    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let begins = self.input.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
            match byte {
                b'\n' if std::mem::take(&mut self.overruns) => {}
                _ if self.overruns => {}
                b'\n' => self.input.push(byte),
                _ if self.input.len() - begins < LONGEST_MESSAGE => self.input.push(byte),
                _ => {
                    self.input.truncate(begins);
                    self.overruns = true;
                    self.raise(code::INPUT_OVERRUN);
                }
            }
        }
    }

    /// What has left by now; how much.
    pub(crate) fn take(&mut self, now: Duration, into: &mut [u8]) -> usize {
        let passed_s = now.saturating_sub(self.leaves).as_secs_f64();
        let may = if now < self.leaves { 0 } else { (passed_s * BYTES_PER_S) as usize + 1 };
        let count = may.saturating_sub(self.left_count).min(into.len()).min(self.output.len());
        into.iter_mut().zip(self.output.drain(..count)).for_each(|(place, byte)| *place = byte);
        self.left_count += count;
        count
    }

    /// The next unit to be executed; ends the message before, if its units are done.
    pub(crate) fn next_unit(&mut self, now: Duration) -> Option<Unit> {
        while self.units.is_empty() {
            self.finish_message(now);
            let end = self.input.iter().position(|byte| *byte == b'\n')?;
            let line: Vec<u8> = self.input.drain(..=end).collect();
            if self.waits_for_completion || !self.output.is_empty() {
                self.waits_for_completion = false;
                self.output.clear();
                self.raise(code::INTERRUPTED);
            }
            self.path.clear();
            self.split(&String::from_utf8_lossy(&line).to_uppercase());
        }
        self.units.pop_front()
    }

    fn split(&mut self, line: &str) {
        for text in line.trim().split(';').map(str::trim).filter(|text| !text.is_empty()) {
            let (header, parameters) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
            let (header, query) = header.strip_suffix('?').map_or((header, false), |asked| (asked, true));
            let header = match header.strip_prefix(':') {
                Some(absolute) => absolute.to_owned(),
                None if header.starts_with('*') || self.path.is_empty() => header.to_owned(),
                None => format!("{}:{header}", self.path),
            };
            if !header.starts_with('*') {
                self.path = header.rsplit_once(':').map_or(String::new(), |(path, _)| path.to_owned());
            }
            self.units.push_back(Unit { header, query, parameters: split_parameters(parameters) });
        }
    }

    fn finish_message(&mut self, now: Duration) {
        if !self.answer.is_empty() {
            self.answer.push(b'\n');
            self.output.extend(self.answer.drain(..));
            (self.leaves, self.left_count) = (now + REACTION, 0);
        }
    }

    /// Adds to the answer of the message under way.
    pub(crate) fn respond(&mut self, bytes: &[u8]) {
        if !self.answer.is_empty() {
            self.answer.push(b';');
        }
        self.answer.extend_from_slice(bytes);
    }

    /// Nothing is under way: whoever waits for that is told.
    pub(crate) fn complete(&mut self, now: Duration) {
        if std::mem::take(&mut self.waits_for_completion) {
            self.respond(b"1");
            self.finish_message(now);
        }
    }

    /// Puts an error into the queue.
    pub(crate) fn raise(&mut self, error: Error) {
        self.event_status |= match error.0 {
            -199..=-100 => COMMAND_ERROR,
            -299..=-200 => EXECUTION_ERROR,
            -399..=-300 => DEVICE_ERROR,
            _ => QUERY_ERROR,
        };
        match self.errors.len() {
            0..QUEUE => self.errors.push_back(error),
            _ => self.errors[QUEUE - 1] = code::QUEUE_OVERFLOW,
        }
    }

    /// Executes a common command; whether it was one. `busy`: whether an operation is under way.
    pub(crate) fn common(&mut self, unit: &Unit, busy: bool) -> bool {
        match (unit.header.as_str(), unit.query) {
            ("*CLS", false) => {
                self.errors.clear();
                self.event_status = 0;
            }
            ("*IDN", true) => self.respond(self.identity.as_bytes()),
            ("*OPC", true) if busy => self.waits_for_completion = true,
            ("*OPC", true) => self.respond(b"1"),
            ("*OPC", false) => self.event_status |= OPERATION_COMPLETE,
            // Commands are carried out one after another, so there is nothing to wait for.
            ("*WAI", false) => {}
            ("*TST", true) => self.respond(b"+0"),
            ("*ESR", true) => {
                let status = std::mem::take(&mut self.event_status);
                self.respond(format!("{status:+}").as_bytes());
            }
            ("*STB", true) => self.respond(format!("{:+}", self.status_byte()).as_bytes()),
            ("*ESE", true) => self.respond(format!("{:+}", self.event_mask).as_bytes()),
            ("*SRE", true) => self.respond(format!("{:+}", self.service_mask).as_bytes()),
            ("*ESE" | "*SRE", false) => match unit.number([0.0, 255.0]) {
                Ok(mask) if unit.header == "*ESE" => self.event_mask = mask.round() as u8,
                Ok(mask) => self.service_mask = mask.round() as u8 & !MASTER_SUMMARY,
                Err(error) => self.raise(error),
            },
            (header, true) if matches("SYSTem:VERSion", header).is_some() => {
                self.respond(SCPI_VERSION.as_bytes());
            }
            (header, true)
                if matches("SYSTem:ERRor", header).is_some()
                    || matches("SYSTem:ERRor:NEXT", header).is_some() =>
            {
                let (number, text) = self.errors.pop_front().unwrap_or((0, "No error"));
                self.respond(format!("{number:+},\"{text}\"").as_bytes());
            }
            _ => return false,
        }
        true
    }

    fn status_byte(&self) -> u8 {
        let bit = |is_set: bool, bit: u8| if is_set { bit } else { 0 };
        let status = bit(!self.errors.is_empty(), ERROR_QUEUE)
            | bit(!self.output.is_empty() || !self.answer.is_empty(), MESSAGE_AVAILABLE)
            | bit(self.event_status & self.event_mask != 0, EVENT_SUMMARY);
        status | bit(status & self.service_mask != 0, MASTER_SUMMARY)
    }
}

/// Parameters between commas; those of a channel list such as `(@1,2)` do not part it.
fn split_parameters(text: &str) -> Vec<String> {
    let mut all = vec![String::new()];
    let mut is_inside = false;
    for c in text.chars() {
        match c {
            ',' if !is_inside => all.push(String::new()),
            _ => {
                is_inside = (is_inside || c == '(') && c != ')';
                all.last_mut().expect("it began with one").push(c);
            }
        }
    }
    all.iter().map(|one| one.trim().to_owned()).filter(|one| !one.is_empty()).collect()
}
