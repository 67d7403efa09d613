//! SCPI over a byte line (IEEE 488.2, SCPI-1999): runs a script of commands and queries step by step, without blocking.
//!
//! A line feed ends a message in both directions, as on the raw socket of LXI instruments (TCP port 5025).
//!
//! After every step the instrument's error queue is read with `SYST:ERR?` until it is empty. A step that the instrument
//! refuses becomes an error in the instrument's own words.
//!
//! No step is sent while the answer to a query is outstanding: that would interrupt the query (IEEE 488.2, 6.3.2.3: −410,
//! query INTERRUPTED). Only after a timeout is the error queue read all the same, because it may say why there is no
//! answer; the −410 that this causes is ignored.

pub mod block;
mod identity;
mod instrument;
pub mod number;
mod queue;
#[cfg(test)]
pub(crate) mod tests;

use std::time::Duration;

pub use crate::answer::FormatError;
use crate::device::DeviceError;
use crate::wire::ByteLine;
pub use identity::Identity;
pub(crate) use instrument::LONGEST_TEXT as LONGEST_ANSWER;
pub use instrument::{Dialogue, Instrument};

/// Longest entry of an error queue and longest identity; IEEE 488.2 allows 255 characters for the text.
const LONGEST_TEXT: usize = 512;
/// Most entries of the error queue that are read after one step. An instrument that never runs out of errors must not hold
/// up the bench for ever.
const MOST_ERRORS: u32 = 64;
/// Bytes taken from the line at once.
const CHUNK: usize = 1024;

/// What ends an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A line feed.
    Line,
    /// The byte count in the header of a definite-length block, then a line feed.
    Block,
}

/// One message to the instrument. A value of `T` tells the caller which query an answer belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct Step<T> {
    /// Message without its line feed.
    pub text: String,
    /// What comes back; `None` for a command.
    pub answer: Option<(Form, T)>,
    /// Longest wait for the answer; commands have none and do not use it.
    pub timeout_s: f64,
}

impl<T> Step<T> {
    /// A command.
    pub fn command(text: impl Into<String>, timeout_s: f64) -> Self {
        Self { text: text.into(), answer: None, timeout_s }
    }

    /// A query that is answered with a line.
    pub fn query(text: impl Into<String>, what: T, timeout_s: f64) -> Self {
        Self { text: text.into(), answer: Some((Form::Line, what)), timeout_s }
    }

    /// A query that is answered with a block.
    pub fn block(text: impl Into<String>, what: T, timeout_s: f64) -> Self {
        Self { text: text.into(), answer: Some((Form::Block, what)), timeout_s }
    }
}

/// What a call of [`Session::poll`] came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress<T> {
    /// There is nothing to do until more bytes arrive or more time has passed.
    Waiting,
    /// The query with this `T` was answered. [`Session::answer`] holds the answer until the next call of
    /// [`Session::poll`].
    Answered(T),
    /// Every step is done.
    Done,
}

/// What is being waited for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Nothing: the script is over, or was never started.
    Resting,
    /// The time at which the next step is sent.
    Due(Duration),
    /// The answer to the query that was sent at this time.
    Answer(Duration),
    /// The entry of the error queue that was asked for at this time.
    Queue(Duration),
}

/// A script and its state. The buffers are allocated when it is made.
#[derive(Clone, Debug)]
pub struct Session<T> {
    /// Name of the instrument, for errors.
    name: String,
    script: Vec<Step<T>>,
    /// Index of the next step to send; the current step is the one before.
    next: usize,
    phase: Phase,
    /// Bytes of the current answer so far.
    answer: Vec<u8>,
    answer_limit: usize,
    /// Bytes of the current entry of the error queue so far.
    entry: Vec<u8>,
    /// Entries of the error queue that were read after the current step.
    entries_count: u32,
    /// First error after the current step: code and text.
    first_error: Option<(i32, String)>,
    /// Set if the current query was not answered in time: how long it was waited for. The error queue may say why.
    silent_s: Option<f64>,
    queue_timeout_s: f64,
}

impl<T: Copy> Session<T> {
    /// A script for the instrument `name` whose answers have at most `answer_limit` bytes; the error queue answers
    /// within `queue_timeout_s`.
    pub fn new(name: &str, script: Vec<Step<T>>, answer_limit: usize, queue_timeout_s: f64) -> Self {
        Self {
            name: name.to_owned(),
            script,
            next: 0,
            phase: Phase::Resting,
            answer: Vec::with_capacity(answer_limit + CHUNK),
            answer_limit,
            entry: Vec::with_capacity(LONGEST_TEXT + CHUNK),
            entries_count: 0,
            first_error: None,
            silent_s: None,
            queue_timeout_s,
        }
    }

