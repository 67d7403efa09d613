//! What is wrong with a record, a topic or an attachment of a log: every such sentence stands here.

use mcap::McapError;

use super::window::{MOST_CHANNELS, MOST_EVENTS, MOST_SCHEMA_BYTES, MOST_SCHEMAS, MOST_TOPICS};
use super::{Event, PLAN_FILE, PLAN_SCHEMA};

/// Why a log is none of ours, damaged, or not to be written.
#[derive(Debug, thiserror::Error)]
pub(super) enum Broken {
    #[error("topic `{name}`: expected a name like `/az` (`{taken}` is taken)")]
    TopicName { name: String, taken: &'static str },
    #[error("topic `{topic}`: expected a message like `bench_msgs/msg/Axis`, found `{found}`")]
    MessageName { topic: String, found: String },
    #[error("topic `{topic}` has no channels")]
    NoChannels { topic: String },
    #[error("topic `{topic}`: `{channel}` is not a ROS 2 field name")]
    FieldName { topic: String, channel: String },
    #[error("topic `{topic}` has two channels `{channel}`")]
    ChannelTwice { topic: String, channel: String },
    #[error("topic `{topic}`: unit {unit:?} does not fit on a line")]
    Unit { topic: String, unit: String },
    #[error("`{PLAN_FILE}`: {0}")]
    Plan(serde_json::Error),
    #[error("`{PLAN_FILE}`: expected schema {PLAN_SCHEMA}, found {found}")]
    PlanSchema { found: u32 },
    #[error("an attachment's lengths do not add up")]
    AttachmentLengths,
    #[error("expected an attachment, found a record of type {opcode:#04x}")]
    NoAttachment { opcode: u8 },
    #[error("a record of type {opcode:#04x} and {bytes} bytes is not allowed here")]
    OutOfPlace { opcode: u8, bytes: usize },
    #[error("expected a chunk compressed with `zstd`, found `{found}`")]
    Compression { found: String },
    #[error("a chunk's lengths do not add up")]
    ChunkLengths,
    #[error("a message without header")]
    NoHeader,
    #[error("a schema whose lengths do not add up")]
    SchemaLengths,
    #[error(
        "expected at most {MOST_SCHEMAS} schemas of {MOST_SCHEMA_BYTES} bytes, found one of {bytes} bytes after {others} others"
    )]
    ManySchemas { bytes: usize, others: usize },
    #[error("a channel whose lengths do not add up")]
    ChannelLengths,
    #[error(
        "expected at most {MOST_TOPICS} topics of {MOST_CHANNELS} channels, found `{topic}` of {channels}"
    )]
    ManyTopics { topic: String, channels: usize },
    #[error("a message of the unknown channel {channel}")]
    UnknownChannel { channel: u16 },
    #[error("messages are missing: expected number {expected}, found {found}")]
    MessagesMissing { expected: u32, found: u32 },
    #[error("unreadable event: {0}")]
    Event(serde_json::Error),
    #[error("time goes back in `{topic}` at {at_s} s")]
    TimeGoesBack { topic: String, at_s: f64 },
    #[error("point {point} has more samples than {most_bytes} bytes of memory hold")]
    ManySamples { point: usize, most_bytes: u64 },
    #[error("`{topic}`: {reason}")]
    Row { topic: String, reason: Box<Broken> },
    #[error("point {point} has more than {MOST_EVENTS} events")]
    ManyEvents { point: usize },
    #[error("segment {segment} of point {point} ends without having begun")]
    NotBegun { segment: usize, point: usize },
    #[error("event out of order inside {}: {event:?}", inside(*.open))]
    OutOfOrder { open: Option<usize>, event: Box<Event> },
    #[error("two attachments `{name}`")]
    AttachmentTwice { name: String },
    #[error("attachment `{name}`: expected at most {most} bytes, found {found}")]
    LargeAttachment { name: String, most: usize, found: usize },
    #[error("two topics `{name}`")]
    TopicTwice { name: String },
    #[error("JSON changes it: {json}")]
    JsonChanges { json: String },
    #[error("a number that JSON does not know: {error}: `{around}`")]
    NoJsonNumber { error: serde_json::Error, around: String },
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    #[error("{0}")]
    Mcap(#[from] McapError),
    #[error("expected a row of {expected} bytes, found {found}")]
    RowBytes { expected: usize, found: usize },
    #[error("expected encapsulation {expected:02x?}, found {found:02x?}")]
    Encapsulation { expected: [u8; 4], found: [u8; 4] },
    #[error("an impossibly long record")]
    LongRecord,
    #[error("cut off: expected {expected} more bytes, found {found}")]
    CutOff { expected: usize, found: u64 },
    #[error("{bytes} bytes follow the end of the log")]
    BytesFollow { bytes: u64 },
    #[error("ends inside point {point}, without its point-ended event")]
    EndsInside { point: usize },
    #[error("checksum of {what}: expected {expected:08x}, found {found:08x}")]
    Checksum { what: &'static str, expected: u32, found: u32 },
    #[error("expected a topic below {topics}, found {found}")]
    NoTopic { topics: usize, found: usize },
    #[error("topic {topic}: expected {expected} values a row, found {found}")]
    Values { topic: usize, expected: usize, found: usize },
}

fn inside(open: Option<usize>) -> String {
    open.map_or_else(|| "no point".to_owned(), |point| format!("point {point}"))
}
