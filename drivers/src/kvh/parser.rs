//! Frames out of a byte stream that may begin, break and resume anywhere.
//!
//! Rule: search for a header, take the length from its fourth byte, verify the checksum; on failure advance one
//! byte, so that a frame inside a false one is not lost.

use super::frame::{Announced, BIT_HEADER, BitReport, LONGEST_FRAME, MESSAGE_HEADER, Message};

/// Bytes that can wait; more than are pushed between two searches.
const BUFFER_BYTES: usize = 1024;

/// A frame whose checksum is right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// A message.
    Message(Message),
    /// A report of the built-in test.
    Bit(BitReport),
}

/// What was thrown away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Frames with a header and a wrong checksum.
    pub bad_checksums_count: u64,
    /// Bytes that belong to no frame.
    pub skipped_bytes_count: u64,
}

/// Finds frames; allocates nothing.
#[derive(Clone, Debug)]
pub struct Parser {
    buffer: [u8; BUFFER_BYTES],
    start: usize,
    end: usize,
    tally: Tally,
}

impl Default for Parser {
    fn default() -> Self {
        Self { buffer: [0; BUFFER_BYTES], start: 0, end: 0, tally: Tally::default() }
    }
}

impl Parser {
    /// Appends bytes. If they do not fit, the oldest are given up (and counted as skipped).
    pub fn push(&mut self, bytes: &[u8]) {
        let kept = bytes.len().min(BUFFER_BYTES);
        self.skip(bytes.len() - kept, 0);
        if self.end + kept > BUFFER_BYTES {
            self.make_room(kept);
        }
        self.buffer[self.end..self.end + kept].copy_from_slice(&bytes[bytes.len() - kept..]);
        self.end += kept;
    }

    fn make_room(&mut self, wanted: usize) {
        let waiting = self.end - self.start;
        let lost = (waiting + wanted).saturating_sub(BUFFER_BYTES);
        self.skip(lost, lost);
        self.buffer.copy_within(self.start..self.end, 0);
        (self.start, self.end) = (0, self.end - self.start);
    }

    fn skip(&mut self, counted: usize, moved: usize) {
        self.tally.skipped_bytes_count += counted as u64;
        self.start += moved;
    }

    /// The next frame; `None` if more bytes are needed.
    #[allow(clippy::should_implement_trait)] // More may come after None, and a line never ends.
    pub fn next(&mut self) -> Option<Found> {
        loop {
            let waiting = &self.buffer[self.start..self.end];
            let Some(header) = waiting.first_chunk::<4>() else {
                if waiting.is_empty() || begins_a_header(waiting) {
                    return None;
                }
                self.skip(1, 1);
                continue;
            };
            let Some(announced) = Announced::by(*header) else {
                self.skip(1, 1);
                continue;
            };
            let frame = waiting.get(..announced.bytes())?;
            let found = match announced {
                Announced::Message(format) => Message::decode(format, frame).map(Found::Message),
                Announced::Bit { length } => BitReport::decode(length, frame).map(Found::Bit),
            };
            match found {
                Some(found) => {
                    self.start += announced.bytes();
                    return Some(found);
                }
                None => {
                    self.tally.bad_checksums_count += 1;
                    self.skip(1, 1);
                }
            }
        }
    }

    /// What was thrown away so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }
}

/// Whether fewer than four bytes could be the beginning of a header.
fn begins_a_header(bytes: &[u8]) -> bool {
    [MESSAGE_HEADER, BIT_HEADER].iter().any(|header| header.starts_with(bytes))
}

const _: () = assert!(BUFFER_BYTES >= 2 * LONGEST_FRAME);
