//! Orders to a simulator at the far end of a wire: where it listens, and how it is told.

use std::fs;
use std::io::{self, BufRead, BufReader, ErrorKind, Write};
use std::os::unix::fs::{DirBuilderExt, PermissionsExt};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::order::{Answer, Order};

/// How long an answer may take.
const PATIENCE: Duration = Duration::from_secs(5);

/// Gives an order to a simulator.
///
/// # Errors
/// When nobody listens at the path, or no answer comes.
pub fn tell(path: &Path, order: &Order) -> io::Result<Answer> {
    let mut stream = UnixStream::connect(path)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    let mut line = serde_json::to_string(order).map_err(io::Error::other)?;
    line.push('\n');
    stream.write_all(line.as_bytes())?;
    let mut told = String::new();
    BufReader::new(stream).read_line(&mut told)?;
    serde_json::from_str(&told).map_err(io::Error::other)
}

/// Where the simulator behind an interface listens: in a folder that only its user may enter.
///
/// # Errors
/// When the folder cannot be made, or belongs to somebody else.
pub fn path_for(interface: &str) -> io::Result<PathBuf> {
    let folder = match std::env::var_os("XDG_RUNTIME_DIR") {
        Some(own) => PathBuf::from(own).join("bench"),
        None => std::env::temp_dir().join(format!("bench-{}", rustix::process::geteuid().as_raw())),
    };
    fs::DirBuilder::new().recursive(true).mode(0o700).create(&folder)?;
    let about = fs::metadata(&folder)?;
    let owner = std::os::unix::fs::MetadataExt::uid(&about);
    if owner != rustix::process::geteuid().as_raw() || about.permissions().mode() & 0o077 != 0 {
        let why = format!("{} must belong to this user alone (mode 0700)", folder.display());
        return Err(io::Error::new(ErrorKind::PermissionDenied, why));
    }
    Ok(folder.join(format!("sim-{interface}.sock")))
}
