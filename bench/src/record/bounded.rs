//! Whole files into memory, up to a size: what is larger is refused before it is read.

use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::path::Path;

/// Largest file of a run folder that is read as a whole (`run.json`, `results.json`, `journal.jsonl`), bytes: a full
/// acceptance test leaves a tenth of that.
pub(crate) const MOST_RECORD_BYTES: u64 = 64 << 20;

/// The text of a file of at most this many bytes.
///
/// # Errors
/// The operating system's, [`ErrorKind::FileTooLarge`] for a larger file, [`ErrorKind::InvalidData`] for what is no UTF-8.
pub(crate) fn read_to_string(path: &Path, most_bytes: u64) -> std::io::Result<String> {
    let file = File::open(path)?;
    let said_bytes = file.metadata()?.len();
    if said_bytes > most_bytes {
        return Err(too_large(&format!("{said_bytes}"), most_bytes));
    }
    let mut text = String::new();
    // A device or a pipe has no length of its own.
    file.take(most_bytes + 1).read_to_string(&mut text)?;
    if text.len() as u64 > most_bytes {
        return Err(too_large(&format!("more than {most_bytes}"), most_bytes));
    }
    Ok(text)
}

fn too_large(found: &str, most_bytes: u64) -> Error {
    let message =
        format!("the file has {found} bytes; expected at most {most_bytes}: it cannot be such a file");
    Error::new(ErrorKind::FileTooLarge, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_limit_and_an_endless_one_is_refused() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("eight");
        std::fs::write(&path, "12345678").expect("writable");
        assert_eq!(read_to_string(&path, 8).expect("it fits"), "12345678");
        let message = read_to_string(&path, 7).expect_err("one too many").to_string();
        assert!(message.contains("has 8 bytes; expected at most 7"), "{message}");
        let endless = read_to_string(Path::new("/dev/zero"), 1 << 20).expect_err("no end");
        assert_eq!(endless.kind(), ErrorKind::FileTooLarge);
    }
}
