//! The serial line of the unit: character times, commands in, replies out.

use drivers::mirror::protocol::{COMMAND_LENGTH, Command, LONGEST_REPLY, TERMINATOR};

/// Bits of a character: start, eight data, stop.
const BITS_PER_CHARACTER: f64 = 10.0;
/// Bytes that wait on either side; more are lost, as in a UART without handshake.
const QUEUE: usize = 128;

/// Bytes in order.
#[derive(Clone, Debug)]
struct Queue {
    bytes: [u8; QUEUE],
    first: usize,
    length: usize,
}

impl Queue {
    const EMPTY: Self = Self { bytes: [0; QUEUE], first: 0, length: 0 };

    fn push(&mut self, byte: u8) {
        if self.length < QUEUE {
            self.bytes[(self.first + self.length) % QUEUE] = byte;
            self.length += 1;
        }
    }

    fn pop(&mut self) -> Option<u8> {
        let byte = self.bytes[self.first];
        self.length = self.length.checked_sub(1)?;
        self.first = (self.first + 1) % QUEUE;
        Some(byte)
    }
}

/// A command that came in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arrival {
    pub(super) command: Command,
    /// Share of the step that was over when its last character had come.
    pub(super) into_step: f64,
}

/// Device side of the line. One command at a time: what comes before the acknowledge of the last one is lost, a
/// command that the manual does not allow is never acknowledged.
#[derive(Clone, Debug)]
pub(super) struct SerialLine {
    characters_per_step: f64,
    incoming: Queue,
    outgoing: Queue,
    receive_clock: f64,
    send_clock: f64,
    command: [u8; *COMMAND_LENGTH.end()],
    command_length: usize,
    reply: [u8; LONGEST_REPLY],
    reply_length: usize,
    sent: usize,
    /// Steps until the reply starts.
    busy_steps: u32,
    /// A command was handed out and not yet answered.
    waiting: bool,
}

impl SerialLine {
    pub(super) fn new(bit_rate_hz: f64, step_s: f64) -> Self {
        Self {
            characters_per_step: Self::pace(bit_rate_hz, step_s),
            incoming: Queue::EMPTY,
            outgoing: Queue::EMPTY,
            receive_clock: 0.0,
            send_clock: 0.0,
            command: [0; *COMMAND_LENGTH.end()],
            command_length: 0,
            reply: [0; LONGEST_REPLY],
            reply_length: 0,
            sent: 0,
            busy_steps: 0,
            waiting: false,
        }
    }

    fn pace(bit_rate_hz: f64, step_s: f64) -> f64 {
        bit_rate_hz * step_s / BITS_PER_CHARACTER
    }

    /// Another bit rate, from the next character on.
    pub(super) fn set_bit_rate(&mut self, bit_rate_hz: f64, step_s: f64) {
        self.characters_per_step = Self::pace(bit_rate_hz, step_s);
    }

    pub(super) fn receive(&mut self, byte: u8) {
        self.incoming.push(byte);
    }

    /// What has left the line by now.
    pub(super) fn take_reply(&mut self, into: &mut [u8]) -> usize {
        let mut count = 0;
        while let Some(place) = into.get_mut(count) {
            let Some(byte) = self.outgoing.pop() else { break };
            *place = byte;
            count += 1;
        }
        count
    }

    /// Answers the command handed out last, after `busy_steps`.
    pub(super) fn answer(&mut self, reply: &[u8], busy_steps: u32) {
        let length = reply.len().min(LONGEST_REPLY);
        self.reply[..length].copy_from_slice(&reply[..length]);
        (self.reply_length, self.sent) = (length, 0);
        (self.busy_steps, self.waiting, self.send_clock) = (busy_steps, false, 0.0);
    }

    /// One step of the line; a command whose last character came in it.
    #[inline]
    pub(super) fn step(&mut self) -> Option<Arrival> {
        if self.incoming.length == 0 && self.sent == self.reply_length {
            return None;
        }
        self.send();
        self.take_in()
    }

    fn send(&mut self) {
        if self.busy_steps > 0 {
            self.busy_steps -= 1;
            return;
        }
        if self.sent == self.reply_length {
            return;
        }
        self.send_clock += self.characters_per_step;
        while self.send_clock >= 1.0 && self.sent < self.reply_length {
            self.send_clock -= 1.0;
            self.outgoing.push(self.reply[self.sent]);
            self.sent += 1;
        }
    }

    fn take_in(&mut self) -> Option<Arrival> {
        let mut arrival = None;
        if self.incoming.length == 0 {
            return None;
        }
        self.receive_clock += self.characters_per_step;
        while self.receive_clock >= 1.0 {
            let Some(byte) = self.incoming.pop() else { break };
            self.receive_clock -= 1.0;
            let busy = self.waiting || self.sent < self.reply_length;
            if !busy && let Some(command) = self.character(byte) {
                self.waiting = true;
                let into_step = 1.0 - self.receive_clock / self.characters_per_step;
                arrival = Some(Arrival { command, into_step });
            }
        }
        if self.incoming.length == 0 {
            self.receive_clock = 0.0;
        }
        arrival
    }

    /// Adds a character; at the terminator the command, if it is one.
    fn character(&mut self, byte: u8) -> Option<Command> {
        if let Some(place) = self.command.get_mut(self.command_length) {
            *place = byte;
        }
        // One beyond the longest stands for "too long", which does not decode.
        self.command_length = (self.command_length + 1).min(COMMAND_LENGTH.end() + 1);
        if byte != TERMINATOR {
            return None;
        }
        let length = std::mem::take(&mut self.command_length);
        self.command.get(..length).and_then(Command::decode)
    }
}
