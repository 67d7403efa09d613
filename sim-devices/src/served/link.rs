//! Links by which the ptys of a simulator are found at paths that stay the same.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags};

/// Folder of the ptys of a computer.
const PTYS: &str = "/dev/pts";
/// Times that a lock file may vanish between opening and locking it, because its owner ended just then.
const TRIES: u32 = 10;

/// A link to a pty. It is removed when this is dropped.
pub(super) struct Link {
    path: PathBuf,
    _lock: Lock,
}

/// A lock on a path: a file beside it that a living simulator holds. It is removed when this is dropped.
struct Lock {
    path: PathBuf,
    _held: File,
}

impl Link {
    /// Makes a link to a pty, in the place of one that an ended simulator has left behind.
    ///
    /// # Errors
    /// When a living simulator serves the path, when something else is there, or when no link can be made.
    pub(super) fn make(path: &Path, pty: &Path) -> io::Result<Self> {
        let lock = Lock::take(path)?;
        match fs::symlink_metadata(path) {
            Ok(_) if !fs::read_link(path).is_ok_and(|to| to.starts_with(PTYS)) => {
                let why = format!("{} exists and is no link to a pty; choose another path", path.display());
                return Err(io::Error::new(ErrorKind::AlreadyExists, why));
            }
            Ok(_) => fs::remove_file(path)?,
            Err(_) => {}
        }
        std::os::unix::fs::symlink(pty, path)?;
        Ok(Self { path: path.to_owned(), _lock: lock })
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

impl Lock {
    fn take(link: &Path) -> io::Result<Self> {
        let mut path = link.as_os_str().to_owned();
        path.push(".lock");
        let path = PathBuf::from(path);
        for _ in 0..TRIES {
            let flags = OFlags::RDWR | OFlags::CREATE | OFlags::NOFOLLOW | OFlags::CLOEXEC;
            let file = File::from(rustix::fs::open(&path, flags, Mode::RUSR | Mode::WUSR)?);
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let why = format!("another simulator serves {}; stop that one first", link.display());
                    return Err(io::Error::new(ErrorKind::AddrInUse, why));
                }
                Err(TryLockError::Error(error)) => return Err(error),
            }
            // Whoever held the file before may have removed it meanwhile: then this is no longer the file at the path.
            let own = file.metadata()?.ino();
            if fs::symlink_metadata(&path).is_ok_and(|found| found.ino() == own) {
                return Ok(Self { path, _held: file });
            }
        }
        Err(io::Error::new(ErrorKind::ResourceBusy, format!("{} comes and goes", path.display())))
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PTY: &str = "/dev/pts/4711";

    #[test]
    fn a_link_is_gone_with_its_simulator_and_nothing_is_left_behind() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("imu");
        let link = Link::make(&path, Path::new(PTY)).expect("made");
        assert_eq!(fs::read_link(&path).expect("there"), Path::new(PTY));
        drop(link);
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }

    #[test]
    fn a_path_that_another_simulator_serves_is_refused_and_stays_with_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("imu");
        let first = Link::make(&path, Path::new(PTY)).expect("made");
        let error = Link::make(&path, Path::new("/dev/pts/0")).err().expect("refused");
        assert_eq!(error.kind(), ErrorKind::AddrInUse);
        assert!(error.to_string().contains("another simulator serves"), "{error}");
        assert_eq!(fs::read_link(&path).expect("there"), Path::new(PTY));
        drop(first);
        assert!(Link::make(&path, Path::new(PTY)).is_ok(), "the path is free again");
    }

    #[test]
    fn a_link_that_a_killed_simulator_has_left_is_replaced_and_any_other_file_is_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let [left, other] = ["left", "other"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink("/dev/pts/0", &left).expect("left behind");
        fs::write(left.with_extension("lock"), "").expect("left behind");
        let _link = Link::make(&left, Path::new(PTY)).expect("replaced");
        assert_eq!(fs::read_link(&left).expect("there"), Path::new(PTY));
        fs::write(&other, "kept").expect("written");
        let error = Link::make(&other, Path::new(PTY)).err().expect("refused");
        assert_eq!(error.kind(), ErrorKind::AlreadyExists);
        assert_eq!(fs::read_to_string(&other).expect("there"), "kept");
        assert!(!other.with_extension("lock").exists(), "a refusal leaves no lock");
    }
}
