//! Which records follow each other in a log of ours.
//!
//! MCAP lets a reader skip what it does not know, and so a chunk whose type was damaged would be missing without a
//! trace until the checksum at the end of the file. A log is `header attachment* (chunk message-index*)* data-end
//! summary* footer`; anything else is damage, at its place.

use mcap::records::op;

use super::record;

/// Part of the file that the next record belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Section {
    /// The header must come.
    Start,
    /// Attachments, before the first chunk.
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
    pub(super) fn after(self, opcode: u8, body: &[u8]) -> Result<Self, String> {
        match (self, opcode) {
            (Self::Start, op::HEADER) | (Self::Front, op::ATTACHMENT) => Ok(Self::Front),
            (Self::Front | Self::Chunks, op::CHUNK) => check_chunk(body).map(|()| Self::Chunks),
            (Self::Chunks, op::MESSAGE_INDEX) if record::is_message_index(body) => Ok(Self::Chunks),
            (Self::Front | Self::Chunks, op::DATA_END) if body.len() == 4 => Ok(Self::Summary),
            (Self::Summary, op::SCHEMA | op::CHANNEL | op::STATISTICS | op::SUMMARY_OFFSET) => {
                Ok(Self::Summary)
            }
            (Self::Summary, op::CHUNK_INDEX | op::ATTACHMENT_INDEX | op::METADATA_INDEX) => Ok(Self::Summary),
            (Self::Summary, op::FOOTER) if body.len() == 20 => Ok(Self::Footed),
            _ => Err(format!("a record of type {opcode:#04x} and {} bytes cannot stand here", body.len())),
        }
    }
}

/// Uncompressed chunks are refused because mcap's reader trusts the lengths inside them.
fn check_chunk(body: &[u8]) -> Result<(), String> {
    match record::chunk_compression(body).as_deref() {
        Some("zstd") => Ok(()),
        Some(other) => Err(format!("expected a chunk compressed with `zstd`, found `{other}`")),
        None => Err("a chunk's lengths do not add up".to_owned()),
    }
}
