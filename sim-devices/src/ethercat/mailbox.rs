//! Mailbox of a SubDevice (ETG.1000.4, 5.6): one message each way at a time, and those that wait to be sent.

use std::collections::VecDeque;
use std::time::Duration;

use super::application::{Application, Emergency};
use super::coe::{EMERGENCY, SdoServer};
use super::esc::Esc;

/// Sync manager that the MainDevice writes.
const RECEIVE: usize = 0;
/// Sync manager that the MainDevice reads.
const SEND: usize = 1;
/// Length, address, channel and priority, type and counter.
const HEADER_BYTES: usize = 6;
/// Message type: error.
const TYPE_ERROR: u8 = 0;
/// Message type: CANopen over EtherCAT.
const TYPE_COE: u8 = 3;
/// Mailbox error: the protocol is not supported.
const UNSUPPORTED_PROTOCOL: u16 = 0x0002;
/// Mailbox error: the stated length is not that of the message.
const INVALID_SIZE: u16 = 0x0008;
/// Messages that may wait; a device that sends more emergencies than anybody reads forgets the oldest.
const QUEUE: usize = 16;

/// A message that waits to be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Message {
    /// Of whoever asked, behind a gateway; 0 for messages that nobody asked for.
    address: [u8; 2],
    kind: u8,
    counter: u8,
    body: Vec<u8>,
    /// Not before this instant.
    due: Duration,
}

/// To whom a message goes, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Reply {
    address: [u8; 2],
    counter: u8,
    due: Duration,
}

impl Reply {
    fn message(self, kind: u8, body: Vec<u8>) -> Message {
        let Self { address, counter, due } = self;
        Message { address, kind, counter, body, due }
    }
}

/// The mailbox.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mailbox {
    pub(crate) sdo: SdoServer,
    waiting: VecDeque<Message>,
    /// The message in the mailbox, or read from it last.
    last_sent: Option<Message>,
    /// Counter of the last request, 0 if it had none.
    last_counter: u8,
    /// Counter of the messages that nobody asked for.
    counter: u8,
    /// Time that it takes to answer.
    pub(crate) answers_after: Duration,
    /// Takes requests and never answers.
    pub(crate) is_mute: bool,
}

impl Mailbox {
    /// The mailbox was switched on or off.
    pub(crate) fn reset(&mut self) {
        self.sdo.reset();
        self.waiting.clear();
        self.last_sent = None;
        self.last_counter = 0;
    }

    /// Serves what has come, and sends what is due.
    pub(crate) fn serve(&mut self, esc: &mut Esc, application: &mut dyn Application, now: Duration) {
        let Some(length) = esc.configuration(SEND).map(|c| usize::from(c.length)) else { return };
        let room = length.saturating_sub(HEADER_BYTES);
        let request = esc.sync_manager(RECEIVE).device_takes().map(<[u8]>::to_vec);
        if let Some(request) = request.filter(|_| !self.is_mute) {
            self.answer(application, &request, room, now);
        }
        if let Some(emergency) = application.emergency() {
            self.send_emergency(emergency, now);
        }
        if esc.take_repeat_request(SEND)
            && let Some(message) = self.last_sent.take()
        {
            esc.sync_manager(SEND).empty();
            self.waiting.push_front(message);
        }
        self.send(esc, now);
    }

    fn answer(&mut self, application: &mut dyn Application, request: &[u8], room: usize, now: Duration) {
        let due = now.saturating_add(self.answers_after);
        // A mailbox that holds no header is no mailbox.
        let Some(&kind_and_counter) = request.get(5) else { return };
        let counter = kind_and_counter >> 4 & 7;
        let before = std::mem::replace(&mut self.last_counter, counter);
        if counter != 0 && counter == before {
            // The same message once more: the MainDevice did not see that the first one had arrived.
            return;
        }
        let reply = Reply { address: [request[2], request[3]], counter, due };
        let length = usize::from(u16::from_le_bytes([request[0], request[1]]));
        let Some(body) = request.get(HEADER_BYTES..HEADER_BYTES + length) else {
            return self.refuse(INVALID_SIZE, reply);
        };
        match kind_and_counter & 0x0F {
            TYPE_COE => match self.sdo.answer(application, body, room) {
                Ok(answers) => {
                    answers.into_iter().for_each(|body| self.push(reply.message(TYPE_COE, body)));
                }
                Err(detail) => self.refuse(detail, reply),
            },
            _ => self.refuse(UNSUPPORTED_PROTOCOL, reply),
        }
    }

    fn refuse(&mut self, detail: u16, reply: Reply) {
        let [low, high] = detail.to_le_bytes();
        let body = vec![1, 0, low, high];
        self.push(reply.message(TYPE_ERROR, body));
    }

    /// An emergency message goes out as soon as the mailbox is empty.
    pub(crate) fn send_emergency(&mut self, emergency: Emergency, now: Duration) {
        let [low, high] = emergency.code.to_le_bytes();
        let mut body = vec![0, EMERGENCY << 4, low, high, emergency.register];
        body.extend(emergency.vendor);
        self.counter = self.counter % 7 + 1;
        let reply = Reply { address: [0; 2], counter: self.counter, due: now };
        self.push(reply.message(TYPE_COE, body));
    }

    fn push(&mut self, message: Message) {
        if self.waiting.len() == QUEUE {
            self.waiting.pop_front();
        }
        self.waiting.push_back(message);
    }

    fn send(&mut self, esc: &mut Esc, now: Duration) {
        if esc.sync_manager(SEND).is_full() || self.waiting.front().is_none_or(|message| message.due > now) {
            return;
        }
        let Some(message) = self.waiting.pop_front() else { return };
        let length = (message.body.len() as u16).to_le_bytes();
        let kind = message.kind | message.counter << 4;
        let header = [length[0], length[1], message.address[0], message.address[1], 0, kind];
        esc.sync_manager(SEND).device_writes(|bytes| {
            bytes.fill(0);
            for (byte, value) in bytes.iter_mut().zip(header.iter().chain(&message.body)) {
                *byte = *value;
            }
        });
        self.last_sent = Some(message);
    }
}
