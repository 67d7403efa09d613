//! One acyclic datagram: a read or a write of a station's memory.

use ethercrab::error::Error;
use ethercrab::{Command, MainDevice};

/// A read or a write of a station's memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Datagram<'a> {
    /// Configured station address.
    pub(super) address: u16,
    pub(super) register: u16,
    pub(super) content: Content<'a>,
}

/// What is read or written.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content<'a> {
    Read { bytes: u16 },
    Write(&'a [u8]),
}

/// What became of a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// No reply.
    Lost,
    /// Working counter 0.
    Refused,
    /// Done; the number of bytes that were read.
    Done(usize),
}

impl Datagram<'_> {
    /// Sends the datagram in a frame of its own; what comes back is put into `into`.
    pub(super) async fn pass(&self, main: &MainDevice<'_>, into: &mut [u8]) -> Outcome {
        let answer = match self.content {
            Content::Read { bytes } => {
                Command::fprd(self.address, self.register).receive_slice(main, bytes).await
            }
            Content::Write(bytes) => {
                Command::fpwr(self.address, self.register).send_receive_slice(main, bytes).await
            }
        };
        match answer {
            Ok(data) => {
                let count = data.len().min(into.len());
                into[..count].copy_from_slice(&data[..count]);
                Outcome::Done(count)
            }
            Err(Error::WorkingCounter { .. }) => Outcome::Refused,
            Err(_) => Outcome::Lost,
        }
    }
}