    /// Starts the script at its first step. Bytes of an earlier dialogue that are left on the line are discarded.
    ///
    /// # Errors
    /// When the line is gone.
    pub fn start(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        let mut rest = [0; CHUNK];
        while line.read(now, &mut rest)? > 0 {}
        (self.next, self.phase) = (0, Phase::Due(now));
        (self.entries_count, self.first_error, self.silent_s) = (0, None, None);
        Ok(())
    }

    /// Whether a script is under way.
    pub fn is_running(&self) -> bool {
        self.phase != Phase::Resting
    }

    /// Ends the script and sends `text`, without waiting for an effect and without reading the error queue.
    ///
    /// # Errors
    /// When the line is gone.
    pub fn abort(&mut self, line: &mut dyn ByteLine, now: Duration, text: &str) -> Result<(), DeviceError> {
        self.phase = Phase::Resting;
        line.write(now, text.as_bytes())?;
        line.write(now, b"\n")
    }

    /// Sends the last step once more, not before the time `at`: a query that is polled.
    pub fn again(&mut self, at: Duration) {
        if self.next > 0 {
            (self.next, self.phase) = (self.next - 1, Phase::Due(at));
        }
    }

    /// The newest answer: a line without its end, or the content of a block.
    pub fn answer(&self) -> &[u8] {
        match block::read(&self.answer) {
            Ok(Some(block)) if self.answer.len() >= block.end() => &self.answer[block.start..block.end()],
            _ => number::trimmed(&self.answer),
        }
    }

    /// Text of the step that was answered last, for errors.
    pub fn asked(&self) -> &str {
        self.script.get(self.next.saturating_sub(1)).map_or("", |step| step.text.as_str())
    }

    /// An answer that cannot be used, as an error of this instrument.
    pub fn unusable(&self, source: FormatError) -> DeviceError {
        DeviceError::Answer { device: self.name.clone(), command: self.asked().to_owned(), source }
    }

    /// Advances the script as far as possible without blocking.
    ///
    /// # Errors
    /// If the line is gone, or the instrument does not answer in time, answers in another form, or reports an error of its
    /// own. The script is then over.
    pub fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Progress<T>, DeviceError> {
        let progress = self.go_on(line, now);
        if progress.is_err() {
            self.phase = Phase::Resting;
        }
        progress
    }

