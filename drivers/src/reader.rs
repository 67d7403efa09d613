//! Instruments that send their readings as lines of text, described by a profile instead of code: autocollimators and force
//! gauges.
//!
//! A profile says how a reading is asked for, or that the instrument sends by itself, how its line looks, and what its numbers
//! are worth. The driver never asks again before the answer came or is overdue. After an overdue answer it listens for as long
//! again and throws away what comes, so that a late answer is not taken for the next one.

mod pattern;
mod profile;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::Duration;

pub use pattern::{Pattern, PatternError, Shown};
pub use profile::{Measured, ReaderProfile, Readings, Terminator, ValueScale};

use crate::device::DeviceError;
use crate::wire::ByteLine;

/// Longest line that is looked at.
const LONGEST_LINE: usize = 256;
/// Bytes taken from the line at once.
const CHUNK: usize = 256;
/// A reader that has sent nothing useful for this long is an error (docs/safety.md: instrument query).
const SILENCE_LIMIT: Duration = Duration::from_secs(5);
/// Characters that errors show of a line.
const SHOWN_CHARS: usize = 40;

/// What has come over the line of a reader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Lines that the profile understands.
    pub readings: u64,
    /// Lines that it does not understand, that are too long, or that nobody asked for.
    pub rejected_lines: u64,
    /// Queries that were not answered in time.
    pub timeouts: u64,
    /// Values outside the range of the profile.
    pub out_of_range: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// The next query is sent at this time; a reader that sends by itself stays here.
    Due(Duration),
    /// Asked at this time.
    Asked(Duration),
    /// An answer was overdue: what comes until this time belongs to it.
    Quiet(Duration),
}

/// How far the opening has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Opening {
    Identity,
    /// The first reading, waited for since this time.
    First(Duration),
    Done,
}

/// A reader behind its line.
#[derive(Clone, Debug)]
pub struct Reader {
    name: String,
    profile: Arc<ReaderProfile>,
    opening: Option<Opening>,
    identity: Option<String>,
    phase: Phase,
    /// Bytes of the line under way, and whether it is too long.
    line: Vec<u8>,
    is_too_long: bool,
    /// The line in the buffer has ended; the next byte begins another one.
    begins_anew: bool,
    last: Readings,
    read_at: Option<Duration>,
    /// Since when nothing useful has come.
    silent_since: Duration,
    counts: Counts,
    /// The newest line that was not understood, for errors.
    rejected: Vec<u8>,
}

/// A whole line that has arrived.
enum Heard {
    Line,
    TooLong,
}

impl Reader {
    /// A driver that has not spoken to its instrument yet. The profile was checked when it was read.
    pub fn new(name: &str, profile: Arc<ReaderProfile>) -> Self {
        Self {
            name: name.to_owned(),
            profile,
            opening: None,
            identity: None,
            phase: Phase::Due(Duration::ZERO),
            line: Vec::with_capacity(LONGEST_LINE),
            is_too_long: false,
            begins_anew: true,
            last: Readings::default(),
            read_at: None,
            silent_since: Duration::ZERO,
            counts: Counts::default(),
            rejected: Vec::with_capacity(LONGEST_LINE),
        }
    }

