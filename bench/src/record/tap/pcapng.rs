//! A capture that Wireshark reads: pcapng, nanoseconds since 1970, direction of each frame, interface by its name.
//!
//! Written here because four kinds of blocks are all it takes; the crates for it are a release candidate, or bring a second
//! generation of procedural macros and error types into the tree.

use std::io::{self, Write};

use drivers::wire::{MAX_FRAME_BYTES, Way};

use super::{FrameFile, Kept, TapCounts};

const SECTION_HEADER: u32 = 0x0A0D_0D0A;
const INTERFACE_DESCRIPTION: u32 = 1;
const INTERFACE_STATISTICS: u32 = 5;
const ENHANCED_PACKET: u32 = 6;
/// Tells the order of bytes.
const BYTE_ORDER: u32 = 0x1A2B_3C4D;
/// Link type Ethernet, without preamble.
const ETHERNET: u16 = 1;
/// The length of the section is not known before its end.
const UNKNOWN_LENGTH: u64 = u64::MAX;

const END_OF_OPTIONS: u16 = 0;
const COMMENT: u16 = 1;
const SECTION_PROGRAM: u16 = 4;
const INTERFACE_NAME: u16 = 2;
/// Negative power of ten of the unit of time.
const INTERFACE_RESOLUTION: u16 = 9;
/// Bytes of the check sequence at the end of each frame.
const INTERFACE_CHECK_BYTES: u16 = 13;
const PACKET_FLAGS: u16 = 2;
const PACKET_LOST_BEFORE: u16 = 4;
const STATISTICS_RECEIVED: u16 = 4;
const STATISTICS_DROPPED: u16 = 5;

const INBOUND: u32 = 1;
const OUTBOUND: u32 = 2;

const TIMES: &str =
    "Times: UTC of the start of the run, read once, plus the time since then by the monotonic clock";

/// A capture on its way into a file.
pub(super) struct PcapNg<W> {
    sink: W,
    /// The body of a block, reused from frame to frame.
    body: Vec<u8>,
    last_unix_ns: u64,
}

impl<W: Write> PcapNg<W> {
    /// Begins a capture of this interface.
    pub(super) fn new(sink: W, interface: &str) -> io::Result<Self> {
        let mut own = Self { sink, body: Vec::with_capacity(2 * MAX_FRAME_BYTES), last_unix_ns: 0 };
        own.put(&BYTE_ORDER.to_le_bytes());
        own.put(&[1, 0, 0, 0]); // version 1.0
        own.put(&UNKNOWN_LENGTH.to_le_bytes());
        own.option(SECTION_PROGRAM, concat!("Director Bench ", env!("CARGO_PKG_VERSION")).as_bytes());
        own.option(COMMENT, TIMES.as_bytes());
        own.end(SECTION_HEADER)?;
        own.put(&ETHERNET.to_le_bytes());
        own.put(&[0; 2]);
        own.put(&(MAX_FRAME_BYTES as u32).to_le_bytes());
        own.option(INTERFACE_NAME, interface.as_bytes());
        own.option(INTERFACE_RESOLUTION, &[9]);
        own.option(INTERFACE_CHECK_BYTES, &[0]);
        own.end(INTERFACE_DESCRIPTION)?;
        own.sink.flush()?;
        Ok(own)
    }

    fn put(&mut self, bytes: &[u8]) {
        self.body.extend_from_slice(bytes);
    }

    /// Everything begins at a multiple of four bytes.
    fn pad(&mut self) {
        self.body.resize(self.body.len().next_multiple_of(4), 0);
    }

    /// An option. Longer ones than a length can tell are cut off.
    fn option(&mut self, code: u16, value: &[u8]) {
        let length = u16::try_from(value.len()).unwrap_or(u16::MAX);
        self.put(&code.to_le_bytes());
        self.put(&length.to_le_bytes());
        self.put(&value[..usize::from(length)]);
        self.pad();
    }

    /// Writes the block whose body has been put together, its options ended.
    fn end(&mut self, kind: u32) -> io::Result<()> {
        /// Kind, and the length at both ends.
        const AROUND_BYTES: usize = 12;
        self.option(END_OF_OPTIONS, &[]);
        let length = u32::try_from(self.body.len() + AROUND_BYTES).map_err(io::Error::other)?;
        self.sink.write_all(&kind.to_le_bytes())?;
        self.sink.write_all(&length.to_le_bytes())?;
        self.sink.write_all(&self.body)?;
        self.sink.write_all(&length.to_le_bytes())?;
        self.body.clear();
        Ok(())
    }

    /// Interface 0 and a time, as two block kinds begin.
    fn place(&mut self, unix_ns: u64) {
        self.put(&[0; 4]);
        self.put(&((unix_ns >> 32) as u32).to_le_bytes());
        self.put(&(unix_ns as u32).to_le_bytes());
    }
}

impl<W: Write + Send> FrameFile for PcapNg<W> {
    fn frame(&mut self, kept: &Kept) -> io::Result<()> {
        let frame = kept.frame.bytes();
        let length = u32::try_from(frame.len()).map_err(io::Error::other)?.to_le_bytes();
        self.last_unix_ns = kept.unix_ns;
        self.place(kept.unix_ns);
        self.put(&length);
        self.put(&length);
        self.put(frame);
        self.pad();
        let flags = match kept.way {
            Way::Out => OUTBOUND,
            Way::Back => INBOUND,
        };
        self.option(PACKET_FLAGS, &flags.to_le_bytes());
        if kept.lost_before > 0 {
            self.option(PACKET_LOST_BEFORE, &kept.lost_before.to_le_bytes());
        }
        self.end(ENHANCED_PACKET)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }

    fn finish(mut self: Box<Self>, counts: TapCounts) -> io::Result<()> {
        self.place(self.last_unix_ns);
        self.option(STATISTICS_RECEIVED, &counts.frames.saturating_add(counts.lost).to_le_bytes());
        self.option(STATISTICS_DROPPED, &counts.lost.to_le_bytes());
        self.end(INTERFACE_STATISTICS)?;
        self.sink.flush()
    }
}
