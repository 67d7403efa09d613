//! The mailboxes of all stations, with at most one datagram at a time: SDO transfers, emergencies, repeats of lost replies.
//!
//! What is to be sent next comes from [`Mailboxes::next`], what became of it goes to [`Mailboxes::done`]. Both only handle
//! bytes and the time that they are given, so a test can play the station.

use std::time::Duration;

use super::super::SdoAbort;
use super::coe::{self, Message, Place, Request};
use super::counters::MailCounter;
use super::emergency::{Emergencies, Emergency};
use super::transfer::{COMMAND, Next, TIMED_OUT, Transfer};

/// Longest wait for an answer to one message (safety.md: deadlines).
const TIMEOUT: Duration = Duration::from_millis(100);
/// How long an answer is waited for before a message whose delivery is unknown is written again.
const RESEND_AFTER: Duration = Duration::from_millis(20);
/// One station's mailbox is looked into this often, whether or not something is expected.
const LOOK_EVERY: Duration = Duration::from_millis(10);
/// Sync manager status: the mailbox is full.
const FULL: u8 = 0x08;
/// Sync manager activation and PDI control: repeat request and its acknowledgement.
const REPEAT: u8 = 0x02;

/// Where a station's mailboxes lie in its memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MailArea {
    /// Configured station address.
    pub(super) address: u16,
    /// First byte and length of the mailbox that the host writes.
    pub(super) write_at: u16,
    pub(super) write_bytes: u16,
    /// First byte and length of the mailbox that the host reads.
    pub(super) read_at: u16,
    pub(super) read_bytes: u16,
}

/// A datagram for a mailbox of station `station` (counted from 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MailPdu {
    pub(super) station: usize,
    pub(super) action: MailAction,
}

/// What a datagram does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MailAction {
    /// Writes [`Mailboxes::outgoing`] into the station's mailbox.
    Write,
    /// Writes the farewell to a transfer that was given up.
    WriteAbort,
    /// Reads the status of the mailbox that the host reads.
    Status,
    /// Reads status, activation and PDI control of that mailbox.
    RepeatStatus,
    /// Writes the activation of that mailbox.
    Repeat { activation: u8 },
    /// Reads that mailbox.
    Read,
}

/// What became of a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reply<'a> {
    /// No reply: whether the station saw it is unknown.
    Lost,
    /// The station did not take part (working counter 0).
    Refused,
    /// Done; what was read.
    Done(&'a [u8]),
}

/// What is known of the mailbox that the host reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Inbox {
    Unknown,
    Full,
    /// The reply that carried a message was lost: the station may think that the message was read.
    Lost {
        since: Duration,
    },
    /// The message is to be asked for again.
    Ask {
        activation: u8,
        since: Duration,
    },
    /// The message was asked for again; the station confirms with this bit.
    Asked {
        bit: u8,
        since: Duration,
    },
}

#[derive(Clone, Copy, Debug)]
struct Station {
    area: Option<MailArea>,
    name: u16,
    inbox: Inbox,
    /// Counter of the last message, 1 to 7.
    counter: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Turn {
    Idle,
    /// The request is to be written.
    Write,
    /// The answer is waited for; a request whose delivery is unknown is written again at some time.
    Await {
        resend_at: Option<Duration>,
    },
}

/// The mailboxes of a bus.
#[derive(Debug)]
pub(super) struct Mailboxes {
    stations: Vec<Station>,
    transfer: Transfer,
    /// Station of the transfer.
    talking_to: usize,
    turn: Turn,
    /// When the present message was first due.
    since: Duration,
    outcome: Option<Result<(), SdoAbort>>,
    outgoing: Vec<u8>,
    /// Whom to tell that a transfer was given up, and why.
    farewell: Option<Farewell>,
    looked_at: Duration,
    next_look: usize,
    pub(super) emergencies: Emergencies,
    /// Messages that were neither answers nor emergencies, or damaged.
    pub(super) unread_count: u64,
}

#[derive(Clone, Copy, Debug)]
struct Farewell {
    station: usize,
    place: Place,
    abort: SdoAbort,
    counter: u8,
}

impl Mailboxes {
    /// Mailboxes of stations with these names, in position order; `None` for a station without mailbox.
    pub(super) fn new(areas: impl IntoIterator<Item = (u16, Option<MailArea>)>) -> Self {
        let stations: Vec<_> = areas
            .into_iter()
            .map(|(name, area)| Station { area, name, inbox: Inbox::Unknown, counter: 0 })
            .collect();
        Self {
            stations,
            transfer: Transfer::idle(),
            talking_to: 0,
            turn: Turn::Idle,
            since: Duration::ZERO,
            outcome: None,
            outgoing: Vec::with_capacity(usize::from(u16::MAX) + 1),
            farewell: None,
            looked_at: Duration::ZERO,
            next_look: 0,
            emergencies: Emergencies::new(),
            unread_count: 0,
        }
    }

