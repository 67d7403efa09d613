//! System-wide locks: one process at a time on each interface, serial port and instrument, and a mark that tells when a run was
//! lost on what can move something.
//!
//! A lock is a file that its owner holds with `flock`; the operating system lets it go when the process dies. Beside it
//! lies the mark of an armed run. A clean end removes the mark; one that lies there without an owner names a run that
//! died while it could move the axes.

use std::fs::{File, OpenOptions, Permissions, TryLockError};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use reports::record::DeviceRecord;
use serde::{Deserialize, Serialize};

use crate::clock::utc_now;
use crate::model::rig::Rig;
use crate::record::journal;

mod claim;
#[cfg(test)]
mod tests;

pub(crate) use claim::{Claim, claim, claim_wires, far_ends, lines};

/// Who holds a lock, or left a mark.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Holder {
    /// Verb of the program that holds it, for one that is no run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verb: Option<String>,
    /// Run folder, absolute; empty for a holder that is no run.
    pub run: PathBuf,
    /// Process.
    pub pid: u32,
    /// Since when, by the wall clock.
    pub utc: String,
}

/// Why a resource cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Somebody has it.
    #[error("{resource} is in use by {by}; wait until it ends or stop it")]
    Held {
        /// What is locked.
        resource: String,
        /// Who holds it.
        by: String,
    },
    /// The last run on it died, or left it so that somebody must look.
    #[error("run {run}: {why}: inspect the rig, then run `bench inspect {run}`")]
    Lost {
        /// Folder of the lost run.
        run: String,
        /// What happened.
        why: String,
    },
    /// The last run on it died, and its mark does not say which it was.
    #[error(
        "{file} marks a run that was lost while armed, but does not say which: inspect the rig, then delete that file"
    )]
    LostUnnamed {
        /// The mark.
        file: String,
    },
    /// The lock file itself.
    #[error("{file}: {source}; a lock file must be writable by everybody who runs the bench")]
    File {
        /// Lock file or mark.
        file: String,
        /// Cause.
        source: std::io::Error,
    },
}

/// Resources that belong to this run until it lets go of them.
#[derive(Debug)]
pub struct Held {
    holder: Holder,
    locks: Vec<Lock>,
    /// Lines, on which no mark is left.
    _lines: Claim,
}

#[derive(Debug)]
struct Lock {
    /// Open for as long as the lock is held.
    _file: File,
    mark: PathBuf,
}

/// Where lock files lie: the system's folder for them where it lets us, else the one for temporary files.
pub(crate) fn system_folder() -> PathBuf {
    let theirs = ["/run/lock", "/var/lock"].map(PathBuf::from);
    let writable = |folder: &PathBuf| {
        let probe = folder.join(format!("bench-{}.probe", std::process::id()));
        let made = File::create_new(&probe).is_ok();
        let _ = std::fs::remove_file(&probe);
        made
    };
    theirs.into_iter().find(writable).unwrap_or_else(std::env::temp_dir)
}

/// What must be held before a rig is opened: its network interface.
pub(crate) fn interfaces(rig: &Rig) -> Vec<String> {
    rig.interface().map(|name| format!("interface {name}")).into_iter().collect()
}

/// What must be held before this rig may move: the rig itself where a device may be real; nothing where every device is
/// simulated.
pub(crate) fn rig_itself(rig: &Rig, bus: &str, devices: &[DeviceRecord]) -> Vec<String> {
    devices.iter().any(|d| d.may_be_real).then(|| format!("{} {bus}", rig.id)).into_iter().collect()
}

/// Takes all resources for a run, or none.
///
/// # Errors
/// When somebody else holds one, or when the last run on it was lost and nobody has looked yet.
pub(crate) fn take(folder: &Path, resources: &[String], run: &Path) -> Result<Held, LockError> {
    let held = hold(folder, resources, run)?;
    for lock in &held.locks {
        if let Some((lost, why)) = lost_run(&lock.mark)? {
            return Err(LockError::Lost { run: lost.display().to_string(), why });
        }
    }
    Ok(held)
}

/// Takes all resources to look at a run that was lost: its own marks do not stand in the way.
///
/// # Errors
/// When somebody else holds one, or when yet another run was lost on it.
pub(crate) fn take_to_inspect(folder: &Path, resources: &[String], run: &Path) -> Result<Held, LockError> {
    let held = hold(folder, resources, run)?;
    for lock in &held.locks {
        if let Some((lost, why)) = lost_run(&lock.mark)?.filter(|(lost, _)| *lost != held.holder.run) {
            return Err(LockError::Lost { run: lost.display().to_string(), why });
        }
    }
    Ok(held)
}

fn hold(folder: &Path, resources: &[String], run: &Path) -> Result<Held, LockError> {
    let holder = Holder::run(run);
    let locks = locked(folder, resources, &holder)?;
    Ok(Held { holder, locks, _lines: Claim::default() })
}

