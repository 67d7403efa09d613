//! Files that are whole or not there: written beside, brought to the disk, renamed.
//!
//! Whoever reads such a file finds what was there before or what was written, never half of it, also after a full disk
//! or a loss of power.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Advice for output that cannot be written.
pub(crate) const OUTPUT_HELP: &str =
    "check that the folder exists, is writable and has free space, or choose another --out";

/// Writes a file, or leaves the one that is there as it was.
///
/// # Errors
/// When it cannot be written; nothing of it is left behind.
pub(crate) fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    write_with(path, |file| file.write_all(content))
}

fn write_with(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let beside = beside(path)?;
    let written = create(&beside).and_then(|mut file| {
        fill(&mut file)?;
        file.sync_all()
    });
    let renamed = written.and_then(|()| std::fs::rename(&beside, path));
    if renamed.is_err() {
        let _ = std::fs::remove_file(&beside);
    }
    renamed.and_then(|()| sync_folder_of(path))
}

/// Brings the entries of the folder in which a path lies to the disk: a file is not found again without its name.
///
/// # Errors
/// When the folder cannot be opened or synced.
pub(crate) fn sync_folder_of(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

/// Which file it is, whatever it is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    device: u64,
    inode: u64,
}

impl Identity {
    /// Of an open file.
    ///
    /// # Errors
    /// When the system does not say.
    pub(crate) fn of(file: &File) -> io::Result<Self> {
        file.metadata().map(|metadata| Self { device: metadata.dev(), inode: metadata.ino() })
    }

    /// Whether this very file is what a path names: not removed, not replaced, no link to it.
    pub(crate) fn is_at(self, path: &Path) -> bool {
        let found = std::fs::symlink_metadata(path);
        found.is_ok_and(|found| (found.dev(), found.ino()) == (self.device, self.inode))
    }
}

/// A hidden name in the same folder, so that the rename stays inside one file system; of this process alone.
fn beside(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}.part", std::process::id()));
    Ok(path.with_file_name(hidden))
}

/// Whatever has this name was left by a process of the same number that died.
fn create(beside: &Path) -> io::Result<File> {
    match File::create_new(beside) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            std::fs::remove_file(beside)?;
            File::create_new(beside)
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let all = std::fs::read_dir(folder).expect("readable").flatten();
        all.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_disk_that_is_full_half_way_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("results.json");
        write(&path, b"whole").expect("writable");
        let full = write_with(&path, |file| {
            file.write_all(b"ha")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        assert_eq!(full.expect_err("full").kind(), io::ErrorKind::StorageFull);
        assert_eq!(std::fs::read(&path).expect("readable"), b"whole");
        assert_eq!(names(folder.path()), ["results.json"]);
    }

    #[test]
    fn a_link_is_replaced_and_what_it_leads_to_is_left_alone() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("report.html");
        let other = folder.path().join("of somebody else");
        std::fs::write(&other, "theirs").expect("writable");
        std::os::unix::fs::symlink(&other, &path).expect("a link");
        write(&path, b"ours").expect("writable");
        assert_eq!(std::fs::read(&other).expect("readable"), b"theirs");
        assert_eq!(std::fs::read(&path).expect("readable"), b"ours");
    }
}
