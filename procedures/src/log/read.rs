//! Reading a log, point by point.

use std::path::Path;

use super::{Attachment, Plan, Window};

/// Why a log cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The operating system says no.
    #[error("{file}: {source}")]
    Io {
        /// File.
        file: String,
        /// Cause.
        source: std::io::Error,
    },
    /// Not an MCAP file, or not one of ours: usage error.
    #[error("{file}: {reason}")]
    Foreign {
        /// File.
        file: String,
        /// What is missing.
        reason: String,
    },
    /// Ours, but damaged or cut off.
    #[error("{file}: damaged: {reason}")]
    Damaged {
        /// File.
        file: String,
        /// What and where.
        reason: String,
    },
}

/// Reads a log from start to end, one point in memory at a time.
#[derive(Debug)]
pub struct LogReader {
    _todo: (),
}

impl LogReader {
    /// Opens a log and reads plan and attachments.
    ///
    /// # Errors
    /// See [`LogError`].
    pub fn open(path: &Path) -> Result<Self, LogError> {
        let _ = path;
        todo!()
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        todo!()
    }

    /// Everything attached, `plan.json` included.
    pub fn attachments(&self) -> &[Attachment] {
        todo!()
    }

    /// The next point, or `None` at the end. A damaged log yields what is whole (the broken point as
    /// [`super::PointStatus::Lost`]), then `None`; [`LogReader::damage`] then says what is wrong.
    pub fn next_window(&mut self) -> Option<Window> {
        todo!()
    }

    /// What is wrong with the file, known after the last window.
    pub fn damage(&self) -> Option<&LogError> {
        todo!()
    }
}
