//! Frames out of a byte stream that may begin, break and resume anywhere.
//!
//! Rule: search for a header, take the length from its fourth byte, verify the checksum; on failure advance one
//! byte, so that a frame inside a false one is not lost.

use super::frame::{Announced, BIT_HEADER, BitReport, LONGEST_FRAME, MESSAGE_HEADER, Message};
use crate::framing::{self, Stream, Tally};

/// A frame whose checksum is right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// A message.
    Message(Message),
    /// A report of the built-in test.
    Bit(BitReport),
}

/// Finds frames; allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct Parser {
    stream: Stream,
}

impl Parser {
    /// Appends bytes. If they do not fit, the oldest are given up (and counted as skipped).
    pub fn push(&mut self, bytes: &[u8]) {
        self.stream.push(bytes);
    }

    /// Number of bytes that have arrived and belong to no frame yet.
    pub(super) fn waiting_bytes(&self) -> usize {
        self.stream.waiting().len()
    }

    /// The next frame; `None` if more bytes are needed.
    #[allow(clippy::should_implement_trait)] // More may come after None, and a line never ends.
    pub fn next(&mut self) -> Option<Found> {
        loop {
            let waiting = self.stream.waiting();
            let Some(header) = waiting.first_chunk::<4>() else {
                if waiting.is_empty() || begins_a_header(waiting) {
                    return None;
                }
                self.stream.skip(1);
                continue;
            };
            let Some(announced) = Announced::by(*header) else {
                self.stream.skip(1);
                continue;
            };
            let frame = waiting.get(..announced.bytes())?;
            let found = match announced {
                Announced::Message(format) => Message::decode(format, frame).map(Found::Message),
                Announced::Bit { length } => BitReport::decode(length, frame).map(Found::Bit),
            };
            match found {
                Some(found) => {
                    self.stream.take(announced.bytes());
                    return Some(found);
                }
                None => self.stream.reject(),
            }
        }
    }

    /// What was thrown away so far.
    pub fn tally(&self) -> Tally {
        self.stream.tally()
    }
}

/// Whether fewer than four bytes could be the beginning of a header.
fn begins_a_header(bytes: &[u8]) -> bool {
    [MESSAGE_HEADER, BIT_HEADER].iter().any(|header| header.starts_with(bytes))
}

const _: () = assert!(LONGEST_FRAME <= framing::LONGEST_FRAME);
