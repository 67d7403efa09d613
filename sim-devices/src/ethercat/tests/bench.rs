//! Frames for tests, and what comes back.

use std::time::Duration;

use super::super::line::{EtherCatLine, Passage};

/// Station address of the first SubDevice.
pub(super) const FIRST: u16 = 0x1001;
/// From one frame to the next.
const BETWEEN: Duration = Duration::from_micros(100);

pub(super) const APWR: u8 = 2;
pub(super) const FPRD: u8 = 4;
pub(super) const FPWR: u8 = 5;
pub(super) const BRD: u8 = 7;
pub(super) const BWR: u8 = 8;
pub(super) const LRD: u8 = 10;
pub(super) const LWR: u8 = 11;
pub(super) const LRW: u8 = 12;
pub(super) const FRMW: u8 = 14;

/// A datagram to be sent.
#[derive(Clone, Debug)]
pub(super) struct Datagram {
    command: u8,
    address: u32,
    data: Vec<u8>,
}

/// A datagram that came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Answer {
    pub(super) adp: u16,
    pub(super) data: Vec<u8>,
    pub(super) counter: u16,
    pub(super) events: u16,
}

/// A datagram for a position or station and an address in its memory.
pub(super) fn at(command: u8, adp: u16, ado: u16, data: &[u8]) -> Datagram {
    Datagram { command, address: u32::from(adp) | u32::from(ado) << 16, data: data.to_vec() }
}

/// A datagram for a logical address.
pub(super) fn logical(command: u8, address: u32, data: &[u8]) -> Datagram {
    Datagram { command, address, data: data.to_vec() }
}

/// A frame with these datagrams, not padded.
pub(super) fn frame(datagrams: &[Datagram]) -> Vec<u8> {
    let mut body = Vec::new();
    for (k, Datagram { command, address, data }) in datagrams.iter().enumerate() {
        let more = if k + 1 < datagrams.len() { 1 << 15 } else { 0 };
        body.extend([*command, k as u8]);
        body.extend(address.to_le_bytes());
        body.extend((data.len() as u16 | more).to_le_bytes());
        body.extend([0, 0]);
        body.extend(data);
        body.extend([0, 0]);
    }
    let mut frame = vec![0xFF; 6];
    frame.extend([0x10; 6]);
    frame.extend([0x88, 0xA4]);
    frame.extend((body.len() as u16 | 1 << 12).to_le_bytes());
    frame.extend(body);
    frame
}

/// The datagrams of a frame that came back.
pub(super) fn answers(frame: &[u8]) -> Vec<Answer> {
    let word = |at: usize| u16::from_le_bytes([frame[at], frame[at + 1]]);
    let mut found = Vec::new();
    let mut at = 16;
    loop {
        let length = word(at + 6);
        let count = usize::from(length & 0x7FF);
        let data = frame[at + 10..at + 10 + count].to_vec();
        let counter = word(at + 10 + count);
        found.push(Answer { adp: word(at + 2), data, counter, events: word(at + 8) });
        at += 12 + count;
        if length & 1 << 15 == 0 {
            return found;
        }
    }
}

/// A line and the time at its MainDevice.
pub(super) struct Bench<L> {
    pub(super) line: L,
    pub(super) now: Duration,
    /// Counter of the last mailbox message of [`Self::upload`].
    counter: u8,
}

impl<L: EtherCatLine> Bench<L> {
    pub(super) fn new(line: L) -> Self {
        Self { line, now: Duration::ZERO, counter: 0 }
    }

    /// Sends a frame as it is.
    pub(super) fn send(&mut self, frame: &mut [u8]) -> Passage {
        self.now += BETWEEN;
        self.line.pass(self.now, frame)
    }

    /// Sends datagrams in one frame, which must come back once.
    pub(super) fn pass(&mut self, datagrams: &[Datagram]) -> Vec<Answer> {
        let mut frame = frame(datagrams);
        let passage = self.send(&mut frame);
        assert_eq!((passage.answers, passage.bytes), (1, frame.len()));
        answers(&frame)
    }

    /// Sends one datagram.
    pub(super) fn one(&mut self, datagram: Datagram) -> Answer {
        self.pass(&[datagram]).remove(0)
    }

    /// Reads from a station that must answer.
    pub(super) fn read(&mut self, station: u16, ado: u16, count: usize) -> Vec<u8> {
        let answer = self.one(at(FPRD, station, ado, &vec![0; count]));
        assert_eq!(answer.counter, 1, "{station:04X}h, {ado:04X}h");
        answer.data
    }

    pub(super) fn read_u16(&mut self, station: u16, ado: u16) -> u16 {
        let data = self.read(station, ado, 2);
        u16::from_le_bytes([data[0], data[1]])
    }

    pub(super) fn read_u32(&mut self, station: u16, ado: u16) -> u32 {
        let data = self.read(station, ado, 4);
        u32::from_le_bytes([data[0], data[1], data[2], data[3]])
    }

    /// Writes to a station; the working counter.
    pub(super) fn write(&mut self, station: u16, ado: u16, data: &[u8]) -> u16 {
        self.one(at(FPWR, station, ado, data)).counter
    }

