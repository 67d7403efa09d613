//! Writing a log.

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions};

use super::broken::Broken;
use super::cdr::Layout;
use super::message::{self, EVENTS_TOPIC};
use super::{
    Attachment, EVENTS_SCHEMA, EVENTS_SCHEMA_FILE, Event, LIBRARY, LogError, MAX_RECORD_BYTES, PLAN_FILE,
    Plan, Topic,
};

/// Log time after which a chunk is closed and handed to the sink: what a killed process loses at most.
const CHUNK_SPAN_NS: u64 = 250_000_000;

/// Uncompressed bytes after which a chunk is closed early: records without time (imports) must not grow one for ever.
const CHUNK_BYTES: usize = 8 << 20;

/// Rows are messages of ROS 2: readers of its bags open the file as it is.
const PROFILE: &str = "ros2";

/// Name of the metadata record.
const ABOUT: &str = "bench";

/// Bytes of a message record beside its payload.
const MESSAGE_OVERHEAD_BYTES: usize = 31;

/// Writes one procedure's log.
///
/// The bytes depend on what is written and on nothing else: no clock, no names of machine or version (what a metadata record says of
/// the day comes from the caller). Whoever drops a
/// writer instead of finishing it leaves a readable log whose last point lacks its end and is read as lost.
pub struct LogWriter<W: Write + Seek> {
    mcap: mcap::Writer<NoSeek<W>>,
    /// For error messages: the sink has no name.
    file: String,
    streams: Vec<Stream>,
    events: Cursor,
    chunk: Option<Chunk>,
    chunk_span_ns: u64,
}

/// One topic on its way into the file. The payload is reused from row to row.
struct Stream {
    cursor: Cursor,
    layout: Layout,
    payload: Vec<u8>,
}

/// A channel and how many messages it has seen.
struct Cursor {
    channel_id: u16,
    sequence: u32,
}

impl Cursor {
    fn next_header(&mut self, log_time_ns: u64) -> MessageHeader {
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        MessageHeader {
            channel_id: self.channel_id,
            sequence,
            log_time: log_time_ns,
            publish_time: log_time_ns,
        }
    }
}

/// The open chunk.
struct Chunk {
    began_ns: u64,
    bytes: usize,
}

impl<W: Write + Seek> LogWriter<W> {
    /// Starts a log: header, schemas, channels, attachments (the plan becomes attachment `plan.json`).
    ///
    /// The sink is only written to, never sought.
    ///
    /// # Errors
    /// When the sink cannot be written, or ([`io::ErrorKind::InvalidInput`]) when a topic has a name that ROS 2 tools
    /// refuse, the plan holds a number that JSON does not know, or an attachment is longer than 32 MiB or a second
    /// `plan.json`.
    pub fn new(sink: W, plan: &Plan, topics: &[Topic], attachments: &[Attachment]) -> Result<Self, LogError> {
        Self::about(sink, plan, topics, attachments, &BTreeMap::new())
    }

    /// As [`LogWriter::new`], with a metadata record that says what the file is about: whoever opens it elsewhere sees that without
    /// the attachments. No reader of ours looks at it.
    ///
    /// # Errors
    /// As [`LogWriter::new`].
    pub fn about(
        sink: W,
        plan: &Plan,
        topics: &[Topic],
        attachments: &[Attachment],
        about: &BTreeMap<String, String>,
    ) -> Result<Self, LogError> {
        let file = format!("{}.mcap", plan.procedure);
        let attached = attached(plan, attachments).map_err(|reason| invalid(&file, reason))?;
        check_topics(topics).map_err(|reason| invalid(&file, reason))?;
        let failed = |e: McapError| io_error(&file, e);
        let mut mcap = options().create(NoSeek::new(sink)).map_err(failed)?;
        if !about.is_empty() {
            let record = mcap::records::Metadata { name: ABOUT.to_owned(), metadata: about.clone() };
            mcap.write_metadata(&record).map_err(failed)?;
        }
        for attachment in &attached {
            attach(&mut mcap, attachment).map_err(failed)?;
        }
        let streams =
            topics.iter().map(|t| open_stream(&mut mcap, t)).collect::<Result<_, _>>().map_err(failed)?;
        // 0: no schema.
        let channel_id = mcap.add_channel(0, EVENTS_TOPIC, "json", &BTreeMap::new()).map_err(failed)?;
        Ok(Self {
            mcap,
            file,
            streams,
            events: Cursor { channel_id, sequence: 0 },
            chunk: None,
            chunk_span_ns: CHUNK_SPAN_NS,
        })
    }

