//! SDO client (CiA 301, 7.2.4): one transfer at a time, expedited or in segments, as a state machine that is told frames and the
//! time.

use std::time::Duration;

use super::super::SdoAbort;

/// Longest transfer (safety.md: deadlines).
pub(super) const TIMEOUT: Duration = Duration::from_secs(1);
/// Longest object that is read.
const MOST_BYTES: usize = 64 * 1024;
/// Most bytes in a frame that begins a transfer.
const EXPEDITED_BYTES: usize = 4;
/// Most bytes of a segment.
const SEGMENT_BYTES: usize = 7;

/// Abort codes of the client itself.
mod abort {
    use super::SdoAbort;
    pub(super) const TOGGLE: SdoAbort = SdoAbort(0x0503_0000);
    pub(super) const TIMED_OUT: SdoAbort = SdoAbort(0x0504_0000);
    pub(super) const COMMAND: SdoAbort = SdoAbort(0x0504_0001);
    pub(super) const OUT_OF_MEMORY: SdoAbort = SdoAbort(0x0504_0005);
    pub(super) const LENGTH: SdoAbort = SdoAbort(0x0607_0010);
}

/// Place of an object: index and sub-index.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) index: u16,
    pub(super) sub: u8,
}

/// Which answer is waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// None: no transfer is under way.
    Idle,
    /// The beginning of an object.
    Upload,
    /// A segment of an object, whose size the server may have told.
    UploadSegment { toggle: bool, size: Option<usize> },
    /// That a write is done, or begun.
    Download,
    /// That a segment was taken; `sent` bytes have gone out.
    DownloadSegment { toggle: bool, sent: usize },
}

/// An SDO client.
#[derive(Debug)]
pub(super) struct SdoClient {
    node: u8,
    place: Place,
    step: Step,
    begun: Duration,
    /// What was read so far, or is to be written.
    data: Vec<u8>,
    outcome: Option<Result<(), SdoAbort>>,
}

impl SdoClient {
    pub(super) fn new() -> Self {
        let (node, place, begun) = Default::default();
        Self { node, place, step: Step::Idle, begun, data: Vec::new(), outcome: None }
    }

    /// The node of the transfer that was begun last.
    pub(super) fn node(&self) -> u8 {
        self.node
    }

    /// Begins a transfer; gives the request. One that was under way is forgotten.
    pub(super) fn start(&mut self, now: Duration, node: u8, place: Place, write: Option<&[u8]>) -> [u8; 8] {
        (self.node, self.place, self.begun, self.outcome) = (node, place, now, None);
        self.data.clear();
        let Some(bytes) = write else {
            self.step = Step::Upload;
            return self.frame(0x40, [0; 4]);
        };
        self.data.extend_from_slice(bytes);
        self.step = Step::Download;
        if (1..=EXPEDITED_BYTES).contains(&bytes.len()) {
            let mut data = [0; 4];
            data[..bytes.len()].copy_from_slice(bytes);
            let unused = (EXPEDITED_BYTES - bytes.len()) as u8;
            return self.frame(0x23 | unused << 2, data);
        }
        self.frame(0x21, (bytes.len() as u32).to_le_bytes())
    }

    /// A transfer cannot be done at all.
    pub(super) fn refuse(&mut self) {
        (self.step, self.outcome) = (Step::Idle, Some(Err(abort::TIMED_OUT)));
    }

    /// Takes what the server of its node has sent; gives the next request, if there is one. Answers to other transfers are
    /// passed over, shorter answers are taken as if filled with zeros.
    pub(super) fn take(&mut self, answer: &[u8]) -> Option<[u8; 8]> {
        let mut padded = [0; 8];
        let count = answer.len().min(padded.len());
        padded[..count].copy_from_slice(&answer[..count]);
        let command = *answer.first()?;
        let is_mine =
            self.place == Place { index: u16::from_le_bytes([padded[1], padded[2]]), sub: padded[3] };
        let begins = matches!(self.step, Step::Upload | Step::Download);
        if self.step == Step::Idle || (begins && !is_mine) {
            return None;
        }
        if command >> 5 == 4 {
            let code = u32::from_le_bytes([padded[4], padded[5], padded[6], padded[7]]);
            return self.end(Err(SdoAbort(code)));
        }
        let next = match (self.step, command >> 5) {
            (Step::Upload, 2) => self.uploaded(command, &padded, answer.len()),
            (Step::UploadSegment { toggle, size }, 0) => {
                self.uploaded_segment(command, &padded, answer.len(), toggle, size)
            }
            (Step::Download, 3) if self.is_expedited() => Ok(None),
            (Step::Download, 3) => Ok(Some(self.segment(false, 0))),
            (Step::DownloadSegment { toggle, sent }, 1) => self.downloaded_segment(command, toggle, sent),
            _ => Err(abort::COMMAND),
        };
        match next {
            Ok(Some(request)) => Some(request),
            Ok(None) => {
                if matches!(self.step, Step::Download | Step::DownloadSegment { .. }) {
                    self.data.clear();
                }
                self.end(Ok(()))
            }
            Err(abort) => {
                self.end(Err(abort));
                Some(self.frame(0x80, abort.0.to_le_bytes()))
            }
        }
    }

