//! A record of frames and their replies: as text, taken from an interface, and played back.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::ops::Range;
use std::rc::Rc;
use std::time::Duration;

use super::stepped::Far;

/// Ethernet header; a record begins behind it.
const HEADER_BYTES: usize = 14;
/// EtherCAT header, and header of a datagram.
const ETHERCAT_BYTES: usize = 2;
const DATAGRAM_BYTES: usize = 10;
/// Shorter runs of zeros are written out.
const SHORTEST_RUN: usize = 3;

/// A frame and its reply, both from the EtherCAT header on, without padding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) sent: Vec<u8>,
    pub(super) reply: Option<Vec<u8>>,
}

impl Entry {
    /// One line: what was sent, and what the SubDevices changed in it (exclusive or), or `-` if there was no reply.
    fn line(&self) -> String {
        let change = match &self.reply {
            None => "-".to_owned(),
            Some(reply) => digits(self.sent.iter().zip(reply).map(|(sent, reply)| sent ^ reply)),
        };
        format!("{} {change}", digits(self.sent.iter().copied()))
    }

    fn parse(line: &str) -> Self {
        let (sent, change) = line.split_once(' ').expect("two fields");
        let sent = bytes(sent);
        let reply = (change != "-").then(|| {
            let change = bytes(change);
            assert_eq!(change.len(), sent.len(), "a reply is as long as its frame");
            sent.iter().zip(change).map(|(sent, change)| sent ^ change).collect()
        });
        Self { sent, reply }
    }
}

/// Hexadecimal digits; `z12.` stands for 12 bytes of zero.
fn digits(bytes: impl Iterator<Item = u8>) -> String {
    let bytes: Vec<u8> = bytes.collect();
    let mut text = String::new();
    let mut rest = &bytes[..];
    while let Some(first) = rest.first() {
        let zeros = rest.iter().take_while(|byte| **byte == 0).count();
        let (run, taken) =
            if zeros >= SHORTEST_RUN { (format!("z{zeros}."), zeros) } else { (format!("{first:02x}"), 1) };
        text += &run;
        rest = &rest[taken..];
    }
    text
}

fn bytes(digits: &str) -> Vec<u8> {
    let mut found = Vec::new();
    let mut rest = digits;
    while !rest.is_empty() {
        if let Some(zeros) = rest.strip_prefix('z') {
            let (count, behind) = zeros.split_once('.').expect("a point behind the number of zeros");
            found.resize(found.len() + count.parse::<usize>().expect("a number"), 0);
            rest = behind;
        } else {
            let (byte, behind) = rest.split_at(2);
            found.push(u8::from_str_radix(byte, 16).expect("two digits"));
            rest = behind;
        }
    }
    found
}

/// A record as text: a line for each entry, ` xN` behind one that comes N times in a row.
pub(super) fn text(entries: &[Entry]) -> String {
    let mut text = String::new();
    for same in entries.chunk_by(|a, b| a == b) {
        text += &same[0].line();
        if same.len() > 1 {
            write!(text, " x{}", same.len()).expect("a text takes everything");
        }
        text.push('\n');
    }
    text
}

pub(super) fn parse(record: &str) -> Vec<Entry> {
    let mut entries = Vec::new();
    for line in record.lines() {
        let (line, count) = match line.split_once(" x") {
            Some((line, count)) => (line, count.parse().expect("a number")),
            None => (line, 1),
        };
        entries.extend(std::iter::repeat_n(Entry::parse(line), count));
    }
    entries
}

/// Where the datagrams of a body lie.
fn datagrams(body: &[u8]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut at = ETHERCAT_BYTES;
    while at + DATAGRAM_BYTES <= body.len() {
        let length = u16::from_le_bytes([body[at + 6], body[at + 7]]);
        let end = at + DATAGRAM_BYTES + usize::from(length & 0x7FF) + 2;
        found.push(at..end.min(body.len()));
        if length & 0x8000 == 0 {
            break;
        }
        at = end;
    }
    found
}

