//! The journal: what happened in a run, one hash-chained JSON line an entry, on disk before anything goes on.
//!
//! Order of durability: log fsync → journal line → journal fsync → event. The first entry opens the run, the last
//! one closes it and holds the count; a journal without it belongs to a run that was lost.

use std::fs::{File, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use reports::record::FileHash;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::clock;
use crate::record::bounded;
use crate::record::durable::{self, Identity};

#[cfg(test)]
mod tests;

/// File name in the run folder.
pub const FILE: &str = "journal.jsonl";

/// Where an axis stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisAngle {
    /// Axis.
    pub axis: String,
    /// By its encoder, deg.
    pub deg: f64,
}

/// Space that is kept back, so that how a run ended can be written down on a full disk.
const RESERVE_FILE: &str = "journal.reserve";
const RESERVE_BYTES: usize = 1 << 20;

/// What an entry says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "entry")]
#[allow(missing_docs)]
pub enum Entry {
    /// The run begins.
    Opened { campaign: String, rig: String, unit: String, seed: u64 },
    /// Whether polarity is proven of what this digest stands for; `from` names the earlier run that proved it.
    Polarity { hash: String, proven: bool, fault: Option<String>, from: Option<String> },
    /// The operator answered a question; how: `terminal`, `answers file`, `--yes`, or what of the
    /// simulation answered it.
    Answered {
        procedure: String,
        prompt: String,
        class: String,
        text: String,
        answer: String,
        by: String,
        how: String,
    },
    /// A file of the run folder is whole and on disk: from now on it stays as it is. Runs of earlier versions have none.
    Kept { file: String, sha256: String, size_bytes: u64 },
    /// A file that was kept, or was being written, was gone or changed before the run was over.
    Missing { file: String, reason: String },
    /// A session begins to tick a rig that was opened for it: from here to its end the rig is watched, whatever happens
    /// between points.
    SessionOpened { log: String, devices: Vec<String> },
    /// A session ended; what tripped in it while nothing was to move.
    SessionClosed { log: String, safe: String, trips: Vec<String> },
    /// A point begins: from here to its end something may move.
    PointStarted { procedure: String, point: String },
    /// A point ended.
    PointEnded {
        procedure: String,
        point: String,
        status: String,
        reason: Option<String>,
        safe: String,
        #[serde(default)]
        angles_deg: Vec<AxisAngle>,
    },
    /// A procedure ended; its log is closed and synced.
    ProcedureEnded { procedure: String, status: String, log: Option<String>, reason: Option<String> },
    /// The run left the rig so that somebody must look before anything moves on it again.
    MustBeInspected { why: Vec<String> },
    /// Somebody looked at the rig after the run was lost; `agrees`: all angles within the tolerance of those before.
    Inspected { by: String, found: String, angles_deg: Vec<AxisAngle>, agrees: bool, released: bool },
    /// The run is over; `entries` counts all lines, this one included.
    Closed { exit_code: u8, entries: u64 },
}

/// One line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Counts from 0.
    pub n: u64,
    /// SHA-256 of the line before, without its line feed; zeros for the first.
    pub previous_sha256: String,
    /// Wall clock.
    pub utc: String,
    /// What happened.
    #[serde(flatten)]
    pub entry: Entry,
}

/// An open journal.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
    reserve: PathBuf,
    kept: Vec<FileHash>,
    length_bytes: u64,
    entries: u64,
    previous_sha256: String,
}

impl Journal {
    /// Creates the journal of a run folder. Whoever creates it owns the folder: only one of two runs can.
    ///
    /// # Errors
    /// When it exists ([`std::io::ErrorKind::AlreadyExists`]: the folder belongs to another run) or cannot be created.
    pub fn create(folder: &Path) -> std::io::Result<Self> {
        let path = folder.join(FILE);
        let file = File::create_new(&path)?;
        // Nobody else may write as long as this process lives. Where the file system knows no locks, whoever wants to
        // continue the journal does not get one either.
        let _ = file.try_lock();
        durable::sync_folder_of(&path)?;
        let reserve = folder.join(RESERVE_FILE);
        std::fs::write(&reserve, vec![0; RESERVE_BYTES])?;
        let previous_sha256 = "0".repeat(64);
        Ok(Self { file, path, reserve, kept: Vec::new(), length_bytes: 0, entries: 0, previous_sha256 })
    }