    /// Gives up a transfer that takes too long; gives the abort that the server must be told.
    pub(super) fn expire(&mut self, now: Duration) -> Option<[u8; 8]> {
        if self.step == Step::Idle || now.saturating_sub(self.begun) < TIMEOUT {
            return None;
        }
        self.end(Err(abort::TIMED_OUT));
        Some(self.frame(0x80, abort::TIMED_OUT.0.to_le_bytes()))
    }

    /// How the transfer ended, once; with what was read.
    pub(super) fn take_outcome(&mut self) -> Option<Result<&[u8], SdoAbort>> {
        self.outcome.take().map(|outcome| outcome.map(|()| &self.data[..]))
    }

    fn uploaded(
        &mut self,
        command: u8,
        answer: &[u8; 8],
        length: usize,
    ) -> Result<Option<[u8; 8]>, SdoAbort> {
        let (is_expedited, has_size) = (command & 2 != 0, command & 1 != 0);
        if is_expedited {
            let unused = if has_size { usize::from(command >> 2 & 3) } else { 8 - length.clamp(4, 8) };
            self.data.extend_from_slice(&answer[4..8 - unused]);
            return Ok(None);
        }
        let size = u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]) as usize;
        if has_size && size > MOST_BYTES {
            return Err(abort::OUT_OF_MEMORY);
        }
        self.step = Step::UploadSegment { toggle: false, size: has_size.then_some(size) };
        Ok(Some(bare(0x60)))
    }

    fn uploaded_segment(
        &mut self,
        command: u8,
        answer: &[u8; 8],
        length: usize,
        toggle: bool,
        size: Option<usize>,
    ) -> Result<Option<[u8; 8]>, SdoAbort> {
        if (command & 0x10 != 0) != toggle {
            return Err(abort::TOGGLE);
        }
        let count = (SEGMENT_BYTES - usize::from(command >> 1 & 7)).min(length.saturating_sub(1));
        self.data.extend_from_slice(&answer[1..1 + count]);
        if self.data.len() > size.unwrap_or(MOST_BYTES) {
            return Err(if size.is_some() { abort::LENGTH } else { abort::OUT_OF_MEMORY });
        }
        if command & 1 == 0 {
            self.step = Step::UploadSegment { toggle: !toggle, size };
            return Ok(Some(bare(0x60 | u8::from(!toggle) << 4)));
        }
        if size.is_some_and(|size| size != self.data.len()) { Err(abort::LENGTH) } else { Ok(None) }
    }

    fn downloaded_segment(
        &mut self,
        command: u8,
        toggle: bool,
        sent: usize,
    ) -> Result<Option<[u8; 8]>, SdoAbort> {
        if (command & 0x10 != 0) != toggle {
            return Err(abort::TOGGLE);
        }
        Ok((sent < self.data.len()).then(|| self.segment(!toggle, sent)))
    }

    /// The segment that begins at byte `from`.
    fn segment(&mut self, toggle: bool, from: usize) -> [u8; 8] {
        let left = &self.data[from..];
        let count = left.len().min(SEGMENT_BYTES);
        let is_last = count == left.len();
        let unused = (SEGMENT_BYTES - count) as u8;
        let mut request = bare(u8::from(toggle) << 4 | unused << 1 | u8::from(is_last));
        request[1..1 + count].copy_from_slice(&left[..count]);
        self.step = Step::DownloadSegment { toggle, sent: from + count };
        request
    }

    fn is_expedited(&self) -> bool {
        (1..=EXPEDITED_BYTES).contains(&self.data.len())
    }

    fn end(&mut self, outcome: Result<(), SdoAbort>) -> Option<[u8; 8]> {
        self.step = Step::Idle;
        self.outcome = Some(outcome);
        None
    }

    fn frame(&self, command: u8, data: [u8; 4]) -> [u8; 8] {
        let [low, high] = self.place.index.to_le_bytes();
        let [a, b, c, d] = data;
        [command, low, high, self.place.sub, a, b, c, d]
    }
}

const fn bare(command: u8) -> [u8; 8] {
    [command, 0, 0, 0, 0, 0, 0, 0]
}

#[cfg(test)]
mod tests;
