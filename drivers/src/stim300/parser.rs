//! Datagrams out of a byte stream that may begin, break and resume anywhere.
//!
//! Rule: take the length from the identifier, verify the checksum; on failure advance one byte. The identifier is a single byte,
//! so false ones are frequent: each costs one checksum over at most 63 bytes.

use super::datagram::{Announced, LONGEST_DATAGRAM, Measurement, checked};
use super::special::Special;
use crate::framing::{self, Stream, Tally};

/// Behind a datagram, if that is configured.
const LINE_END: [u8; 2] = [b'\r', b'\n'];

/// A datagram whose checksum is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// A measurement.
    Measurement(Measurement),
    /// Identity, configuration, trim or errors.
    Special(Special),
}

/// Finds datagrams; allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct Parser {
    stream: Stream,
    /// Bytes of CR LF that may still come behind the last datagram.
    line_end: &'static [u8],
}

impl Parser {
    /// Appends bytes. If they do not fit, the oldest are given up (and counted as skipped).
    pub fn push(&mut self, bytes: &[u8]) {
        self.stream.push(bytes);
    }

    /// The next datagram; `None` if more bytes are needed.
    #[allow(clippy::should_implement_trait)] // More may come after None, and a line never ends.
    pub fn next(&mut self) -> Option<Found> {
        loop {
            let waiting = self.stream.waiting();
            let &first = waiting.first()?;
            if let Some((&end, rest)) = self.line_end.split_first()
                && end == first
            {
                self.line_end = rest;
                self.stream.take(1);
                continue;
            }
            let Some(announced) = Announced::by_id(first) else {
                self.skip();
                continue;
            };
            let datagram = waiting.get(..announced.bytes())?;
            match checked(datagram).and_then(|bytes| decode(announced, &bytes[1..])) {
                Some(found) => {
                    self.stream.take(announced.bytes());
                    self.line_end = &LINE_END;
                    return Some(found);
                }
                None => {
                    self.line_end = &[];
                    self.stream.reject();
                }
            }
        }
    }

    fn skip(&mut self) {
        self.line_end = &[];
        self.stream.skip(1);
    }

    /// Number of bytes that have arrived and belong to no datagram yet.
    pub(super) fn waiting_bytes(&self) -> usize {
        self.stream.waiting().len()
    }

    /// What was thrown away so far.
    pub fn tally(&self) -> Tally {
        self.stream.tally()
    }
}

fn decode(announced: Announced, payload: &[u8]) -> Option<Found> {
    match announced {
        Announced::Measurement(content) => Measurement::decode(content, payload).map(Found::Measurement),
        Announced::Special(kind) => Special::decode(kind, payload).map(Found::Special),
    }
}

const _: () = assert!(LONGEST_DATAGRAM + LINE_END.len() <= framing::LONGEST_FRAME);