    /// Continues the journal of a run that was lost; a line that was cut off is taken away. Gives what it says.
    ///
    /// # Errors
    /// When its run is still going on, when it cannot be read or written, or its chain is broken.
    pub fn reopen(folder: &Path) -> Result<(Self, Vec<Line>), String> {
        let path = folder.join(FILE);
        let failed = |e: std::io::Error| format!("{}: {e}", path.display());
        let mut file = File::options().write(true).open(&path).map_err(failed)?;
        file.try_lock().map_err(|e| match e {
            TryLockError::WouldBlock => format!(
                "{}: the run is still going on: a process that is alive writes this journal; wait for its end or stop it",
                folder.display()
            ),
            TryLockError::Error(e) => failed(e),
        })?;
        let (lines, _) = read(folder)?;
        let text = bounded::read_to_string(&path, bounded::MOST_RECORD_BYTES).map_err(failed)?;
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let length_bytes = if whole.is_empty() { 0 } else { whole.len() as u64 + 1 };
        let last = whole.rsplit('\n').next().filter(|last| !last.is_empty());
        let previous_sha256 = last.map_or_else(|| "0".repeat(64), |last| sha256(last.as_bytes()));
        file.set_len(length_bytes).and_then(|()| file.seek(SeekFrom::End(0))).map_err(failed)?;
        let reserve = folder.join(RESERVE_FILE);
        let entries = lines.len() as u64;
        let mut journal =
            Self { file, path, reserve, kept: Vec::new(), length_bytes, entries, previous_sha256 };
        lines.iter().for_each(|line| journal.remember(&line.entry));
        Ok((journal, lines))
    }

    /// Writes an entry; it is on disk when this returns.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&mut self, entry: Entry) -> std::io::Result<()> {
        self.remember(&entry);
        let line = Line {
            n: self.entries,
            previous_sha256: self.previous_sha256.clone(),
            utc: clock::utc_now(),
            entry,
        };
        let text = serde_json::to_string(&line)?;
        let line = format!("{text}\n");
        if let Err(error) = self.append(&line) {
            self.take_back();
            // What was kept back for this moment; without it the error stands.
            std::fs::remove_file(&self.reserve).map_err(|_| error)?;
            if let Err(error) = self.append(&line) {
                self.take_back();
                return Err(error);
            }
        }
        self.length_bytes += text.len() as u64 + 1;
        self.entries += 1;
        self.previous_sha256 = sha256(text.as_bytes());
        Ok(())
    }

    fn remember(&mut self, entry: &Entry) {
        let (Entry::Kept { file, .. } | Entry::Missing { file, .. }) = entry else { return };
        self.kept.retain(|kept| kept.file != *file);
        if let Entry::Kept { file, sha256, size_bytes } = entry {
            let file = file.clone();
            let sha256 = sha256.clone();
            self.kept.push(FileHash { file, size_bytes: *size_bytes, sha256 });
        }
    }

    /// Files that the journal has on record as whole, with their digests.
    pub fn kept(&self) -> &[FileHash] {
        &self.kept
    }

    /// Half a line, or one that may not be on disk, must not stand before the next one.
    fn take_back(&mut self) {
        let _ = self.file.set_len(self.length_bytes);
        let _ = self.file.seek(SeekFrom::Start(self.length_bytes));
    }

    fn append(&mut self, line: &str) -> std::io::Result<()> {
        self.file.write_all(line.as_bytes())?;
        self.file.sync_data()
    }

    /// Writes the closing entry. Gives all files that are on record, and the journal itself as it is now.
    ///
    /// # Errors
    /// When it cannot be written, or when what was written is no longer in the run folder.
    pub fn close(mut self, exit_code: u8) -> std::io::Result<Vec<FileHash>> {
        let entries = self.entries + 1;
        self.write(Entry::Closed { exit_code, entries })?;
        // It may have been needed; a closed run has none.
        let _ = std::fs::remove_file(&self.reserve);
        if !Identity::of(&self.file)?.is_at(&self.path) {
            return Err(std::io::Error::other("it was removed or replaced while the run was going on"));
        }
        let (sha256, size_bytes) = sha256_of(&self.path)?;
        self.kept.push(FileHash { file: FILE.to_owned(), size_bytes, sha256 });
        self.kept.sort_by(|a, b| a.file.cmp(&b.file));
        Ok(self.kept)
    }
}

