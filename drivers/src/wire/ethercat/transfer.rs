//! One SDO transfer as the client sees it: messages in, messages out, no time and no bus.

use super::super::SdoAbort;
use super::coe::{self, Answer, Place, Request};

/// Toggle bit not alternated.
pub(super) const TOGGLE: SdoAbort = SdoAbort(0x0503_0000);
/// SDO timed out.
pub(super) const TIMED_OUT: SdoAbort = SdoAbort(0x0504_0000);
/// Unknown SDO command.
pub(super) const COMMAND: SdoAbort = SdoAbort(0x0504_0001);
/// Out of memory.
const MEMORY: SdoAbort = SdoAbort(0x0504_0005);
/// Length does not match.
const LENGTH: SdoAbort = SdoAbort(0x0607_0010);

/// Longest object that is read.
const LONGEST_BYTES: usize = 64 * 1024;
/// Room for an object before memory must be asked for.
const USUAL_BYTES: usize = 4096;

/// What follows from an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// The answer belongs to an older transfer: wait on.
    Wait,
    /// Send the next request.
    Send,
    /// The transfer is complete.
    Complete,
    /// The server gave up.
    Aborted(SdoAbort),
    /// The client gives up and says so to the server.
    Abort(SdoAbort),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Upload,
    UploadSegments,
    Download,
    DownloadSegments,
}

/// A transfer under way.
#[derive(Debug)]
pub(super) struct Transfer {
    phase: Phase,
    place: Place,
    toggle: bool,
    /// What was read so far, or what is written.
    data: Vec<u8>,
    /// Size of the whole object.
    size: usize,
    /// Bytes that the server has confirmed.
    confirmed_bytes: usize,
    mailbox_bytes: usize,
}

impl Transfer {
    /// A transfer that has nothing to do yet; it has room for objects of the usual size.
    pub(super) fn idle() -> Self {
        Self {
            phase: Phase::Upload,
            place: Place { index: 0, sub: 0 },
            toggle: false,
            data: Vec::with_capacity(USUAL_BYTES),
            size: 0,
            confirmed_bytes: 0,
            mailbox_bytes: 0,
        }
    }

    /// Begins to write `write`, or to read, with messages of at most `mailbox_bytes`.
    pub(super) fn begin(&mut self, place: Place, write: Option<&[u8]>, mailbox_bytes: usize) {
        self.place = place;
        self.mailbox_bytes = mailbox_bytes;
        (self.toggle, self.confirmed_bytes, self.size) = (false, 0, 0);
        self.phase = Phase::Upload;
        self.data.clear();
        if let Some(bytes) = write {
            self.phase = Phase::Download;
            self.data.extend_from_slice(bytes);
            self.size = bytes.len();
        }
    }

    /// The place of the object.
    pub(super) fn place(&self) -> Place {
        self.place
    }

    /// What was read.
    pub(super) fn data(&self) -> &[u8] {
        match self.phase {
            Phase::Upload | Phase::UploadSegments => &self.data,
            Phase::Download | Phase::DownloadSegments => &[],
        }
    }

    /// The message that is to be sent, or was sent last.
    pub(super) fn request(&self) -> Request<'_> {
        match self.phase {
            Phase::Upload => Request::Upload(self.place),
            Phase::UploadSegments => Request::UploadSegment { toggle: self.toggle },
            Phase::Download => {
                let data = &self.data[..self.chunk_end()];
                Request::Download { place: self.place, size: self.size, data }
            }
            Phase::DownloadSegments => {
                let end = self.chunk_end();
                let data = &self.data[self.confirmed_bytes..end];
                Request::DownloadSegment { toggle: self.toggle, is_last: end == self.size, data }
            }
        }
    }

    /// Where the data of the present message end.
    fn chunk_end(&self) -> usize {
        let capacity = match self.phase {
            Phase::Download if self.size <= 4 => 4,
            Phase::Download => coe::first_capacity(self.mailbox_bytes),
            _ => coe::segment_capacity(self.mailbox_bytes),
        };
        self.size.min(self.confirmed_bytes + capacity)
    }

    /// Takes an answer of the server.
    pub(super) fn take(&mut self, answer: &Answer<'_>) -> Next {
        match (self.phase, *answer) {
            (_, Answer::Abort { place, code }) if place == self.place => Next::Aborted(SdoAbort(code)),
            (Phase::Upload, Answer::Upload { place, size, data }) if place == self.place => {
                self.take_first(size, data)
            }
            (Phase::UploadSegments, Answer::UploadSegment { toggle, is_last, data }) => {
                self.take_segment(toggle, is_last, data)
            }
            (Phase::Download, Answer::Download(place)) if place == self.place => self.confirm(),
            (Phase::DownloadSegments, Answer::DownloadSegment { toggle }) if toggle == self.toggle => {
                self.toggle = !self.toggle;
                self.confirm()
            }
            (Phase::DownloadSegments, Answer::DownloadSegment { .. }) => Next::Abort(TOGGLE),
            _ => Next::Wait,
        }
    }

    fn take_first(&mut self, size: usize, data: &[u8]) -> Next {
        if size > LONGEST_BYTES {
            return Next::Abort(MEMORY);
        }
        self.size = size;
        self.data.extend_from_slice(data);
        if self.data.len() == size {
            return Next::Complete;
        }
        self.phase = Phase::UploadSegments;
        Next::Send
    }

    fn take_segment(&mut self, toggle: bool, is_last: bool, data: &[u8]) -> Next {
        if toggle != self.toggle {
            return Next::Abort(TOGGLE);
        }
        self.toggle = !self.toggle;
        self.data.extend_from_slice(data);
        let length = self.data.len();
        match length == self.size {
            true if is_last => Next::Complete,
            false if !is_last && length < self.size && !data.is_empty() => Next::Send,
            _ => Next::Abort(LENGTH),
        }
    }

    fn confirm(&mut self) -> Next {
        self.confirmed_bytes = self.chunk_end();
        self.phase = Phase::DownloadSegments;
        if self.confirmed_bytes == self.size { Next::Complete } else { Next::Send }
    }
}

#[cfg(test)]
mod tests;