    /// A writer for rows that are not being measured: nothing is lost that could not be written again, and chunks close by
    /// their size alone. A slow record would otherwise be one chunk a row, each with an entry in the summary.
    #[must_use]
    pub fn in_large_chunks(self) -> Self {
        Self { chunk_span_ns: u64::MAX, ..self }
    }

    /// Writes one row of a topic (index into `topics`), `values` in channel order; narrowed to the channels' widths.
    ///
    /// `F32` takes the nearest value (beyond its range: infinity); integers take the nearest (ties away from zero),
    /// saturate at the ends of their range, and NaN becomes 0.
    ///
    /// # Errors
    /// When the sink cannot be written, or ([`io::ErrorKind::InvalidInput`]) when there is no such topic or the row has
    /// another number of values.
    pub fn row(&mut self, topic: usize, log_time_ns: u64, values: &[f64]) -> Result<(), LogError> {
        let Some(stream) = self.streams.get(topic) else {
            return Err(invalid(&self.file, Broken::NoTopic { topics: self.streams.len(), found: topic }));
        };
        let channels = stream.layout.channel_count();
        let payload_bytes = stream.payload.len();
        if values.len() != channels {
            let found = values.len();
            return Err(invalid(&self.file, Broken::Values { topic, expected: channels, found }));
        }
        self.make_room(log_time_ns, payload_bytes)?;
        let stream = &mut self.streams[topic];
        stream.layout.encode(values, &mut stream.payload);
        let header = stream.cursor.next_header(log_time_ns);
        self.mcap.write_to_known_channel(&header, &stream.payload).map_err(|e| io_error(&self.file, e))
    }

    /// Writes an event.
    ///
    /// # Errors
    /// When the sink cannot be written, or ([`io::ErrorKind::InvalidInput`]) when the event holds a number that JSON
    /// does not know.
    pub fn event(&mut self, log_time_ns: u64, event: &Event) -> Result<(), LogError> {
        let json = json_that_reads_back(event).map_err(|reason| invalid(&self.file, reason))?;
        self.make_room(log_time_ns, json.len())?;
        let header = self.events.next_header(log_time_ns);
        self.mcap.write_to_known_channel(&header, json.as_bytes()).map_err(|e| io_error(&self.file, e))
    }

    /// Closes the chunk and flushes the sink: what was written so far can be read even if nothing follows.
    ///
    /// # Errors
    /// When the sink cannot be written.
    pub fn flush(&mut self) -> Result<(), LogError> {
        self.chunk = None;
        self.mcap.flush().map_err(|e| io_error(&self.file, e))
    }

    /// Closes the log, flushes the sink and gives it back (a file still wants its `sync_all`).
    ///
    /// # Errors
    /// When the sink cannot be written.
    pub fn finish(mut self) -> Result<W, LogError> {
        self.mcap.finish().map_err(|e| io_error(&self.file, e))?;
        Ok(self.mcap.into_inner().into_inner())
    }

    /// Closes the chunk when log time has moved on (either way) or it has grown large.
    fn make_room(&mut self, log_time_ns: u64, payload_bytes: usize) -> Result<(), LogError> {
        let span_ns = self.chunk_span_ns;
        let full = |c: &Chunk| log_time_ns.abs_diff(c.began_ns) >= span_ns || c.bytes >= CHUNK_BYTES;
        if self.chunk.as_ref().is_some_and(full) {
            self.flush()?;
        }
        let chunk = self.chunk.get_or_insert(Chunk { began_ns: log_time_ns, bytes: 0 });
        chunk.bytes += MESSAGE_OVERHEAD_BYTES + payload_bytes;
        Ok(())
    }
}

