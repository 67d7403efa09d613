//! System-wide locks: one run at a time on whatever can move something, and a mark that tells when that run was lost.
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

#[cfg(test)]
mod tests;

/// Who holds a lock, or left a mark.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Holder {
    /// Run folder, absolute.
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

/// What must be held before this rig may move; its network interface, and the rig itself where a device
/// may be real; nothing where every device is simulated in this process.
pub(crate) fn resources(rig: &Rig, bus: &str, devices: &[DeviceRecord]) -> Vec<String> {
    let interface = rig.interface().map(|name| format!("interface {name}"));
    let rig = devices.iter().any(|d| d.may_be_real).then(|| format!("{} {bus}", rig.id));
    interface.into_iter().chain(rig).collect()
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

/// Takes all resources to look at them while nothing moves: a run that was lost on one does not stand in the way. `who` stands in
/// the place of a run folder in what others are told.
///
/// # Errors
/// When somebody else holds one.
pub(crate) fn take_to_look(folder: &Path, resources: &[String], who: &Path) -> Result<Held, LockError> {
    hold(folder, resources, who)
}

fn hold(folder: &Path, resources: &[String], run: &Path) -> Result<Held, LockError> {
    let run = std::fs::canonicalize(run).unwrap_or_else(|_| run.to_owned());
    let holder = Holder { run, pid: std::process::id(), utc: utc_now() };
    let locks = resources.iter().map(|name| lock(folder, name, &holder)).collect::<Result<_, _>>()?;
    Ok(Held { holder, locks })
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
        Some(Holder { run, pid, utc }) => format!("run {} (process {pid}, since {utc})", run.display()),
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
