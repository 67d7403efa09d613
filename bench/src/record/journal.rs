//! The journal: what happened in a run, one JSON line per entry. The lines form a hash chain. Each line is on disk before
//! the run goes on.
//!
//! Order of writing: log fsync → journal line → journal fsync → event. The first entry opens the run. The closing entry
//! holds the number of entries; a journal without one belongs to a run that was lost. Only inspections may follow it.

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

/// Angle of an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisAngle {
    /// Name of the axis.
    pub axis: String,
    /// Angle by the axis' encoder, deg.
    pub deg: f64,
}

/// Reserve file: it is deleted when the disk is full, to make room for the entries that end the run.
const RESERVE_FILE: &str = "journal.reserve";
const RESERVE_BYTES: usize = 1 << 20;

/// What an entry says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "entry")]
#[allow(missing_docs)]
pub enum Entry {
    /// The run begins.
    Opened { campaign: String, rig: String, unit: String, seed: u64 },
    /// Whether polarity is proven for the configuration with the digest `hash`; `from` is the earlier run that proved it.
    Polarity { hash: String, proven: bool, fault: Option<String>, from: Option<String> },
    /// The operator answered a question. `how` is `terminal`, `answers file`, `--yes`, or the part of the simulation that
    /// answered.
    Answered {
        procedure: String,
        prompt: String,
        class: String,
        text: String,
        answer: String,
        by: String,
        how: String,
    },
    /// A file of the run folder is complete, on disk and final. Runs of earlier versions have no such entries.
    Kept { file: String, sha256: String, size_bytes: u64 },
    /// A file that was final or being written disappeared or changed during the run.
    Missing { file: String, reason: String },
    /// A session begins to run the cycle of a rig opened for it. The rig is watched until the session ends, between points
    /// too.
    SessionOpened { log: String, devices: Vec<String> },
    /// A session ended. `trips` are those outside of points, while nothing was commanded to move.
    SessionClosed { log: String, safe: String, trips: Vec<String> },
    /// A point begins. Until it ends axes may move.
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
    /// The run left the rig in a state that must be inspected before any further motion.
    MustBeInspected { why: Vec<String> },
    /// Somebody inspected the rig after the run. `agrees`: every angle is within the tolerance of the last one in the
    /// journal. `released`: motion is allowed again.
    Inspected { by: String, found: String, angles_deg: Vec<AxisAngle>, agrees: bool, released: bool },
    /// The run is over; `entries` counts all lines, this one included.
    Closed { exit_code: u8, entries: u64 },
}

/// One line of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Number of the line, from 0.
    pub n: u64,
    /// SHA-256 of the previous line without its line feed; 64 zeros in the first line.
    pub previous_sha256: String,
    /// Time of writing, UTC by the wall clock.
    pub utc: String,
    /// What happened.
    #[serde(flatten)]
    pub entry: Entry,
}

