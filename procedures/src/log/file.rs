//! The records of an MCAP file from start to end, in bounded memory.
//!
//! Two layers: this one walks the outer records (so it knows the place of each and holds its length against the file
//! before it allocates), mcap's [`LinearReader`] gets them one by one, decompresses chunks, compares checksums and hands
//! out what is inside. A chunk's checksum is compared before its first message comes out: rows are whole or absent.

use std::io::Read;

use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};

use super::MAX_RECORD_BYTES;
use super::broken::Broken;
use super::record::Section;

/// Bytes before a record's body: opcode and length.
const HEAD_BYTES: usize = 9;

/// Why there are no more records.
#[derive(Debug)]
pub(super) enum Fault {
    /// The operating system says no.
    Io(std::io::Error),
    /// Not what an MCAP file of ours looks like.
    Damaged(Broken),
}

/// What [`RecordFile::step`] has done.
pub(super) enum Step<T> {
    /// A record was visited; this is what the visitor said.
    Visited(T),
    /// The file ended as it should.
    End,
}

/// An MCAP file being read.
pub(super) struct RecordFile {
    source: Box<dyn Read + Send>,
    size_bytes: u64,
    position_bytes: u64,
    /// Where the outer record that is being visited began.
    record_at: u64,
    /// Bytes of the outer record, reused.
    record: Vec<u8>,
    reader: LinearReader,
    section: Section,
    ended: bool,
}

impl RecordFile {
    /// Starts at the beginning of a source of this size.
    pub(super) fn new(source: Box<dyn Read + Send>, size_bytes: u64) -> Self {
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(MAX_RECORD_BYTES);
        Self {
            source,
            size_bytes,
            position_bytes: 0,
            record_at: 0,
            record: Vec::new(),
            reader: LinearReader::new_with_options(options),
            section: Section::Start,
            ended: false,
        }
    }

    /// Reads the opening magic; `Ok(Err(_))` holds what stands there instead.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub(super) fn read_magic(&mut self) -> Result<Result<(), Vec<u8>>, Fault> {
        let count = usize::try_from(self.size_bytes).unwrap_or(usize::MAX).min(MAGIC.len());
        self.record.clear();
        self.read_more(count)?;
        if self.record != MAGIC {
            return Ok(Err(self.record.clone()));
        }
        self.hand_over();
        Ok(Ok(()))
    }

    /// What is wrong and where, for messages.
    pub(super) fn locate(&self, reason: &str) -> String {
        format!("{reason} (record at byte {} of {})", self.record_at, self.size_bytes)
    }

    /// Visits the next record: opcode and body. Records inside chunks come one by one, chunks themselves do not.
    ///
    /// # Errors
    /// When the file is damaged here; there is no way on from there.
    pub(super) fn step<T>(&mut self, visit: impl FnOnce(u8, &[u8]) -> T) -> Result<Step<T>, Fault> {
        loop {
            if self.ended {
                return Ok(Step::End);
            }
            match self.reader.next_event() {
                None => self.end()?,
                Some(Ok(LinearReadEvent::ReadRequest(_))) => self.feed_record()?,
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    return Ok(Step::Visited(visit(opcode, data)));
                }
                Some(Err(error)) => return Err(Fault::Damaged(in_words(error))),
            }
        }
    }

    /// Hands the next outer record (or the closing magic) to the reader.
    fn feed_record(&mut self) -> Result<(), Fault> {
        self.record_at = self.position_bytes;
        self.record.clear();
        if self.section == Section::Footed {
            self.read_more(MAGIC.len())?;
        } else {
            self.read_more(HEAD_BYTES)?;
            let (opcode, length) = head(&self.record);
            let length = usize::try_from(length).ok().filter(|&l| l <= MAX_RECORD_BYTES);
            let length = length.ok_or_else(|| Fault::Damaged(Broken::LongRecord))?;
            self.read_more(length)?;
            let body = &self.record[HEAD_BYTES..];
            self.section = self.section.after(opcode, body).map_err(Fault::Damaged)?;
        }
        self.hand_over();
        Ok(())
    }

    /// Appends this many bytes of the source to the record.
    fn read_more(&mut self, count: usize) -> Result<(), Fault> {
        let left = self.size_bytes - self.position_bytes;
        if count as u64 > left {
            return Err(Fault::Damaged(Broken::CutOff { expected: count, found: left }));
        }
        let start = self.record.len();
        self.record.resize(start + count, 0);
        self.source.read_exact(&mut self.record[start..]).map_err(Fault::Io)?;
        self.position_bytes += count as u64;
        Ok(())
    }

    /// Gives the record to mcap's reader. Never empty: zero bytes would mean the end of the file.
    fn hand_over(&mut self) {
        let count = self.record.len();
        self.reader.insert(count)[..count].copy_from_slice(&self.record);
        self.reader.notify_read(count);
    }

    fn end(&mut self) -> Result<(), Fault> {
        self.ended = true;
        match self.size_bytes - self.position_bytes {
            0 => Ok(()),
            left => Err(Fault::Damaged(Broken::BytesFollow { bytes: left })),
        }
    }
}

fn in_words(error: McapError) -> Broken {
    let (what, expected, found) = match error {
        McapError::BadChunkCrc { saved, calculated } => ("a chunk", saved, calculated),
        McapError::BadDataCrc { saved, calculated } => ("everything so far", saved, calculated),
        McapError::BadSummaryCrc { saved, calculated } => ("the summary", saved, calculated),
        other => return other.into(),
    };
    Broken::Checksum { what, expected, found }
}

/// Opcode and body length of a record.
fn head(record: &[u8]) -> (u8, u64) {
    let length = record[1..HEAD_BYTES].try_into().expect("nine bytes less one are eight");
    (record[0], u64::from_le_bytes(length))
}