fn locked(folder: &Path, resources: &[String], holder: &Holder) -> Result<Vec<Lock>, LockError> {
    resources.iter().map(|name| lock(folder, name, holder)).collect()
}

impl Holder {
    /// A run that writes to this folder.
    pub(crate) fn run(folder: &Path) -> Self {
        let run = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
        Self { verb: None, run, pid: std::process::id(), utc: utc_now() }
    }

    /// A verb of the program that is no run.
    pub(crate) fn verb(name: &str) -> Self {
        Self { verb: Some(name.to_owned()), run: PathBuf::new(), pid: std::process::id(), utc: utc_now() }
    }
}

fn lock(folder: &Path, resource: &str, holder: &Holder) -> Result<Lock, LockError> {
    let path = folder.join(format!("bench-{}.lock", sanitised(resource)));
    let failed = |source| LockError::File { file: path.display().to_string(), source };
    let mut file = open(&path).map_err(failed)?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            return Err(LockError::Held { resource: resource.to_owned(), by: whose(&path) });
        }
        Err(TryLockError::Error(source)) => return Err(failed(source)),
    }
    let text = serde_json::to_string(holder).map_err(|e| failed(e.into()))?;
    file.set_len(0).and_then(|()| file.write_all(text.as_bytes())).map_err(failed)?;
    Ok(Lock { _file: file, mark: path.with_extension("armed") })
}

/// Opens a lock file, made for everybody. A file of somebody else is not created over: in a folder that all may write
/// to, the system forbids that.
fn open(path: &Path) -> std::io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    match options.open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        other => return other,
    }
    match options.clone().create_new(true).open(path) {
        Ok(file) => {
            file.set_permissions(Permissions::from_mode(0o666))?;
            Ok(file)
        }
        // Somebody else made it in between.
        Err(error) if error.kind() == ErrorKind::AlreadyExists => options.open(path),
        Err(error) => Err(error),
    }
}

fn sanitised(resource: &str) -> String {
    resource.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect()
}

fn whose(path: &Path) -> String {
    match read(path) {
        Some(Holder { verb: Some(verb), pid, utc, .. }) => {
            format!("`bench {verb}` (process {pid}, since {utc})")
        }
        Some(Holder { run, pid, utc, .. }) => format!("run {} (process {pid}, since {utc})", run.display()),
        None => format!("an unidentified process ({})", path.display()),
    }
}

fn read(path: &Path) -> Option<Holder> {
    serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
}

/// The run that a mark names and why somebody must look, unless its journal says that it ended in order or that somebody
/// has looked. A mark that cannot be read stands for a lost run all the same.
fn lost_run(mark: &Path) -> Result<Option<(PathBuf, String)>, LockError> {
    if !mark.exists() {
        return Ok(None);
    }
    let unnamed = || LockError::LostUnnamed { file: mark.display().to_string() };
    let holder = read(mark).ok_or_else(unnamed)?;
    let why = match journal::read(&holder.run) {
        Ok((lines, _)) => journal::must_look(&lines),
        Err(error) => Some(format!("it was lost while armed, and its journal cannot be read ({error})")),
    };
    Ok(why.map(|why| (holder.run, why)))
}

impl Held {
    /// With lines that were claimed for the same run.
    #[must_use]
    pub(crate) fn with_lines(self, lines: Claim) -> Self {
        Self { _lines: lines, ..self }
    }

    /// Takes more resources for the same run, all or none.
    ///
    /// # Errors
    /// As [`take`].
    pub(crate) fn take_more(mut self, folder: &Path, resources: &[String]) -> Result<Self, LockError> {
        let more = take(folder, resources, &self.holder.run)?;
        self.locks.extend(more.locks);
        Ok(self)
    }

    /// Marks the run as armed; from now on only [`Held::release`] tells that it ended well.
    ///
    /// # Errors
    /// When a mark cannot be written.
    pub fn arm(&self) -> Result<(), LockError> {
        for lock in &self.locks {
            let failed = |source| LockError::File { file: lock.mark.display().to_string(), source };
            // A mark that is left over here is one of an ended run; it may belong to somebody else.
            let _ = std::fs::remove_file(&lock.mark);
            let mut file = open(&lock.mark).map_err(failed)?;
            let text = serde_json::to_string(&self.holder).map_err(|e| failed(e.into()))?;
            file.write_all(text.as_bytes()).and_then(|()| file.sync_data()).map_err(failed)?;
        }
        Ok(())
    }

    /// Whether there is anything to be held: nothing where every device is simulated.
    pub fn holds_anything(&self) -> bool {
        !self.locks.is_empty()
    }

    /// Takes the marks away and lets go: the rig was left in order.
    pub fn release(self) {
        for lock in &self.locks {
            let _ = std::fs::remove_file(&lock.mark);
        }
    }
}
