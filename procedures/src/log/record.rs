//! MCAP records as we need them (<https://mcap.dev/spec>), parsed without trust: every length is held against the bytes
//! that are there before anything is allocated; and which records follow each other in a log of ours.
//!
//! MCAP lets a reader skip what it does not know, and so a chunk whose type was damaged would be missing without a
//! trace until the checksum at the end of the file. A log is `header metadata* attachment* (chunk message-index*)* data-end
//! summary* footer`; anything else is damage, at its place.

use mcap::records::Record;
use mcap::records::op::{self, ATTACHMENT};

use super::Attachment;
use super::broken::Broken;

/// A schema: what a channel's messages look like.
#[derive(Debug, PartialEq)]
pub(super) struct Schema {
    pub(super) id: u16,
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) text: String,
}

/// A channel: a topic and how its messages are encoded.
#[derive(Debug, PartialEq)]
pub(super) struct Channel {
    pub(super) id: u16,
    pub(super) schema_id: u16,
    pub(super) topic: String,
    pub(super) encoding: String,
}

/// A message.
#[derive(Debug, PartialEq)]
pub(super) struct Message<'a> {
    pub(super) channel_id: u16,
    pub(super) sequence: u32,
    pub(super) log_time_ns: u64,
    pub(super) payload: &'a [u8],
}

/// The rest of a record's body; taking more than there is gives `None`.
struct Body<'a>(&'a [u8]);

impl<'a> Body<'a> {
    fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(head)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*head)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<String> {
        let length = usize::try_from(self.u32()?).ok()?;
        String::from_utf8(self.bytes(length)?.to_vec()).ok()
    }
}

/// The library that wrote the file.
pub(super) fn header_library(body: &[u8]) -> Option<String> {
    let mut body = Body(body);
    let _profile = body.text()?;
    body.text()
}

/// A schema record; schemas that are no text (Protobuf) have an empty one.
pub(super) fn schema(body: &[u8]) -> Option<Schema> {
    let mut body = Body(body);
    let id = body.u16()?;
    let name = body.text()?;
    let encoding = body.text()?;
    let length = usize::try_from(body.u32()?).ok()?;
    let text = String::from_utf8(body.bytes(length)?.to_vec()).unwrap_or_default();
    Some(Schema { id, name, encoding, text })
}

/// A channel record.
pub(super) fn channel(body: &[u8]) -> Option<Channel> {
    let mut body = Body(body);
    let id = body.u16()?;
    let schema_id = body.u16()?;
    let topic = body.text()?;
    let encoding = body.text()?;
    Some(Channel { id, schema_id, topic, encoding })
}

/// A message record.
pub(super) fn message(body: &[u8]) -> Option<Message<'_>> {
    let mut body = Body(body);
    let channel_id = body.u16()?;
    let sequence = body.u32()?;
    let log_time_ns = body.u64()?;
    let _publish_time_ns = body.u64()?;
    Some(Message { channel_id, sequence, log_time_ns, payload: body.0 })
}

/// An attachment record, its checksum compared. Attachments that are no text are not ours: `Ok(None)`.
///
/// # Errors
/// When the record is not as its lengths or its checksum say.
pub(super) fn attachment(body: &[u8]) -> Result<Option<Attachment>, Broken> {
    let data_bytes = || {
        let mut body = Body(body);
        let _times = (body.u64()?, body.u64()?);
        let _names = (body.text()?, body.text()?);
        let length = usize::try_from(body.u64()?).ok()?;
        Some((length, body.0.len().checked_sub(4)?))
    };
    // Checked before mcap's parser sees it: that one trusts the lengths.
    if data_bytes().is_none_or(|(said, found)| said != found) {
        return Err(Broken::AttachmentLengths);
    }
    match mcap::parse_record(ATTACHMENT, body)? {
        Record::Attachment { header, data, .. } => {
            Ok(String::from_utf8(data.into_owned()).ok().map(|text| Attachment { name: header.name, text }))
        }
        other => Err(Broken::NoAttachment { opcode: other.opcode() }),
    }
}

/// Compression of a chunk whose lengths add up.
fn chunk_compression(body: &[u8]) -> Option<String> {
    let mut body = Body(body);
    let _times = (body.u64()?, body.u64()?);
    let _uncompressed = (body.u64()?, body.u32()?);
    let compression = body.text()?;
    let compressed_bytes = usize::try_from(body.u64()?).ok()?;
    (body.0.len() == compressed_bytes).then_some(compression)
}

/// Whether a message index is as long as it says.
fn is_message_index(body: &[u8]) -> bool {
    let mut body = Body(body);
    let length = body.u16().and_then(|_channel| body.u32());
    length.is_some_and(|l| usize::try_from(l) == Ok(body.0.len()))
}

/// Part of the file that the next record belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Section {
    /// The header must come.
    Start,
    /// Metadata and attachments, before the first chunk.
    Front,
    /// Chunks, each with its message indexes.
    Chunks,
    /// What repeats the file in short.
    Summary,
    /// Only the closing magic is left.
    Footed,
}

impl Section {
    /// The section after this record.
    ///
    /// # Errors
    /// Why the record cannot stand here.
    pub(super) fn after(self, opcode: u8, body: &[u8]) -> Result<Self, Broken> {
        match (self, opcode) {
            (Self::Start, op::HEADER) | (Self::Front, op::ATTACHMENT | op::METADATA) => Ok(Self::Front),
            (Self::Front | Self::Chunks, op::CHUNK) => check_chunk(body).map(|()| Self::Chunks),
            (Self::Chunks, op::MESSAGE_INDEX) if is_message_index(body) => Ok(Self::Chunks),
            (Self::Front | Self::Chunks, op::DATA_END) if body.len() == 4 => Ok(Self::Summary),
            (Self::Summary, op::SCHEMA | op::CHANNEL | op::STATISTICS | op::SUMMARY_OFFSET) => {
                Ok(Self::Summary)
            }
            (Self::Summary, op::CHUNK_INDEX | op::ATTACHMENT_INDEX | op::METADATA_INDEX) => Ok(Self::Summary),
            (Self::Summary, op::FOOTER) if body.len() == 20 => Ok(Self::Footed),
            _ => Err(Broken::OutOfPlace { opcode, bytes: body.len() }),
        }
    }
}

/// Uncompressed chunks are refused because mcap's reader trusts the lengths inside them.
fn check_chunk(body: &[u8]) -> Result<(), Broken> {
    match chunk_compression(body).as_deref() {
        Some("zstd") => Ok(()),
        Some(other) => Err(Broken::Compression { found: other.to_owned() }),
        None => Err(Broken::ChunkLengths),
    }
}
