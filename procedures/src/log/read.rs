//! Reading a log, point by point.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use mcap::records::op;

use super::broken::Broken;
use super::file::{Fault, RecordFile, Step};
use super::window::Assembly;
use super::{
    Attachment, EVENTS_SCHEMA_FILE, LIBRARY, PLAN_FILE, PLAN_SCHEMA, Plan, PointStatus, Window, record,
};

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
pub struct LogReader {
    file: String,
    records: RecordFile,
    assembly: Assembly,
    plan: Plan,
    attachments: Vec<Attachment>,
    damage: Option<LogError>,
    ended: bool,
}

impl fmt::Debug for LogReader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LogReader")
            .field("file", &self.file)
            .field("damage", &self.damage)
            .finish_non_exhaustive()
    }
}

impl LogReader {
    /// Opens a log and reads plan and attachments.
    ///
    /// # Errors
    /// [`LogError::Io`] when the file cannot be read; [`LogError::Foreign`] when it is no MCAP file, or one of somebody
    /// else (no attachment `plan.json` that this version reads); [`LogError::Damaged`] when it is ours but breaks off
    /// before the plan. Damage behind the plan is left to [`LogReader::damage`].
    pub fn open(path: &Path) -> Result<Self, LogError> {
        let file = path.display().to_string();
        let opened = File::open(path).and_then(|f| f.metadata().map(|m| (f, m.len())));
        match opened {
            Ok((source, size_bytes)) => Self::from_source(file, Box::new(source), size_bytes),
            Err(source) => Err(LogError::Io { file, source }),
        }
    }

    /// Opens a log that lies somewhere, of this size; `file` is what messages call it.
    pub(super) fn from_source(
        file: String,
        source: Box<dyn Read + Send>,
        bytes: u64,
    ) -> Result<Self, LogError> {
        let mut records = RecordFile::new(source, bytes);
        match records.read_magic() {
            Ok(Ok(())) => {}
            Ok(Err(found)) => {
                let magic = mcap::MAGIC.escape_ascii();
                let found = found.escape_ascii();
                let reason = format!("not an MCAP file: expected `{magic}` at its start, found `{found}`");
                return Err(LogError::Foreign { file, reason });
            }
            Err(fault) => return Err(fault.into_error(file, &records)),
        }
        let mut front = Front { assembly: Assembly::of_file(bytes), ..Front::default() };
        let fault = front.read(&mut records).err();
        let Some(text) = front.attachments.iter().find(|a| a.name == PLAN_FILE).map(|a| &a.text) else {
            return Err(front.without_plan(file, fault, &records));
        };
        let plan = parse_plan(text)
            .map_err(|reason| LogError::Foreign { file: file.clone(), reason: reason.to_string() })?;
        let damage = fault.map(|f| f.into_error(file.clone(), &records));
        let ended = damage.is_some();
        let Front { attachments, assembly, .. } = front;
        Ok(Self { file, records, assembly, plan, attachments, damage, ended })
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Everything attached, `plan.json` included.
    pub fn attachments(&self) -> &[Attachment] {
        &self.attachments
    }

    /// The next point, or `None` at the end. A damaged log yields what is whole (the broken point as
    /// [`super::PointStatus::Lost`]), then `None`; [`LogReader::damage`] then says what is wrong.
    ///
    /// Rows are whole or absent: a chunk (¼ s of log time) whose checksum does not match gives none.
    pub fn next_window(&mut self) -> Option<Window> {
        while !self.ended {
            let taken = match self.records.step(|opcode, body| self.assembly.take(opcode, body)) {
                Ok(Step::Visited(taken)) => taken.map_err(Fault::Damaged),
                Ok(Step::End) => self.check_end().map(|()| None),
                Err(fault) => Err(fault),
            };
            match taken {
                Ok(None) => {}
                Ok(Some(window)) => return Some(window),
                Err(fault) => {
                    self.damage = Some(fault.into_error(self.file.clone(), &self.records));
                    self.ended = true;
                    return self.assembly.close(PointStatus::Lost);
                }
            }
        }
        None
    }

    /// What is wrong with the file, known after the last window.
    pub fn damage(&self) -> Option<&LogError> {
        self.damage.as_ref()
    }

    fn check_end(&mut self) -> Result<(), Fault> {
        self.ended = true;
        match self.assembly.open_point() {
            None => Ok(()),
            Some(point) => Err(Fault::Damaged(Broken::EndsInside { point })),
        }
    }
}

impl Fault {
    fn into_error(self, file: String, records: &RecordFile) -> LogError {
        match self {
            Self::Io(source) => LogError::Io { file, source },
            Self::Damaged(reason) => LogError::Damaged { file, reason: records.locate(&reason.to_string()) },
        }
    }
}

/// What stands before the first message.
#[derive(Default)]
struct Front {
    library: Option<String>,
    attachments: Vec<Attachment>,
    assembly: Assembly,
}

impl Front {
    /// Reads up to the first record of the first chunk, or to the end of a file without one.
    fn read(&mut self, records: &mut RecordFile) -> Result<(), Fault> {
        loop {
            match records.step(|opcode, body| self.take(opcode, body))? {
                Step::Visited(Ok(false)) => {}
                Step::Visited(Ok(true)) | Step::End => return Ok(()),
                Step::Visited(Err(reason)) => return Err(Fault::Damaged(reason)),
            }
        }
    }

    /// Takes a record; whether it was the last one of the front.
    fn take(&mut self, opcode: u8, body: &[u8]) -> Result<bool, Broken> {
        match opcode {
            op::HEADER => self.library = record::header_library(body),
            op::ATTACHMENT => {
                // The schema of events is the same in every log: it is for other readers.
                let own = record::attachment(body)?.filter(|a| a.name != EVENTS_SCHEMA_FILE);
                self.attachments.extend(own);
            }
            op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                self.assembly.take(opcode, body)?;
                return Ok(true);
            }
            _ => {}
        }
        Ok(false)
    }

    fn without_plan(self, file: String, fault: Option<Fault>, records: &RecordFile) -> LogError {
        match (self.library, fault) {
            (Some(library), _) if library != LIBRARY => {
                let found = format!("found an MCAP file of `{library}` without it");
                LogError::Foreign {
                    file,
                    reason: format!("expected a log with attachment `{PLAN_FILE}`, {found}"),
                }
            }
            (_, Some(fault)) => fault.into_error(file, records),
            (_, None) => {
                let reason = records.locate(&format!("no attachment `{PLAN_FILE}` before the first message"));
                LogError::Damaged { file, reason }
            }
        }
    }
}

/// # Errors
/// Why the text is no plan that this version reads.
fn parse_plan(text: &str) -> Result<Plan, Broken> {
    #[derive(serde::Deserialize)]
    struct Versioned {
        schema: u32,
    }
    match serde_json::from_str::<Versioned>(text) {
        Ok(v) if v.schema == PLAN_SCHEMA => serde_json::from_str(text).map_err(Broken::Plan),
        Ok(v) => Err(Broken::PlanSchema { found: v.schema }),
        Err(e) => Err(Broken::Plan(e)),
    }
}