/// A frame without what is no part of the request: the indices of its datagrams, the data that a read carries out, the
/// inputs of process data, and what depends on the time.
fn request(body: &[u8], inputs_bytes: usize) -> Vec<u8> {
    let mut request = body.to_vec();
    for range in datagrams(body) {
        let datagram = &mut request[range];
        let (command, register) = (datagram[0], u16::from_le_bytes([datagram[4], datagram[5]]));
        datagram[1] = 0;
        let end = datagram.len();
        let data = &mut datagram[DATAGRAM_BYTES..end];
        match command {
            // APRD, FPRD, BRD, LRD; ARMW, FRMW of the system time.
            1 | 4 | 7 | 10 | 13 | 14 => data.fill(0),
            12 => {
                let count = inputs_bytes.min(data.len());
                data[..count].fill(0);
            }
            // Offset of the system time, and the first SYNC0.
            _ if matches!(register, 0x0920 | 0x0990) => data.fill(0),
            _ => {}
        }
    }
    request
}

/// Answers as the stations of a record did.
pub(super) struct Replay {
    entries: Vec<Entry>,
    requests: Vec<Vec<u8>>,
    inputs_bytes: usize,
    /// Behind the entry that was answered last.
    next: usize,
    unknown: Rc<RefCell<Vec<String>>>,
}

impl Replay {
    /// Plays a record of a bus with so many bytes of inputs; frames that the record does not have are put into `unknown`.
    pub(super) fn new(record: &str, inputs_bytes: usize, unknown: &Rc<RefCell<Vec<String>>>) -> Self {
        let entries = parse(record);
        let requests = entries.iter().map(|entry| request(&entry.sent, inputs_bytes)).collect();
        Self { entries, requests, inputs_bytes, next: 0, unknown: Rc::clone(unknown) }
    }
}

impl Far for Replay {
    /// The reply to the same request that comes next in the record. Where there is none, the MainDevice has asked more often
    /// than in the record: the last one before is given again.
    fn answer(&mut self, frame: &[u8]) -> Option<Vec<u8>> {
        let body = &frame[HEADER_BYTES..];
        let asked = request(body, self.inputs_bytes);
        let (before, behind) = self.requests.split_at(self.next);
        let found = match behind.iter().position(|request| *request == asked) {
            Some(position) => Some(self.next + position),
            None => before.iter().rposition(|request| *request == asked),
        };
        let Some(found) = found else {
            self.unknown.borrow_mut().push(digits(body.iter().copied()));
            return None;
        };
        self.next = found + 1;
        let mut reply = self.entries[found].reply.clone()?;
        for range in datagrams(body) {
            reply[range.start + 1] = body[range.start + 1];
        }
        let mut whole = frame[..HEADER_BYTES].to_vec();
        whole[6] |= 0x02;
        whole.extend(reply);
        Some(whole)
    }

    fn rest(&mut self, _time: Duration) {}
}

/// A real interface of which a record is made.
#[cfg(target_os = "linux")]
pub(super) struct Recorder {
    socket: crate::wire::PacketSocket,
    entries: Rc<RefCell<Vec<Entry>>>,
}

#[cfg(target_os = "linux")]
impl Recorder {
    /// Longest wait for a reply.
    const LIMIT: Duration = Duration::from_millis(100);

    pub(super) fn new(interface: &str, entries: &Rc<RefCell<Vec<Entry>>>) -> Self {
        // A clock that stands still: waiting until an instant is waiting for that long.
        let socket = crate::wire::PacketSocket::open(interface, Box::new(|| Duration::ZERO));
        Self { socket: socket.expect("an interface with SubDevices behind it"), entries: Rc::clone(entries) }
    }

    fn receive(&mut self, tag: &[u8]) -> Option<Vec<u8>> {
        use crate::wire::EthernetLink as _;
        let mut bytes = [0; crate::wire::MAX_FRAME_BYTES];
        for _ in 0..2 {
            self.socket.wait(Self::LIMIT).expect("the interface stays");
            while let Some(length) = self.socket.receive(&mut bytes).expect("the interface stays") {
                if bytes.get(8..12) == Some(tag) {
                    return Some(bytes[..length].to_vec());
                }
            }
        }
        None
    }
}

#[cfg(target_os = "linux")]
impl Far for Recorder {
    fn answer(&mut self, frame: &[u8]) -> Option<Vec<u8>> {
        use crate::wire::EthernetLink as _;
        self.socket.send(frame).expect("the interface stays");
        let reply = self.receive(&frame[8..12]);
        let sent = frame[HEADER_BYTES..].to_vec();
        let body = reply.as_ref().map(|reply| reply[HEADER_BYTES..HEADER_BYTES + sent.len()].to_vec());
        self.entries.borrow_mut().push(Entry { sent, reply: body });
        reply
    }

    fn rest(&mut self, time: Duration) {
        use crate::wire::EthernetLink as _;
        self.socket.wait(time).expect("the interface stays");
    }
}