    /// The place of a station's mailboxes.
    pub(super) fn area(&self, station: usize) -> Option<MailArea> {
        self.stations.get(station)?.area
    }

    /// All mailboxes for somebody else who writes into them; [`Mailboxes::take_back`] goes on behind him.
    pub(super) fn lend(&self) -> Vec<MailCounter> {
        let lent = self.stations.iter().enumerate().filter_map(|(station, Station { area, counter, .. })| {
            let MailArea { address, write_at, .. } = (*area)?;
            Some(MailCounter { station, address, write_at, before: *counter, last: *counter })
        });
        lent.collect()
    }

    /// Takes note of the messages that somebody else has written.
    pub(super) fn take_back(&mut self, lent: &[MailCounter]) {
        for mailbox in lent {
            if let Some(station) = self.stations.get_mut(mailbox.station) {
                station.counter = mailbox.last;
            }
        }
    }

    /// The message that a [`MailAction::Write`] or [`MailAction::WriteAbort`] writes, as long as its mailbox.
    pub(super) fn outgoing(&self) -> &[u8] {
        &self.outgoing
    }

    /// Begins a transfer; one that was under way is forgotten. Without a mailbox at `station`, it has timed out at once.
    pub(super) fn start(
        &mut self,
        now: Duration,
        station: Option<usize>,
        place: Place,
        write: Option<&[u8]>,
    ) {
        self.outcome = None;
        self.turn = Turn::Idle;
        let Some((station, area)) = station.and_then(|station| Some((station, self.area(station)?))) else {
            self.outcome = Some(Err(TIMED_OUT));
            return;
        };
        self.talking_to = station;
        self.transfer.begin(place, write, usize::from(area.write_bytes));
        self.say(now);
    }

    /// Whether a transfer is under way.
    pub(super) fn is_busy(&self) -> bool {
        self.turn != Turn::Idle
    }

    /// How the transfer that was begun last has ended, once; what was read.
    pub(super) fn take_outcome(&mut self, now: Duration) -> Option<Result<&[u8], SdoAbort>> {
        self.check_timeout(now);
        let outcome = self.outcome.take()?;
        Some(outcome.map(|()| self.transfer.data()))
    }

    /// The datagram that is to be sent at `now`, if any.
    pub(super) fn next(&mut self, now: Duration) -> Option<MailPdu> {
        self.check_timeout(now);
        self.forget_old_losses(now);
        let read = self.stations.iter().position(|station| station.inbox != Inbox::Unknown);
        if let Some(station) = read {
            let action = match self.stations[station].inbox {
                Inbox::Unknown | Inbox::Full => MailAction::Read,
                Inbox::Lost { .. } | Inbox::Asked { .. } => MailAction::RepeatStatus,
                Inbox::Ask { activation, .. } => MailAction::Repeat { activation },
            };
            return Some(MailPdu { station, action });
        }
        if let Some(station) = self.due_look(now) {
            return Some(MailPdu { station, action: MailAction::Status });
        }
        if let Some(farewell) = self.farewell {
            let request = Request::Abort { place: farewell.place, code: farewell.abort.0 };
            encode(self.area(farewell.station), farewell.counter, &request, &mut self.outgoing);
            return Some(MailPdu { station: farewell.station, action: MailAction::WriteAbort });
        }
        let action = match self.turn {
            Turn::Idle => return None,
            Turn::Await { resend_at: Some(at) } if now >= at => MailAction::Write,
            Turn::Await { .. } => MailAction::Status,
            Turn::Write => MailAction::Write,
        };
        Some(MailPdu { station: self.talking_to, action })
    }

    /// Takes note of what became of a datagram.
    pub(super) fn done(&mut self, now: Duration, pdu: MailPdu, reply: Reply<'_>) {
        match pdu.action {
            MailAction::Write => self.written(now, reply),
            MailAction::WriteAbort => {
                self.farewell = None;
                self.encode_request();
            }
            MailAction::Status => {
                if let Reply::Done(&[status, ..]) = reply
                    && status & FULL != 0
                {
                    self.stations[pdu.station].inbox = Inbox::Full;
                }
            }
            MailAction::RepeatStatus => self.repeat_status(pdu.station, reply),
            MailAction::Repeat { activation } => {
                if let (Reply::Done(_), Inbox::Ask { since, .. }) = (reply, self.stations[pdu.station].inbox)
                {
                    self.stations[pdu.station].inbox = Inbox::Asked { bit: activation & REPEAT, since };
                }
            }
            MailAction::Read => self.read(now, pdu.station, reply),
        }
    }

    fn written(&mut self, now: Duration, reply: Reply<'_>) {
        if self.turn == Turn::Idle {
            return;
        }
        self.turn = match reply {
            Reply::Done(_) => Turn::Await { resend_at: None },
            // The station has not taken the last message out yet.
            Reply::Refused => Turn::Write,
            Reply::Lost => Turn::Await { resend_at: Some(now + RESEND_AFTER) },
        };
    }

