//! An interface in steps: each frame is answered before anything else happens, and time passes only while somebody waits.
//!
//! With the same replies, a bus on such an interface sends the same frames, to the last byte.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use crate::wire::EthernetLink;

/// From sending a frame until its reply is there.
const ROUND_TRIP: Duration = Duration::from_micros(50);

/// What is at the other end.
pub(super) trait Far {
    /// The reply to a frame, if there is one.
    fn answer(&mut self, frame: &[u8]) -> Option<Vec<u8>>;

    /// Time passes without a frame.
    fn rest(&mut self, time: Duration);
}

/// The interface.
pub(super) struct Stepped<F> {
    far: F,
    now: Duration,
    replies: VecDeque<(Duration, Vec<u8>)>,
}

impl<F: Far> Stepped<F> {
    pub(super) fn new(far: F) -> Self {
        Self { far, now: Duration::ZERO, replies: VecDeque::new() }
    }
}

impl<F: Far> EthernetLink for Stepped<F> {
    fn name(&self) -> &str {
        "stepped"
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        if let Some(reply) = self.far.answer(frame) {
            self.replies.push_back((self.now + ROUND_TRIP, reply));
        }
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        let is_there = self.replies.front().is_some_and(|(at, _)| *at <= self.now);
        let Some((_, reply)) = self.replies.pop_front_if(|_| is_there) else { return Ok(None) };
        into[..reply.len()].copy_from_slice(&reply);
        Ok(Some(reply.len()))
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        match self.replies.front() {
            Some((at, _)) => self.now = self.now.max(until.min(*at)),
            None => {
                self.far.rest(until.saturating_sub(self.now));
                self.now = self.now.max(until);
            }
        }
        Ok(())
    }
}
