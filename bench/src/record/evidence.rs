//! Whether the files of a run folder are those that its run left: whoever reads one looks first.
//!
//! The journal has every file on record with its digest ([`Entry::Kept`]) and is a chain itself; the evidence index
//! `SHA256SUMS` holds the digest of the closed journal. Together they find what was changed, cut off, removed, added or
//! swapped. They do not find out who computes the whole chain anew: that takes a signature with a key that is not in the
//! folder.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use reports::record::{EvidenceRecord, EvidenceState, FileHash};

use crate::record::journal::{self, Chain, Entry, Line, sha256_of};
use crate::record::log::SUFFIX;
use crate::record::page::{self, Page};

mod index;
mod logs;

pub use index::write as write_index;

/// The evidence index: digests of all files of the run, as `sha256sum -c` reads them.
pub const INDEX: &str = "SHA256SUMS";
/// Findings and record, as the run wrote them.
pub const RESULTS: &str = "results.json";

/// Checks a run folder.
pub fn check(folder: &Path) -> EvidenceRecord {
    let mut check = Check { folder, files: Vec::new(), altered: Vec::new(), missing: Vec::new() };
    check.take_stock();
    if [page::FILE, journal::FILE, INDEX].iter().all(|name| check.sha256(name).is_none()) {
        let reason =
            "no title page, journal or index found: this is not a run folder, or an incomplete copy of one";
        check.missing.push(reason.to_owned());
    } else {
        check.everything();
    }
    check.finish()
}

/// What is known of a folder so far.
struct Check<'a> {
    folder: &'a Path,
    /// All files of the run, as they are now.
    files: Vec<FileHash>,
    /// What speaks against the files.
    altered: Vec<String>,
    /// What cannot be checked.
    missing: Vec<String>,
}

