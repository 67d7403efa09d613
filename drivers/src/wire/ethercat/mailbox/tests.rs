use super::*;
use proptest::prelude::*;

const AREA: MailArea =
    MailArea { address: 0x1001, write_at: 0x1000, write_bytes: 64, read_at: 0x1080, read_bytes: 64 };
const SERIAL: Place = Place { index: 0x1018, sub: 4 };

/// A station with one object, played by hand: bytes in, bytes out.
#[derive(Default)]
struct Station {
    /// The message that waits to be read.
    waiting: Option<Vec<u8>>,
    /// The message that was read last, for a repeat.
    last: Vec<u8>,
    repeat: u8,
    counters: Vec<u8>,
    commands: Vec<u8>,
    is_mute: bool,
}

impl Station {
    fn pass(&mut self, pdu: MailPdu, outgoing: &[u8]) -> Option<Vec<u8>> {
        let status = if self.waiting.is_some() { FULL } else { 0 };
        match pdu.action {
            MailAction::Status => Some(vec![status]),
            MailAction::RepeatStatus => Some(vec![status, 1 | self.repeat, self.repeat]),
            MailAction::Repeat { activation } => {
                self.repeat = activation & REPEAT;
                self.waiting = Some(self.last.clone());
                Some(Vec::new())
            }
            MailAction::Read => {
                self.last = self.waiting.take()?;
                Some(self.last.clone())
            }
            MailAction::Write | MailAction::WriteAbort => {
                self.take(outgoing);
                Some(Vec::new())
            }
        }
    }

    fn take(&mut self, message: &[u8]) {
        let counter = coe::counter(message);
        if self.counters.last() == Some(&counter) {
            return;
        }
        self.counters.push(counter);
        self.commands.push(message[8]);
        if !self.is_mute && message[8] == 0x40 {
            self.waiting = Some(upload(&message[9..12], &[0x78, 0x56, 0x34, 0x12]));
        }
    }
}

/// An answer to an upload.
fn upload(place: &[u8], data: &[u8; 4]) -> Vec<u8> {
    let mut bytes = vec![10, 0, 0, 0, 0, 0x13, 0, 0x30, 0x43];
    bytes.extend(place);
    bytes.extend(data);
    bytes.resize(64, 0);
    bytes
}

fn emergency(code: u16) -> Vec<u8> {
    let mut bytes = vec![10, 0, 0, 0, 0, 0x13, 0, 0x10];
    bytes.extend(code.to_le_bytes());
    bytes.extend([0x20, 1, 2, 3, 4, 5]);
    bytes.resize(64, 0);
    bytes
}

/// Mailboxes of one station and what passes between, one datagram per 250 µs.
struct Wire {
    mailboxes: Mailboxes,
    station: Station,
    now: Duration,
    /// Datagrams by number: those that do not arrive, and those whose reply does not.
    lost: Vec<usize>,
    lost_replies: Vec<usize>,
    passed_count: usize,
}

impl Wire {
    fn new() -> Self {
        let mailboxes = Mailboxes::new([(1, Some(AREA)), (2, None)]);
        let now = Duration::from_millis(1);
        Self {
            mailboxes,
            station: Station::default(),
            now,
            lost: Vec::new(),
            lost_replies: Vec::new(),
            passed_count: 0,
        }
    }

    fn pass(&mut self) {
        self.now += Duration::from_micros(250);
        let Some(pdu) = self.mailboxes.next(self.now) else { return };
        let number = self.passed_count;
        self.passed_count += 1;
        if self.lost.contains(&number) {
            return self.mailboxes.done(self.now, pdu, Reply::Lost);
        }
        let answer = self.station.pass(pdu, self.mailboxes.outgoing());
        let reply = match &answer {
            _ if self.lost_replies.contains(&number) => Reply::Lost,
            None => Reply::Refused,
            Some(bytes) => Reply::Done(bytes),
        };
        self.mailboxes.done(self.now, pdu, reply);
    }

