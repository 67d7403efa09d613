//! Instrument side of SCPI: messages in, answers out, error queue (IEEE 488.2, SCPI-1999).
//!
//! Headers are matched by short or long form, `;` joins message units relative to the last node, `*OPC?` is answered when
//! nothing is under way any more. A message that comes before an answer was read interrupts it (−410). Answers leave
//! after the instrument's reaction time, at the pace of its interface.

mod error;
mod header;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::time::Duration;

pub(crate) use error::{Error, code};
pub(crate) use header::{matches, word_matches};

/// From the end of a message to the first byte of its answer.
const REACTION: Duration = Duration::from_micros(500);
/// Pace of the interface.
const BYTES_PER_S: f64 = 10e6;
/// Entries of the error queue; the last one then says that it is full.
const QUEUE: usize = 20;
/// Longest message.
const LONGEST_MESSAGE: usize = 4096;

/// Bits of the event status register.
const OPERATION_COMPLETE: u8 = 1 << 0;
const QUERY_ERROR: u8 = 1 << 2;
const EXECUTION_ERROR: u8 = 1 << 4;
const COMMAND_ERROR: u8 = 1 << 5;
const POWER_ON: u8 = 1 << 7;

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
}

impl Port {
    pub(crate) fn new(identity: &'static str) -> Self {
        Self {
            identity,
            input: Vec::new(),
            units: VecDeque::new(),
            path: String::new(),
            answer: Vec::new(),
            output: VecDeque::new(),
            leaves: Duration::ZERO,
            left_count: 0,
            waits_for_completion: false,
            errors: VecDeque::new(),
            event_status: POWER_ON,
        }
    }

    /// Bytes from the host.
    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        let room = LONGEST_MESSAGE.saturating_sub(self.input.len());
        self.input.extend_from_slice(&bytes[..bytes.len().min(room)]);
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
            let parameters = parameters.split(',').map(|p| p.trim().to_owned());
            let parameters = parameters.filter(|p| !p.is_empty()).collect();
            self.units.push_back(Unit { header, query, parameters });
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
            ("*ESR", true) => {
                let status = std::mem::take(&mut self.event_status);
                self.respond(status.to_string().as_bytes());
            }
            (header, true) if matches("SYSTem:ERRor", header).is_some() => {
                let (number, text) = self.errors.pop_front().unwrap_or((0, "No error"));
                self.respond(format!("{number:+},\"{text}\"").as_bytes());
            }
            _ => return false,
        }
        true
    }
}