impl Check<'_> {
    /// Names and digests of all files that a run leaves, except of documents, which anybody may write anew.
    fn take_stock(&mut self) {
        let mut names = [page::FILE, journal::FILE, RESULTS, INDEX].map(str::to_owned).to_vec();
        names.extend(logs::all(self.folder));
        names.sort();
        names.retain(|name| self.is_file(name));
        // Nearly all of a check is this, and files are independent.
        let digests: Vec<_> = names.par_iter().map(|name| sha256_of(&self.folder.join(name))).collect();
        for (file, digest) in names.into_iter().zip(digests) {
            match digest {
                Ok((sha256, size_bytes)) => self.files.push(FileHash { file, size_bytes, sha256 }),
                Err(error) => self.altered.push(format!("{file} cannot be read: {error}")),
            }
        }
    }

    /// Digest of a file as it is now.
    fn sha256(&self, file: &str) -> Option<&str> {
        self.files.iter().find(|f| f.file == file).map(|f| f.sha256.as_str())
    }

    fn everything(&mut self) {
        let page = Page::read(self.folder).map_err(|reason| self.altered.push(reason)).ok();
        let chain = Chain::read(self.folder).map_err(|reason| self.altered.push(reason)).ok();
        if let Some(chain) = &chain {
            self.opening(&chain.lines, page.as_ref());
            self.closing(chain);
            self.kept(&chain.lines, page.as_ref());
        }
        if let Some(page) = &page {
            logs::agree(self, page);
        }
    }

    /// Whether a name is that of a regular file in the folder; a link or anything else in its place is told.
    fn is_file(&mut self, name: &str) -> bool {
        match std::fs::symlink_metadata(self.folder.join(name)) {
            Ok(found) if found.is_file() => true,
            Ok(found) => {
                let sort = if found.is_symlink() { "a symbolic link" } else { "not a regular file" };
                self.altered.push(format!("{name} is {sort}: a run writes only regular files"));
                false
            }
            Err(_) => false,
        }
    }

    /// The first line belongs to the title page.
    fn opening(&mut self, lines: &[Line], page: Option<&Page>) {
        let opened = lines.iter().filter(|line| matches!(line.entry, Entry::Opened { .. })).count();
        let first = lines.first().map(|line| &line.entry);
        let Some(Entry::Opened { campaign, rig, unit, seed }) = first.filter(|_| opened == 1) else {
            // A run that was killed before it wrote a line.
            if !lines.is_empty() {
                self.altered.push(format!(
                    "{}: expected exactly one opening entry, in its first line",
                    journal::FILE
                ));
            }
            return;
        };
        let Some(page) = page else { return };
        let theirs = (campaign, rig, unit, seed);
        let ours = (&page.campaign, &page.rig_id, &page.unit, &page.seed);
        if theirs != ours {
            self.altered.push(format!(
                "{} belongs to another run: it was opened for {theirs:?}, {} says {ours:?}",
                journal::FILE,
                page::FILE
            ));
        }
    }

    /// Everything on record is there as it was, and nothing is there that is not on record.
    fn kept(&mut self, lines: &[Line], page: Option<&Page>) {
        let mut on_record: BTreeMap<&str, Option<&str>> = BTreeMap::new();
        for line in lines {
            match &line.entry {
                Entry::Kept { file, sha256, .. } => on_record.insert(file, Some(sha256)),
                Entry::Missing { file, .. } => on_record.insert(file, None),
                _ => None,
            };
        }
        if on_record.is_empty() {
            self.missing
                .push("the run was made by a version that recorded no digests of its files".to_owned());
            return logs::agree_with_results(self);
        }
        let mut faults = Vec::new();
        for (&file, &expected) in on_record.iter().filter(|(_, expected)| expected.is_some()) {
            let found = self.sha256(file);
            if found.is_none() {
                faults.push(format!("{file} is missing, although the journal has it on record"));
            } else if found != expected {
                faults.push(format!("{file} differs from the file that the journal has on record"));
            }
        }
        let is_extra = |f: &&FileHash| {
            let of_run = f.file == RESULTS || f.file.ends_with(SUFFIX);
            of_run && !matches!(on_record.get(f.file.as_str()), Some(Some(_)))
        };
        for FileHash { file, .. } in self.files.iter().filter(is_extra) {
            let planned = page.and_then(|page| page.procedures.iter().find(|p| p.log == *file));
            if planned.is_none() && page.is_some() && file != RESULTS {
                continue; // told where logs are compared with the title page
            }
            if planned.is_some_and(|planned| is_unfinished(lines, &planned.id)) {
                self.missing.push(format!("{file}: the run was lost before this log was whole"));
            } else {
                faults.push(format!("{file} is in the folder, but not on record in the journal"));
            }
        }
        self.altered.extend(faults);
    }

    /// The journal was closed, counts all its lines, and is the one in the index.
    fn closing(&mut self, chain: &Chain) {
        let is_closing = |line: &Line| matches!(line.entry, Entry::Closed { .. });
        let Some(place) = chain.lines.iter().position(is_closing) else {
            if self.sha256(INDEX).or(self.sha256(RESULTS)).is_some() {
                let cut = "there are results, but no closing entry: its end was cut off, or the run was \
                           killed at its very end";
                self.altered.push(format!("{}: {cut}", journal::FILE));
            } else {
                self.missing.push("the run was lost: its journal was never closed".to_owned());
            }
            return;
        };
        let count = place as u64 + 1;
        let counted = matches!(chain.lines[place].entry, Entry::Closed { entries, .. } if entries == count);
        let looked = |line: &Line| matches!(line.entry, Entry::Inspected { .. });
        if !counted || !chain.lines[place + 1..].iter().all(looked) || chain.cut_off {
            self.altered.push(format!(
                "{}: its number of lines does not match the count in its closing entry",
                journal::FILE
            ));
        }
        let record = |line: &Line| matches!(line.entry, Entry::Kept { .. });
        if self.sha256(INDEX).is_some() {
            self.altered.extend(index::faults(self.folder, &self.files, &chain.sealed));
        } else if chain.lines.iter().any(record) {
            let what = "is missing: a change at the end of the journal could not be detected";
            self.missing.push(format!("{INDEX} {what}"));
        }
    }

    fn finish(mut self) -> EvidenceRecord {
        let index_sha256 = self.sha256(INDEX).map(str::to_owned);
        self.files.retain(|f| f.file != INDEX);
        let Self { files, altered, missing, .. } = self;
        let (state, reasons) = match (altered.is_empty(), missing.is_empty()) {
            (true, true) => (EvidenceState::Intact, Vec::new()),
            (true, false) => (EvidenceState::NotVerifiable, missing),
            (false, _) => (EvidenceState::Altered, altered),
        };
        EvidenceRecord { state, reasons, files, index_sha256 }
    }
}

/// Whether a procedure began and its end is not in the journal: the run was killed meanwhile.
fn is_unfinished(lines: &[Line], id: &str) -> bool {
    let began = |line: &Line| matches!(&line.entry, Entry::PointStarted { procedure, .. } if procedure == id);
    let ended =
        |line: &Line| matches!(&line.entry, Entry::ProcedureEnded { procedure, .. } if procedure == id);
    let closed = |line: &Line| matches!(line.entry, Entry::Closed { .. });
    lines.iter().any(began) && !lines.iter().any(ended) && !lines.iter().any(closed)
}
