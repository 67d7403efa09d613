//! The evidence index: a text that `sha256sum -c SHA256SUMS` reads.

use std::collections::BTreeMap;
use std::path::Path;

use reports::record::FileHash;

use super::INDEX;
use crate::record::durable;

/// Writes the index of a run folder.
///
/// # Errors
/// When it cannot be written.
pub fn write(folder: &Path, files: &[FileHash]) -> std::io::Result<()> {
    let lines: String = files.iter().map(|f| format!("{}  {}\n", f.sha256, f.file)).collect();
    durable::write(&folder.join(INDEX), lines.as_bytes())
}

/// How the index differs from the files; the journal counts as it was when it was closed.
pub(super) fn faults(folder: &Path, files: &[FileHash], journal: &FileHash) -> Vec<String> {
    let text = match std::fs::read_to_string(folder.join(INDEX)) {
        Ok(text) => text,
        Err(error) => return vec![format!("{INDEX}: {error}")],
    };
    let mut named = BTreeMap::new();
    let mut faults = Vec::new();
    for (number, line) in text.lines().enumerate() {
        match line.split_once("  ") {
            Some((sha256, file)) => drop(named.insert(file, sha256)),
            None => faults.push(format!("{INDEX}:{}: expected a digest and a name", number + 1)),
        }
    }
    for FileHash { file, sha256, .. } in files.iter().filter(|f| f.file != INDEX) {
        let found = if *file == journal.file { &journal.sha256 } else { sha256 };
        match named.remove(file.as_str()) {
            Some(expected) if expected == found => {}
            Some(_) => faults.push(format!("{file} does not match its digest in {INDEX}")),
            None => faults.push(format!("{file} is not in {INDEX}")),
        }
    }
    faults.extend(named.keys().map(|file| format!("{file} is missing, although {INDEX} lists it")));
    faults
}