    /// Time passes without a frame.
    pub(super) fn wait(&mut self, by: Duration) {
        self.now += by;
        self.line.advance(self.now);
    }

    /// Gives every SubDevice its station address.
    pub(super) fn number(&mut self) {
        for k in 0..self.line.names().len() as u16 {
            let station = (FIRST + k).to_le_bytes();
            let answer = self.one(at(APWR, 0_u16.wrapping_sub(k), 0x0010, &station));
            assert_eq!(answer.counter, 1);
        }
    }

    /// Asks for a state.
    pub(super) fn ask(&mut self, station: u16, control: u8) {
        assert_eq!(self.write(station, 0x0120, &[control, 0]), 1);
    }

    /// AL status and its code, read together.
    pub(super) fn state(&mut self, station: u16) -> [u16; 2] {
        let bytes = self.read(station, 0x0130, 6);
        [u16::from_le_bytes([bytes[0], bytes[1]]), u16::from_le_bytes([bytes[4], bytes[5]])]
    }

    /// Asks for a state, and what became of it.
    pub(super) fn asked(&mut self, station: u16, control: u8) -> [u16; 2] {
        self.ask(station, control);
        self.state(station)
    }

    /// Sets up a sync manager.
    pub(super) fn sync_manager(&mut self, station: u16, n: u16, start: u16, length: u16, control: u8) {
        let ([s0, s1], [l0, l1]) = (start.to_le_bytes(), length.to_le_bytes());
        self.write(station, 0x0806 + 8 * n, &[0]);
        self.write(station, 0x0800 + 8 * n, &[s0, s1, l0, l1, control, 0, 1, 0]);
    }

    /// Sets up an FMMU of whole bytes: 1 reads, 2 writes.
    pub(super) fn fmmu(&mut self, station: u16, n: u16, logical: u32, length: u16, physical: u16, kind: u8) {
        let mut bytes = logical.to_le_bytes().to_vec();
        bytes.extend(length.to_le_bytes());
        bytes.extend([0, 7]);
        bytes.extend(physical.to_le_bytes());
        bytes.extend([0, kind, 1, 0, 0, 0]);
        assert_eq!(self.write(station, 0x0600 + 16 * n, &bytes), 1);
    }

    /// Both mailboxes as a device with 128 bytes each has them, and PRE-OP.
    pub(super) fn reach_pre_op(&mut self, station: u16) {
        self.sync_manager(station, 0, 0x1000, 128, 0x26);
        self.sync_manager(station, 1, 0x1080, 128, 0x22);
        assert_eq!(self.asked(station, 2), [2, 0]);
    }

    /// Process data of these lengths, and SAFE-OP, all the way from INIT.
    pub(super) fn reach_safe_op(&mut self, station: u16, outputs: u16, inputs: u16) {
        self.reach_pre_op(station);
        self.go_on_to_safe_op(station, outputs, inputs);
    }

    /// Process data of these lengths, and SAFE-OP.
    pub(super) fn go_on_to_safe_op(&mut self, station: u16, outputs: u16, inputs: u16) {
        self.sync_manager(station, 2, 0x1100, outputs, 0x64);
        self.sync_manager(station, 3, 0x1400, inputs, 0x20);
        assert_eq!(self.asked(station, 4), [4, 0]);
    }

    /// OP with outputs that are all zero.
    pub(super) fn reach_op(&mut self, station: u16, outputs: u16, inputs: u16) {
        self.reach_safe_op(station, outputs, inputs);
        self.ask(station, 8);
        assert_eq!(self.write(station, 0x1100, &vec![0; usize::from(outputs)]), 1);
        assert_eq!(self.state(station), [8, 0]);
    }

    /// Sends a mailbox message; the working counter.
    pub(super) fn post(&mut self, station: u16, kind: u8, body: &[u8]) -> u16 {
        let mut message = (body.len() as u16).to_le_bytes().to_vec();
        message.extend([0, 0, 0, kind]);
        message.extend(body);
        message.resize(128, 0);
        self.write(station, 0x1000, &message)
    }

    /// The message that waits: its kind with counter, and its body.
    pub(super) fn fetch(&mut self, station: u16) -> Option<(u8, Vec<u8>)> {
        let answer = self.one(at(FPRD, station, 0x1080, &[0; 128]));
        let count = usize::from(u16::from_le_bytes([answer.data[0], answer.data[1]]));
        (answer.counter == 1).then(|| (answer.data[5], answer.data[6..6 + count].to_vec()))
    }

    /// Reads an object of up to four bytes.
    pub(super) fn upload(&mut self, station: u16, index: u16, sub: u8) -> Vec<u8> {
        let [low, high] = index.to_le_bytes();
        self.counter = self.counter % 7 + 1;
        let kind = 3 | self.counter << 4;
        assert_eq!(self.post(station, kind, &[0, 0x20, 0x40, low, high, sub, 0, 0, 0, 0]), 1);
        let (answered, body) = self.fetch(station).expect("an answer");
        assert_eq!((answered, &body[..2]), (kind, &[0, 0x30][..]));
        body[2..].to_vec()
    }
}