    /// Goes on with the opening: asks who the instrument is, where the profile has a query for that, and waits for the first
    /// reading. `true` once that is done.
    ///
    /// # Errors
    /// When the line is gone, nothing comes in time, or what comes is not what the profile describes.
    pub fn open(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<bool, DeviceError> {
        loop {
            match self.opening {
                None => {
                    self.discard(line, now)?;
                    self.opening = Some(match self.profile.identify {
                        Some(_) => Opening::Identity,
                        None => Opening::First(now),
                    });
                    self.phase = Phase::Due(now);
                }
                Some(Opening::Identity) => {
                    let Some(identity) = self.ask_identity(line, now)? else { return Ok(false) };
                    self.identity = Some(identity);
                    (self.opening, self.phase) = (Some(Opening::First(now)), Phase::Due(now));
                }
                Some(Opening::First(since)) => {
                    if self.poll(line, now)? {
                        self.opening = Some(Opening::Done);
                        return Ok(true);
                    }
                    let waited_s = now.saturating_sub(since).as_secs_f64();
                    if waited_s > self.profile.stale_s() + self.profile.timeout_s {
                        return Err(self.no_reading(waited_s));
                    }
                    return Ok(false);
                }
                Some(Opening::Done) => return Ok(true),
            }
        }
    }

    fn ask_identity(
        &mut self,
        line: &mut dyn ByteLine,
        now: Duration,
    ) -> Result<Option<String>, DeviceError> {
        if let Phase::Due(_) = self.phase {
            self.send(line, now, |profile| profile.identify.as_deref())?;
        }
        if let Some(Heard::Line) = self.hear(line, now)? {
            return Ok(Some(String::from_utf8_lossy(self.line.trim_ascii()).into_owned()));
        }
        match self.phase {
            Phase::Asked(at) if now.saturating_sub(at).as_secs_f64() > self.profile.timeout_s => {
                let reason = format!(
                    "`{}`: no answer within {} s; check power, address, bit rate and terminator of the instrument",
                    self.profile.identify.as_deref().unwrap_or_default(),
                    self.profile.timeout_s
                );
                Err(DeviceError::Bus { device: self.name.clone(), reason })
            }
            _ => Ok(None),
        }
    }

    /// Takes what has arrived up to `now` and asks for the next reading when it is due; `true` if a reading was new. Call once
    /// per tick. Allocates nothing unless it fails.
    ///
    /// # Errors
    /// When the line is gone, or nothing useful has come for 5 s.
    pub fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<bool, DeviceError> {
        let mut is_new = false;
        while let Some(heard) = self.hear(line, now)? {
            is_new |= self.take(&heard, now);
        }
        match self.phase {
            Phase::Due(at) if now >= at && self.profile.query.is_some() => {
                self.send(line, now, |profile| profile.query.as_deref())?;
            }
            Phase::Asked(at) if now.saturating_sub(at).as_secs_f64() > self.profile.timeout_s => {
                self.counts.timeouts += 1;
                self.line.clear();
                self.phase = Phase::Quiet(now + Duration::from_secs_f64(self.profile.timeout_s));
            }
            Phase::Quiet(until) if now >= until => {
                self.line.clear();
                self.phase = Phase::Due(now);
            }
            _ => {}
        }
        if is_new {
            self.silent_since = now;
        } else if self.opening == Some(Opening::Done) && now.saturating_sub(self.silent_since) > SILENCE_LIMIT
        {
            return Err(self.no_reading(now.saturating_sub(self.silent_since).as_secs_f64()));
        }
        Ok(is_new)
    }

    /// Sends a query of the profile, if it has one.
    fn send(
        &mut self,
        line: &mut dyn ByteLine,
        now: Duration,
        query: fn(&ReaderProfile) -> Option<&str>,
    ) -> Result<(), DeviceError> {
        let Some(query) = query(&self.profile) else { return Ok(()) };
        line.write(now, query.as_bytes())?;
        line.write(now, self.profile.terminator.bytes())?;
        self.phase = Phase::Asked(now);
        Ok(())
    }

    /// Bytes of an earlier dialogue are left where they belong.
    fn discard(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        let mut bytes = [0; CHUNK];
        while line.read(now, &mut bytes)? > 0 {}
        Ok(())
    }

    /// The next whole line, one byte after another so that what follows it stays on the wire.
    fn hear(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<Heard>, DeviceError> {
        let end = self.profile.terminator.last();
        let mut byte = [0];
        while line.read(now, &mut byte)? > 0 {
            if byte[0] == end {
                // The line stays in the buffer until the next one begins.
                let was_too_long = std::mem::take(&mut self.is_too_long);
                self.begins_anew = true;
                return Ok(Some(if was_too_long { Heard::TooLong } else { Heard::Line }));
            }
            if std::mem::take(&mut self.begins_anew) {
                self.line.clear();
            }
            match self.line.len() < LONGEST_LINE {
                true => self.line.push(byte[0]),
                false => self.is_too_long = true,
            }
        }
        Ok(None)
    }

    /// Takes the line that is in the buffer; whether it was a reading.
    fn take(&mut self, heard: &Heard, now: Duration) -> bool {
        let is_expected = match self.phase {
            Phase::Asked(_) => true,
            Phase::Due(_) => self.profile.query.is_none(),
            Phase::Quiet(_) => false,
        };
        let shown = match heard {
            Heard::Line if is_expected => self.profile.pattern.decode(&self.line, &self.profile.nothing),
            _ => None,
        };
        if let (Phase::Asked(at), Some(_)) = (self.phase, self.profile.query.as_ref()) {
            let due = at + Duration::from_secs_f64(self.profile.period_s);
            self.phase = Phase::Due(due.max(now));
        }
        let Some(shown) = shown else {
            self.counts.rejected_lines += 1;
            self.rejected.clear();
            self.rejected.extend_from_slice(&self.line);
            return false;
        };
        let (readings, out_of_range) = self.profile.scaled(&shown);
        self.counts.readings += 1;
        self.counts.out_of_range += out_of_range;
        (self.last, self.read_at) = (readings, Some(now));
        true
    }

    /// The newest reading where it is not older than the profile allows; a value is `None` where the instrument shows none or one
    /// outside its range.
    pub fn readings(&self, now: Duration) -> Readings {
        let age_s = self.read_at.map(|at| now.saturating_sub(at).as_secs_f64());
        if age_s.is_some_and(|age_s| age_s <= self.profile.stale_s()) {
            self.last
        } else {
            Readings::default()
        }
    }

    /// What the instrument said it is; `None` where the profile has no query for that.
    pub fn identity(&self) -> Option<&str> {
        self.identity.as_deref()
    }

    /// The profile.
    pub fn profile(&self) -> &ReaderProfile {
        &self.profile
    }

    /// What has come over the line so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    fn no_reading(&self, waited_s: f64) -> DeviceError {
        let found = match (self.counts.rejected_lines, self.rejected.is_empty()) {
            (0, _) => format!("nothing within {waited_s:.3} s"),
            (_, true) => format!("an empty line, no other within {waited_s:.3} s"),
            (count, false) => {
                let line = String::from_utf8_lossy(self.rejected.trim_ascii());
                let shown: String = line.chars().take(SHOWN_CHARS).collect();
                format!("{count} other lines, the last one `{}`", shown.escape_debug())
            }
        };
        DeviceError::Field {
            device: self.name.clone(),
            field: "reading",
            expected: format!("a line like `{}` (profile `{}`)", self.profile.pattern, self.profile.id),
            found,
            help: "check power, cable, address and bit rate of the instrument, and query, terminator and pattern of the profile",
        }
    }
}
