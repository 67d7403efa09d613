//! One serial command and its reply.

use std::time::Duration;

use super::protocol::{ACKNOWLEDGE, Command, LONGEST_REPLY, PARAMETER_WORDS, ParameterSet, word_to_volts};
use crate::device::DeviceError;
use crate::wire::ByteLine;

/// What a command brought back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reply {
    /// Only the acknowledge.
    Acknowledged,
    /// Strain gauge of an axis, V.
    Feedback(usize, f64),
    /// Parameter set of an axis.
    Parameters(usize, ParameterSet),
}

/// The command in flight; there is never more than one.
#[derive(Clone, Debug)]
pub(super) struct Transaction {
    pending: Option<(Command, Duration)>,
    reply: [u8; LONGEST_REPLY],
    length: usize,
}

impl Default for Transaction {
    fn default() -> Self {
        Self { pending: None, reply: [0; LONGEST_REPLY], length: 0 }
    }
}

impl Transaction {
    pub(super) fn is_idle(&self) -> bool {
        self.pending.is_none()
    }

    /// Sends a command; only while idle. Bytes that wait are the reply to an earlier command, or noise: they are thrown away.
    pub(super) fn send(
        &mut self,
        line: &mut dyn ByteLine,
        command: Command,
        now: Duration,
    ) -> Result<(), DeviceError> {
        while line.read(now, &mut self.reply)? > 0 {}
        line.write(now, command.encode().bytes())?;
        self.pending = Some((command, now));
        self.length = 0;
        Ok(())
    }

    /// The reply, once it is complete. After an error the transaction is over, and the next command may be sent.
    pub(super) fn poll(
        &mut self,
        line: &mut dyn ByteLine,
        timeout_s: f64,
        now: Duration,
    ) -> Result<Option<Reply>, DeviceError> {
        let Some((command, since)) = self.pending else { return Ok(None) };
        let expected = command.reply_length();
        while self.length < expected {
            match line.read(now, &mut self.reply[self.length..expected])? {
                0 => break,
                count => self.length += count,
            }
        }
        if self.length < expected {
            let waited_s = now.saturating_sub(since).as_secs_f64();
            if waited_s <= timeout_s {
                return Ok(None);
            }
            self.pending = None;
            return Err(self.no_reply(line, command, waited_s));
        }
        self.pending = None;
        self.decode(line, command).map(Some)
    }

    fn decode(&self, line: &dyn ByteLine, command: Command) -> Result<Reply, DeviceError> {
        let last = self.reply[self.length - 1];
        let data = &self.reply[..self.length - 1];
        if last != ACKNOWLEDGE {
            return Err(DeviceError::Field {
                device: line.name().to_owned(),
                field: "reply",
                expected: format!("X at the end of that to {}", text_of(command)),
                found: format!("{last:02X}h"),
                help: "check the bit rate, and look for another talker on the line",
            });
        }
        let mut words = [0; PARAMETER_WORDS];
        for (word, bytes) in words.iter_mut().zip(data.as_chunks::<4>().0) {
            *word = i32::from_be_bytes(*bytes);
        }
        Ok(match command {
            Command::Feedback(axis) => Reply::Feedback(axis, word_to_volts(words[0])),
            Command::Parameters(axis) => Reply::Parameters(axis, ParameterSet::from_words(&words)),
            _ => Reply::Acknowledged,
        })
    }

    fn no_reply(&self, line: &dyn ByteLine, command: Command, waited_s: f64) -> DeviceError {
        DeviceError::Field {
            device: line.name().to_owned(),
            field: "reply",
            expected: format!("{} bytes to {}", command.reply_length(), text_of(command)),
            found: format!("{} bytes within {waited_s:.3} s", self.length),
            help: "check power, cable and bit rate of the mirror unit",
        }
    }
}

fn text_of(command: Command) -> String {
    String::from_utf8_lossy(command.encode().bytes()).into_owned()
}