/// Reads a journal: all whole lines whose chain holds, and whether the run was closed.
///
/// # Errors
/// When the file cannot be read, or a line does not follow from the one before (with its number).
pub fn read(folder: &Path) -> Result<(Vec<Line>, bool), String> {
    let chain = Chain::read(folder)?;
    let closed = is_closed(&chain.lines);
    Ok((chain.lines, closed))
}

/// A journal whose chain holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Whole lines of the journal.
    pub lines: Vec<Line>,
    /// A line without end follows them: the writer was killed.
    pub cut_off: bool,
    /// Digest and length up to and including the first closing entry; those of all whole lines where there is none.
    pub sealed: FileHash,
}

impl Chain {
    /// Reads the journal of a run folder.
    ///
    /// # Errors
    /// When the file cannot be read, or a line does not follow from the one before (with its number).
    pub fn read(folder: &Path) -> Result<Self, String> {
        let path = folder.join(FILE);
        let text = bounded::read_to_string(&path, bounded::MOST_RECORD_BYTES)
            .map_err(|e| format!("{}: {e}", path.display()))?;
        let mut lines = Vec::<Line>::new();
        let mut previous = "0".repeat(64);
        let mut sealed_bytes = 0;
        let mut closed = false;
        let mut cut_off = false;
        for (number, raw) in text.split_inclusive('\n').enumerate() {
            let Some(raw) = raw.strip_suffix('\n') else {
                cut_off = true;
                break;
            };
            let place = format!("{}:{}", path.display(), number + 1);
            let line: Line =
                serde_json::from_str(raw).map_err(|e| format!("{place}: not a journal line: {e}"))?;
            if line.previous_sha256 != previous || line.n != number as u64 {
                return Err(format!(
                    "{place}: the chain is broken: this line does not follow from the one before"
                ));
            }
            previous = sha256(raw.as_bytes());
            sealed_bytes += if closed { 0 } else { raw.len() + 1 };
            closed |= matches!(line.entry, Entry::Closed { .. });
            lines.push(line);
        }
        let sealed = FileHash {
            file: FILE.to_owned(),
            size_bytes: sealed_bytes as u64,
            sha256: sha256(&text.as_bytes()[..sealed_bytes]),
        };
        Ok(Self { lines, cut_off, sealed })
    }
}

/// Whether the run came to its end; who looked at the rig later writes behind that.
fn is_closed(lines: &[Line]) -> bool {
    let of_run = lines.iter().rev().find(|line| !matches!(line.entry, Entry::Inspected { .. }));
    of_run.is_some_and(|line| matches!(line.entry, Entry::Closed { .. }))
}

/// Why somebody must look at the rig before anything moves on it again; `None` where nobody must, or somebody has and
/// released it.
pub fn must_look(lines: &[Line]) -> Option<String> {
    if matches!(lines.last(), Some(Line { entry: Entry::Inspected { released: true, .. }, .. })) {
        return None;
    }
    let why = lines.iter().find_map(|line| match &line.entry {
        Entry::MustBeInspected { why } => Some(why.join("; ")),
        _ => None,
    });
    why.or_else(|| (!is_closed(lines)).then(|| "it was lost while armed".to_owned()))
}

/// Digest in lower-case hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// Bytes that are read at a time for a digest: system calls then cost nothing beside it.
const PIECE_BYTES: usize = 1 << 20;

/// Digest and length of a file, read in pieces.
///
/// # Errors
/// When it cannot be read.
pub fn sha256_of(path: &Path) -> std::io::Result<(String, u64)> {
    let mut file = File::open(path)?;
    let mut hasher = Sha256::new();
    let mut piece = vec![0; PIECE_BYTES];
    let mut size_bytes = 0;
    loop {
        match file.read(&mut piece) {
            Ok(0) => break,
            Ok(count) => {
                hasher.update(&piece[..count]);
                size_bytes += count as u64;
            }
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok((hasher.finalize().iter().map(|b| format!("{b:02x}")).collect(), size_bytes))
}