fn options() -> WriteOptions {
    WriteOptions::new()
        .library(LIBRARY)
        .profile(PROFILE)
        .compression(Some(Compression::Zstd))
        .compression_level(1)
        .compression_threads(0)
        .chunk_size(None)
        .disable_seeking(true)
}

fn open_stream<W: Write + Seek>(mcap: &mut mcap::Writer<W>, topic: &Topic) -> Result<Stream, McapError> {
    let definition = message::definition(topic);
    let schema = mcap.add_schema(&topic.message, "ros2msg", definition.as_bytes())?;
    let channel_id = mcap.add_channel(schema, &topic.name, "cdr", &BTreeMap::new())?;
    let layout = Layout::new(&topic.channels);
    let payload = layout.blank();
    Ok(Stream { cursor: Cursor { channel_id, sequence: 0 }, layout, payload })
}

/// Attaches a text at fixed times, so that the bytes depend on the text only.
fn attach<W: Write + Seek>(mcap: &mut mcap::Writer<W>, attachment: &Attachment) -> Result<(), McapError> {
    let media_type = match attachment.name.rsplit_once('.') {
        Some((_, "json")) => "application/json",
        Some((_, "toml")) => "application/toml",
        _ => "text/plain",
    };
    mcap.attach(&mcap::Attachment {
        log_time: 0,
        create_time: 0,
        name: attachment.name.clone(),
        media_type: media_type.to_owned(),
        data: attachment.text.as_bytes().into(),
    })
}

fn attached(plan: &Plan, attachments: &[Attachment]) -> Result<Vec<Attachment>, Broken> {
    let plan = Attachment { name: PLAN_FILE.to_owned(), text: json_that_reads_back(plan)? };
    let schema = Attachment { name: EVENTS_SCHEMA_FILE.to_owned(), text: EVENTS_SCHEMA.to_owned() };
    let all: Vec<Attachment> = [plan, schema].into_iter().chain(attachments.iter().cloned()).collect();
    for (k, attachment) in all.iter().enumerate() {
        if all[..k].iter().any(|a| a.name == attachment.name) {
            return Err(Broken::AttachmentTwice { name: attachment.name.clone() });
        }
        if attachment.text.len() > MAX_RECORD_BYTES / 2 {
            let most = MAX_RECORD_BYTES / 2;
            let found = attachment.text.len();
            return Err(Broken::LargeAttachment { name: attachment.name.clone(), most, found });
        }
    }
    Ok(all)
}

fn check_topics(topics: &[Topic]) -> Result<(), Broken> {
    for (k, topic) in topics.iter().enumerate() {
        message::check(topic)?;
        if topics[..k].iter().any(|t| t.name == topic.name) {
            return Err(Broken::TopicTwice { name: topic.name.clone() });
        }
    }
    Ok(())
}

/// JSON knows no NaN and no infinity: `serde_json` writes `null`, which no reader takes for a number.
fn json_that_reads_back<T>(value: &T) -> Result<String, Broken>
where
    T: serde::Serialize + serde::de::DeserializeOwned + PartialEq,
{
    let json = serde_json::to_string(value)?;
    match serde_json::from_str::<T>(&json) {
        Ok(back) if back == *value => Ok(json),
        Ok(_) => Err(Broken::JsonChanges { json }),
        Err(e) => {
            let end = if e.column() == 0 { json.len() } else { e.column() };
            let around = json.get(end.saturating_sub(100)..end).unwrap_or(&json);
            Err(Broken::NoJsonNumber { error: e, around: around.to_owned() })
        }
    }
}

fn invalid(file: &str, reason: Broken) -> LogError {
    LogError::Io {
        file: file.to_owned(),
        source: io::Error::new(io::ErrorKind::InvalidInput, reason.to_string()),
    }
}

fn io_error(file: &str, error: McapError) -> LogError {
    let source = match error {
        McapError::Io(source) => source,
        other => io::Error::other(other),
    };
    LogError::Io { file: file.to_owned(), source }
}