    fn go_on(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Progress<T>, DeviceError> {
        loop {
            match self.phase {
                Phase::Resting => return Ok(Progress::Done),
                Phase::Due(at) if now < at => return Ok(Progress::Waiting),
                Phase::Due(_) => self.send(line, now)?,
                Phase::Answer(since) => {
                    if !self.answer_is_whole(line, now, since)? {
                        return Ok(Progress::Waiting);
                    }
                    self.ask_queue(line, now)?;
                }
                Phase::Queue(since) => {
                    if !self.entry_is_whole(line, now, since)? {
                        return Ok(Progress::Waiting);
                    }
                    if let Some(what) = self.take_entry(line, now)? {
                        return Ok(Progress::Answered(what));
                    }
                }
            }
        }
    }

    /// Sends the next step, or finds that there is none.
    fn send(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        let Some(step) = self.script.get(self.next) else {
            self.phase = Phase::Resting;
            return Ok(());
        };
        line.write(now, step.text.as_bytes())?;
        line.write(now, b"\n")?;
        self.next += 1;
        self.answer.clear();
        (self.entries_count, self.first_error, self.silent_s) = (0, None, None);
        self.phase = Phase::Answer(now);
        if step.answer.is_none() { self.ask_queue(line, now) } else { Ok(()) }
    }

    /// Asks for the oldest entry of the error queue.
    fn ask_queue(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        self.entry.clear();
        self.phase = Phase::Queue(now);
        line.write(now, b":SYST:ERR?\n")
    }

    /// Takes bytes of the answer. `true` if nothing more is to be waited for: the answer is complete, or it is overdue, and
    /// then `silent_s` is set.
    fn answer_is_whole(
        &mut self,
        line: &mut dyn ByteLine,
        now: Duration,
        since: Duration,
    ) -> Result<bool, DeviceError> {
        let limit = self.answer_limit;
        fill(line, now, &mut self.answer, limit).map_err(|e| e.of(&self.name, self.asked()))?;
        let Some((form, timeout_s)) = self.current() else { return Ok(true) };
        let whole = match form {
            Form::Line => number::line_is_whole(&self.answer),
            Form::Block => block::is_whole(&self.answer, limit),
        };
        if whole.map_err(|source| self.unusable(source))? {
            return Ok(true);
        }
        let waited_s = now.saturating_sub(since).as_secs_f64();
        if waited_s <= timeout_s {
            return Ok(false);
        }
        if let Some(truncated) = block::truncation(&self.answer) {
            return Err(self.unusable(truncated));
        }
        // An instrument does not answer a query that it refused. The error queue tells the reason, so it is read first.
        self.silent_s = Some(waited_s);
        Ok(true)
    }

    /// Form and timeout, s, of the answer to the current step; `None` for a command.
    fn current(&self) -> Option<(Form, f64)> {
        let step = self.script.get(self.next.checked_sub(1)?)?;
        step.answer.map(|(form, _)| (form, step.timeout_s))
    }

    /// Takes bytes of an entry of the error queue. `true` if the entry is complete.
    fn entry_is_whole(
        &mut self,
        line: &mut dyn ByteLine,
        now: Duration,
        since: Duration,
    ) -> Result<bool, DeviceError> {
        fill(line, now, &mut self.entry, LONGEST_TEXT).map_err(|e| e.of(&self.name, queue::QUERY))?;
        if number::line_is_whole(&self.entry).map_err(|source| self.bad_entry(source))? {
            return Ok(true);
        }
        let waited_s = now.saturating_sub(since).as_secs_f64();
        if waited_s <= self.queue_timeout_s {
            return Ok(false);
        }
        Err(self.silence(self.silent_s.unwrap_or(waited_s)))
    }

    /// Takes an entry of the error queue. If the queue is empty, the step is over: returns what its query asked for, and
    /// `None` for a command.
    fn take_entry(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<T>, DeviceError> {
        let entry = queue::entry(number::trimmed(&self.entry)).map_err(|source| self.bad_entry(source))?;
        if let Some((code, text)) = entry {
            self.entries_count += 1;
            // After a timeout, asking for errors interrupts the query itself. That −410 is not why there was no answer.
            if self.silent_s.is_none() || code != queue::INTERRUPTED {
                self.first_error.get_or_insert((code, text));
            }
            if self.entries_count < MOST_ERRORS {
                self.ask_queue(line, now)?;
                return Ok(None);
            }
        }
        if let Some((code, message)) = self.first_error.take() {
            let device = self.name.clone();
            let command = self.asked().to_owned();
            return Err(DeviceError::Instrument { device, command, code, message });
        }
        if let Some(waited_s) = self.silent_s {
            return Err(self.silence(waited_s));
        }
        self.phase = Phase::Due(now);
        Ok(self.script[self.next - 1].answer.map(|(_, what)| what))
    }

    fn bad_entry(&self, source: FormatError) -> DeviceError {
        DeviceError::Answer { device: self.name.clone(), command: queue::QUERY.to_owned(), source }
    }

    fn silence(&self, waited_s: f64) -> DeviceError {
        let bytes = self.answer.len();
        DeviceError::Field {
            device: self.name.clone(),
            field: "answer",
            expected: format!("a whole one to {}", self.asked()),
            found: format!("none within {waited_s:.3} s, {bytes} bytes so far"),
            help: "check power, address and cable of the instrument",
        }
    }
}

/// Why [`fill`] failed.
enum Unfilled {
    Wire(DeviceError),
    TooLong(usize),
}

impl Unfilled {
    fn of(self, device: &str, command: &str) -> DeviceError {
        match self {
            Self::Wire(error) => error,
            Self::TooLong(limit) => DeviceError::Answer {
                device: device.to_owned(),
                command: command.to_owned(),
                source: FormatError::TooLong { limit },
            },
        }
    }
}

/// Appends all bytes that have arrived. More than `limit` in all are an error, so that the buffer never grows.
fn fill(line: &mut dyn ByteLine, now: Duration, into: &mut Vec<u8>, limit: usize) -> Result<(), Unfilled> {
    let mut chunk = [0; CHUNK];
    loop {
        let count = line.read(now, &mut chunk).map_err(Unfilled::Wire)?;
        if count == 0 {
            return Ok(());
        }
        if into.len() + count > limit {
            return Err(Unfilled::TooLong(limit));
        }
        into.extend_from_slice(&chunk[..count]);
    }
}