    fn transfer(&mut self) -> Option<Result<Vec<u8>, SdoAbort>> {
        self.mailboxes.start(self.now, Some(0), SERIAL, None);
        (0..1000).find_map(|_| {
            self.pass();
            let outcome = self.mailboxes.take_outcome(self.now);
            outcome.map(|read| read.map(<[u8]>::to_vec))
        })
    }
}

const SERIAL_BYTES: [u8; 4] = [0x78, 0x56, 0x34, 0x12];

#[test]
fn an_object_takes_three_datagrams() {
    let mut wire = Wire::new();
    assert_eq!(wire.transfer(), Some(Ok(SERIAL_BYTES.to_vec())));
    assert_eq!(wire.passed_count, 3, "write, status, read");
    assert_eq!(wire.mailboxes.take_outcome(wire.now), None, "told once");
    assert_eq!(wire.transfer(), Some(Ok(SERIAL_BYTES.to_vec())));
    assert_eq!(wire.station.counters, [1, 2]);
}

#[test]
fn no_lost_datagram_or_reply_ends_a_transfer() {
    for number in 0..6 {
        for replies in [false, true] {
            let mut wire = Wire::new();
            let lost = if replies { &mut wire.lost_replies } else { &mut wire.lost };
            lost.push(number);
            assert_eq!(wire.transfer(), Some(Ok(SERIAL_BYTES.to_vec())), "{number}, {replies}");
            assert_eq!(wire.station.commands, [0x40], "asked once");
        }
    }
}

#[test]
fn a_mute_station_times_out_and_is_told() {
    let mut wire = Wire::new();
    wire.station.is_mute = true;
    let begun = wire.now;
    assert_eq!(wire.transfer(), Some(Err(TIMED_OUT)));
    assert!(wire.now - begun > TIMEOUT && wire.now - begun < TIMEOUT + Duration::from_millis(1));
    wire.station.is_mute = false;
    assert_eq!(wire.transfer(), Some(Ok(SERIAL_BYTES.to_vec())));
    assert_eq!(wire.station.commands, [0x40, 0x80, 0x40]);
    assert_eq!(wire.station.counters, [1, 2, 3]);
}

#[test]
fn emergencies_are_kept_with_or_without_a_transfer() {
    let mut wire = Wire::new();
    wire.station.waiting = Some(emergency(0x7320));
    for _ in 0..50 {
        wire.pass();
    }
    let seen = wire.mailboxes.emergencies.pop().expect("looked every 10 ms");
    assert_eq!((seen.station, seen.code, seen.register, seen.vendor), (1, 0x7320, 0x20, [1, 2, 3, 4, 5]));
    wire.mailboxes.start(wire.now, Some(0), SERIAL, None);
    wire.station.is_mute = true;
    wire.pass();
    wire.station.waiting = Some(emergency(0x2310));
    wire.pass();
    wire.pass();
    assert_eq!(wire.mailboxes.emergencies.pop().map(|seen| seen.code), Some(0x2310));
    wire.station.waiting = Some(upload(&[0x18, 0x10, 4], &SERIAL_BYTES));
    wire.pass();
    wire.pass();
    assert_eq!(wire.mailboxes.take_outcome(wire.now), Some(Ok(&SERIAL_BYTES[..])));
}

#[test]
fn more_emergencies_than_there_is_room_for_lose_the_oldest() {
    let mut wire = Wire::new();
    for code in 0..super::super::emergency::MOST as u16 + 3 {
        wire.mailboxes.read(wire.now, 0, Reply::Done(&emergency(code)));
    }
    assert_eq!(wire.mailboxes.emergencies.lost_count(), 3);
    assert_eq!(wire.mailboxes.emergencies.pop().map(|seen| seen.code), Some(3));
}

