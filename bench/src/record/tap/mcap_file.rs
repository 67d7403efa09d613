//! A capture beside the logs: MCAP, topic `/wire`, each message one frame as it is.
//!
//! There is one channel for each direction, told by its metadata. Log time is the time since the start of the run, publish
//! time that in UTC.

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

use drivers::wire::Way;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions};

use super::{FrameFile, Kept, TapCounts};
use crate::clock;

/// Topic of all frames.
const TOPIC: &str = "/wire";
/// What a message is: a whole Ethernet frame without its check sequence.
const ENCODING: &str = "ethernet";
/// Bytes after which a chunk is closed.
const CHUNK_BYTES: u64 = 1 << 20;

/// A capture on its way into a file.
pub(super) struct McapFile<W: Write + Seek> {
    mcap: mcap::Writer<NoSeek<W>>,
    interface: String,
    channels: [Channel; 2],
    is_begun: bool,
}

#[derive(Clone, Copy, Debug)]
struct Channel {
    id: u16,
    sequence: u32,
}

impl<W: Write + Seek> McapFile<W> {
    /// Begins a capture of this interface.
    pub(super) fn new(sink: W, interface: &str) -> io::Result<Self> {
        let options = WriteOptions::new()
            .library(concat!("director-bench ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            .disable_seeking(true);
        let mut mcap = options.create(NoSeek::new(sink)).map_err(error)?;
        let mut channel = |direction: &str| {
            let about = BTreeMap::from([
                ("direction".to_owned(), direction.to_owned()),
                ("interface".to_owned(), interface.to_owned()),
            ]);
            // 0: no schema.
            mcap.add_channel(0, TOPIC, ENCODING, &about).map(|id| Channel { id, sequence: 0 }).map_err(error)
        };
        let channels = [channel("sent")?, channel("received")?];
        Ok(Self { mcap, interface: interface.to_owned(), channels, is_begun: false })
    }

    fn about(&mut self, name: &str, about: &[(&str, String)]) -> io::Result<()> {
        let metadata = about.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
        self.mcap.write_metadata(&Metadata { name: name.to_owned(), metadata }).map_err(error)
    }

    /// What log times are counted from.
    fn begin(&mut self, kept: &Kept) -> io::Result<()> {
        let start_ns = kept.unix_ns.saturating_sub(kept.time_ns);
        self.is_begun = true;
        self.about(
            "wire",
            &[
                ("interface", self.interface.clone()),
                ("log_time", "since the start of the run, by the monotonic clock".to_owned()),
                ("begun_unix_ns", start_ns.to_string()),
                ("begun_utc", clock::utc_of(start_ns)),
            ],
        )
    }
}

impl<W: Write + Seek + Send> FrameFile for McapFile<W> {
    fn frame(&mut self, kept: &Kept) -> io::Result<()> {
        if !self.is_begun {
            self.begin(kept)?;
        }
        let channel = match kept.way {
            Way::Out => &mut self.channels[0],
            Way::Back => &mut self.channels[1],
        };
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.sequence,
            log_time: kept.time_ns,
            publish_time: kept.unix_ns,
        };
        channel.sequence = channel.sequence.wrapping_add(1);
        self.mcap.write_to_known_channel(&header, kept.frame.bytes()).map_err(error)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.mcap.flush().map_err(error)
    }

    fn finish(mut self: Box<Self>, counts: TapCounts) -> io::Result<()> {
        let TapCounts { frames, lost } = counts;
        self.about("wire-counts", &[("frames", frames.to_string()), ("lost", lost.to_string())])?;
        self.mcap.finish().map_err(error)?;
        self.mcap.into_inner().into_inner().flush()
    }
}

fn error(error: McapError) -> io::Error {
    match error {
        McapError::Io(source) => source,
        other => io::Error::other(other),
    }
}