/// A journal open for writing. `kept` are the files that it records as final.
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
    /// Creates the journal of a run folder. The process that creates it owns the folder.
    ///
    /// # Errors
    /// When it exists ([`std::io::ErrorKind::AlreadyExists`]: the folder belongs to another run) or cannot be created.
    pub fn create(folder: &Path) -> std::io::Result<Self> {
        let path = folder.join(FILE);
        let file = File::create_new(&path)?;
        // No other process may write while this one lives. An error is ignored: on a file system without locks `reopen`
        // gets no lock either, and fails.
        let _ = file.try_lock();
        durable::sync_folder_of(&path)?;
        let reserve = folder.join(RESERVE_FILE);
        std::fs::write(&reserve, vec![0; RESERVE_BYTES])?;
        let previous_sha256 = "0".repeat(64);
        Ok(Self { file, path, reserve, kept: Vec::new(), length_bytes: 0, entries: 0, previous_sha256 })
    }

    /// Continues the journal of a run that has ended or was lost, and gives its lines. An incomplete last line is removed.
    ///
    /// # Errors
    /// When the run is still going on, when the journal cannot be read or written, or when its chain is broken.
    pub fn reopen(folder: &Path) -> Result<(Self, Vec<Line>), String> {
        let path = folder.join(FILE);
        let failed = |e: std::io::Error| format!("{}: {e}", path.display());
        let mut file = File::options().write(true).open(&path).map_err(failed)?;
        file.try_lock().map_err(|e| match e {
            TryLockError::WouldBlock => format!(
                "{}: the run is still in progress: a running process writes this journal; wait until it \
                 ends or stop it",
                folder.display()
            ),
            TryLockError::Error(e) => failed(e),
        })?;
        let (lines, _) = read(folder)?;
        let text = bounded::read_to_string(&path, bounded::MOST_RECORD_BYTES).map_err(failed)?;
        // All complete lines, without the last line feed.
        let complete = text.rfind('\n').map_or("", |end| &text[..end]);
        let length_bytes = if complete.is_empty() { 0 } else { complete.len() as u64 + 1 };
        let last = complete.rsplit('\n').next().filter(|last| !last.is_empty());
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
        let line = Line {
            n: self.entries,
            previous_sha256: self.previous_sha256.clone(),
            utc: clock::utc_now(),
            entry,
        };
        let text = serde_json::to_string(&line)?;
        let entry = line.entry;
        let line = format!("{text}\n");
        if let Err(error) = self.append(&line) {
            self.take_back();
            // The reserve makes room on a full disk. If it is already used up, the first error is the result.
            std::fs::remove_file(&self.reserve).map_err(|_| error)?;
            if let Err(error) = self.append(&line) {
                self.take_back();
                return Err(error);
            }
        }
        self.length_bytes += text.len() as u64 + 1;
        self.entries += 1;
        self.previous_sha256 = sha256(text.as_bytes());
        self.remember(&entry);
        Ok(())
    }

    /// Brings the list of final files up to date with an entry.
    fn remember(&mut self, entry: &Entry) {
        let (Entry::Kept { file, .. } | Entry::Missing { file, .. }) = entry else { return };
        self.kept.retain(|kept| kept.file != *file);
        if let Entry::Kept { file, sha256, size_bytes } = entry {
            let file = file.clone();
            let sha256 = sha256.clone();
            self.kept.push(FileHash { file, size_bytes: *size_bytes, sha256 });
        }
    }

    /// Files that the journal records as final, with their digests.
    pub fn kept(&self) -> &[FileHash] {
        &self.kept
    }

    /// Removes what a failed write left behind: the next line must follow directly after the last good one.
    fn take_back(&mut self) {
        let _ = self.file.set_len(self.length_bytes);
        let _ = self.file.seek(SeekFrom::Start(self.length_bytes));
    }

    fn append(&mut self, line: &str) -> std::io::Result<()> {
        self.file.write_all(line.as_bytes())?;
        self.file.sync_data()
    }

    /// Writes the closing entry. Gives all final files by name, the closed journal among them.
    ///
    /// # Errors
    /// When it cannot be written, or when what was written is no longer in the run folder.
    pub fn close(mut self, exit_code: u8) -> std::io::Result<Vec<FileHash>> {
        let entries = self.entries + 1;
        self.write(Entry::Closed { exit_code, entries })?;
        // An error is ignored: the reserve may have been used up already.
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

/// Reads a journal: all complete lines, and whether the run was closed. The chain is checked.
///
/// # Errors
/// When the file cannot be read, or a line does not follow from the one before (with its number).
pub fn read(folder: &Path) -> Result<(Vec<Line>, bool), String> {
    let chain = Chain::read(folder)?;
    let closed = is_closed(&chain.lines);
    Ok((chain.lines, closed))
}

/// A journal whose hash chain is unbroken.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Whole lines of the journal.
    pub lines: Vec<Line>,
    /// An incomplete line follows: the writer was killed.
    pub cut_off: bool,
    /// Digest and length up to and including the first closing entry. Without a closing entry: of all complete lines.
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
                    "{place}: the hash chain is broken: this line does not follow from the line before"
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

/// Whether the run was closed. Inspections may follow the closing entry.
fn is_closed(lines: &[Line]) -> bool {
    let last_of_run = lines.iter().rev().find(|line| !matches!(line.entry, Entry::Inspected { .. }));
    last_of_run.is_some_and(|line| matches!(line.entry, Entry::Closed { .. }))
}

/// Why the rig must be inspected before any further motion. `None` where it need not be, or where the last entry is an
/// inspection that released it.
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

/// SHA-256 in lower-case hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// Bytes read at a time for a digest: so many that system calls cost little beside the hashing.
const PIECE_BYTES: usize = 1 << 20;

/// SHA-256 in lower-case hexadecimal and length in bytes of a file, read in pieces.
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
