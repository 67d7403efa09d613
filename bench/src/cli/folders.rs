//! Folders that verbs write into: new ones only.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::output;
use crate::exit;
use crate::record::durable::OUTPUT_HELP;

/// Whether something lies in a folder.
pub(super) fn is_occupied(folder: &Path) -> bool {
    std::fs::read_dir(folder).is_ok_and(|mut inside| inside.next().is_some())
}

/// Refuses the folder of `--out` where something lies in it.
pub(super) fn must_be_free(folder: &Path) -> Result<(), u8> {
    if is_occupied(folder) {
        let shown = folder.display();
        return Err(output::mistake(&format!("--out {shown}: the folder is not empty; choose a new one")));
    }
    Ok(())
}

/// Tells that a folder or a file in it cannot be written.
pub(super) fn unwritable(folder: &Path, error: &std::io::Error) -> u8 {
    output::error(&format!("{}: {error}; {OUTPUT_HELP}", folder.display()));
    exit::BENCH
}

/// Makes the folder of `--out`, or takes an empty one.
pub(super) fn make(folder: &Path) -> Result<(), u8> {
    must_be_free(folder)?;
    std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))
}

/// Makes the folder that is asked for, or the next number below a parent.
pub(super) fn chosen(wanted: Option<&Path>, parent: &str) -> Result<PathBuf, u8> {
    match wanted {
        Some(folder) => make(folder).map(|()| folder.to_owned()),
        None => next_number(Path::new(parent)),
    }
}

/// Makes `<parent>/<n>`, one after the largest number there is; where another process has just taken that, the next.
pub(super) fn next_number(parent: &Path) -> Result<PathBuf, u8> {
    std::fs::create_dir_all(parent).map_err(|error| unwritable(parent, &error))?;
    loop {
        let taken = std::fs::read_dir(parent).ok().into_iter().flatten().flatten();
        let largest = taken.filter_map(|e| e.file_name().to_str()?.parse::<u32>().ok()).max().unwrap_or(0);
        let folder = parent.join(largest.saturating_add(1).to_string());
        match std::fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == ErrorKind::AlreadyExists && largest < u32::MAX => {}
            Err(error) => return Err(unwritable(&folder, &error)),
        }
    }
}