    fn repeat_status(&mut self, station: usize, reply: Reply<'_>) {
        let Reply::Done(&[status, activation, control, ..]) = reply else { return };
        let inbox = &mut self.stations[station].inbox;
        match *inbox {
            Inbox::Lost { .. } if status & FULL != 0 => *inbox = Inbox::Full,
            Inbox::Lost { since } => *inbox = Inbox::Ask { activation: activation ^ REPEAT, since },
            Inbox::Asked { bit, .. } if control & REPEAT == bit && status & FULL != 0 => *inbox = Inbox::Full,
            _ => {}
        }
    }

    fn read(&mut self, now: Duration, station: usize, reply: Reply<'_>) {
        self.stations[station].inbox = match reply {
            Reply::Lost => Inbox::Lost { since: now },
            Reply::Refused | Reply::Done(_) => Inbox::Unknown,
        };
        let Reply::Done(mailbox) = reply else { return };
        match coe::decode(mailbox) {
            Some(Message::Emergency { code, register, vendor }) => {
                let name = self.stations[station].name;
                self.emergencies.push(Emergency { station: name, code, register, vendor, at: now });
            }
            Some(Message::Sdo(answer)) if self.is_busy() && station == self.talking_to => {
                let next = self.transfer.take(&answer);
                self.follow(now, next);
            }
            Some(Message::MailboxError { .. }) if self.is_busy() && station == self.talking_to => {
                self.finish(Err(COMMAND));
            }
            _ => self.unread_count += 1,
        }
    }

    fn follow(&mut self, now: Duration, next: Next) {
        match next {
            Next::Wait => self.unread_count += 1,
            Next::Send => self.say(now),
            Next::Complete => self.finish(Ok(())),
            Next::Aborted(abort) => self.finish(Err(abort)),
            Next::Abort(abort) => self.give_up(abort),
        }
    }

    /// Makes the transfer's next message with a new counter.
    fn say(&mut self, now: Duration) {
        self.since = now;
        self.turn = Turn::Write;
        self.next_counter(self.talking_to);
        self.encode_request();
    }

    /// Writes the transfer's message again after the room was used for another.
    fn encode_request(&mut self) {
        if self.turn == Turn::Idle {
            return;
        }
        let Station { area, counter, .. } = self.stations[self.talking_to];
        let encoded = encode(area, counter, &self.transfer.request(), &mut self.outgoing);
        if encoded.is_none() {
            // A mailbox too short for any SDO.
            self.finish(Err(COMMAND));
        }
    }

    fn check_timeout(&mut self, now: Duration) {
        if self.is_busy() && now.saturating_sub(self.since) > TIMEOUT {
            self.give_up(TIMED_OUT);
        }
    }

    fn give_up(&mut self, abort: SdoAbort) {
        let station = self.talking_to;
        let counter = self.next_counter(station);
        self.farewell = Some(Farewell { station, place: self.transfer.place(), abort, counter });
        self.finish(Err(abort));
    }

    /// A counter that differs from the last message's to this station: a repeated counter says that a message is a repeat.
    fn next_counter(&mut self, station: usize) -> u8 {
        let counter = &mut self.stations[station].counter;
        *counter = *counter % 7 + 1;
        *counter
    }

    fn finish(&mut self, outcome: Result<(), SdoAbort>) {
        self.turn = Turn::Idle;
        self.outcome = Some(outcome);
    }

    /// A message that the station does not repeat is gone.
    fn forget_old_losses(&mut self, now: Duration) {
        for station in &mut self.stations {
            match station.inbox {
                Inbox::Lost { since } | Inbox::Ask { since, .. } | Inbox::Asked { since, .. }
                    if now.saturating_sub(since) > TIMEOUT =>
                {
                    station.inbox = Inbox::Unknown;
                }
                _ => {}
            }
        }
    }

    /// The station whose mailbox is to be looked into now, if it is time.
    fn due_look(&mut self, now: Duration) -> Option<usize> {
        if now.saturating_sub(self.looked_at) < LOOK_EVERY {
            return None;
        }
        self.looked_at = now;
        let count = self.stations.len();
        let due =
            (0..count).map(|k| (self.next_look + k) % count).find(|&k| self.stations[k].area.is_some())?;
        self.next_look = due + 1;
        Some(due)
    }
}

/// Writes a message, filled up to the length of its mailbox.
fn encode(area: Option<MailArea>, counter: u8, request: &Request<'_>, into: &mut Vec<u8>) -> Option<()> {
    into.clear();
    into.resize(usize::from(area?.write_bytes), 0);
    coe::encode(request, counter, into)
}

#[cfg(test)]
mod tests;