#[test]
fn a_late_answer_is_not_taken_for_the_next_transfers() {
    let mut wire = Wire::new();
    wire.station.is_mute = true;
    wire.station.waiting = Some(upload(&[0x18, 0x10, 1], &[1, 1, 1, 1]));
    wire.mailboxes.start(wire.now, Some(0), SERIAL, None);
    for _ in 0..4 {
        wire.pass();
    }
    assert_eq!(wire.mailboxes.take_outcome(wire.now), None);
    assert_eq!(wire.mailboxes.unread_count, 1);
    wire.station.waiting = Some(upload(&[0x18, 0x10, 4], &SERIAL_BYTES));
    for _ in 0..4 {
        wire.pass();
    }
    assert_eq!(wire.mailboxes.take_outcome(wire.now), Some(Ok(&SERIAL_BYTES[..])));
}

#[test]
fn stations_without_mailbox_are_told_apart() {
    let mut wire = Wire::new();
    for station in [None, Some(1), Some(7)] {
        wire.mailboxes.start(wire.now, station, SERIAL, None);
        assert_eq!(wire.mailboxes.take_outcome(wire.now), Some(Err(TIMED_OUT)));
    }
    let short = MailArea { write_bytes: 12, ..AREA };
    let mut mailboxes = Mailboxes::new([(1, Some(short))]);
    mailboxes.start(Duration::ZERO, Some(0), SERIAL, None);
    assert_eq!(mailboxes.take_outcome(Duration::ZERO), Some(Err(COMMAND)));
}

#[test]
fn a_mailbox_error_ends_the_transfer() {
    let mut wire = Wire::new();
    wire.station.is_mute = true;
    wire.station.waiting = Some(vec![4, 0, 0, 0, 0, 0x10, 1, 0, 2, 0]);
    assert_eq!(wire.transfer(), Some(Err(COMMAND)));
}

proptest! {
    #[test]
    fn arbitrary_replies_never_panic(replies in prop::collection::vec((0_u8..3, prop::collection::vec(any::<u8>(), 0..70)), 0..60)) {
        let mut mailboxes = Mailboxes::new([(1, Some(AREA)), (2, None), (3, Some(AREA))]);
        mailboxes.start(Duration::ZERO, Some(2), SERIAL, Some(&[3; 200]));
        let mut now = Duration::ZERO;
        for (kind, bytes) in &replies {
            now += Duration::from_millis(3);
            if let Some(pdu) = mailboxes.next(now) {
                let reply = match kind {
                    0 => Reply::Lost,
                    1 => Reply::Refused,
                    _ => Reply::Done(bytes),
                };
                mailboxes.done(now, pdu, reply);
            }
            mailboxes.take_outcome(now);
        }
    }
}

#[test]
fn what_is_written_is_what_the_station_stores() {
    let mut wire = Wire::new();
    wire.mailboxes.start(wire.now, Some(0), SERIAL, Some(&[9; 100]));
    let mut stored = Vec::new();
    for _ in 0..50 {
        wire.now += Duration::from_micros(250);
        let Some(pdu) = wire.mailboxes.next(wire.now) else { break };
        let message = wire.mailboxes.outgoing().to_vec();
        if pdu.action == MailAction::Write {
            let length = usize::from(message[0]);
            let is_first = message[8] == 0x21;
            stored.extend_from_slice(&message[if is_first { 16 } else { 9 }..6 + length]);
            let command = if is_first { 0x60 } else { 0x20 | message[8] & 0x10 };
            wire.station.waiting =
                Some([10, 0, 0, 0, 0, 0x13, 0, 0x30, command, 0x18, 0x10, 4, 0, 0, 0, 0].to_vec());
            wire.mailboxes.done(wire.now, pdu, Reply::Done(&[]));
        } else {
            let answer = wire.station.pass(pdu, &message).unwrap_or_default();
            wire.mailboxes.done(wire.now, pdu, Reply::Done(&answer));
        }
    }
    assert_eq!(wire.mailboxes.take_outcome(wire.now), Some(Ok(&[][..])));
    assert_eq!(stored, [9; 100]);
}
