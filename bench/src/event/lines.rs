//! Plain lines, for logs and pipes.

use std::io::Write;

use super::{Listener, RunEvent};

/// Writes one line per event to a sink.
pub struct PlainLines<W>(
    /// Where to.
    pub W,
);

impl<W: Write + Send> Listener for PlainLines<W> {
    fn hear(&mut self, event: &RunEvent) {
        if let Some(line) = line(event) {
            let _ = writeln!(self.0, "{line}");
        }
    }
}

/// The line for an event, where it deserves one.
pub(super) fn line(event: &RunEvent) -> Option<String> {
    Some(match event {
        RunEvent::RunStarted { campaign, rig, unit, procedures, planned_s, folder } => format!(
            "{campaign}: {procedures} procedures, {planned_s:.0} s planned, rig {rig}, unit {unit}, into {folder}"
        ),
        RunEvent::ProcedureStarted { procedure, points } => format!("{procedure}: {points} points"),
        RunEvent::PointEnded { procedure, point, status, reason, .. } => match reason {
            Some(reason) => format!("{procedure} [{point}]: {status}: {reason}"),
            None => return None,
        },
        RunEvent::ProcedureEnded { procedure, status } => format!("{procedure}: {status}"),
        RunEvent::Notice { text } => text.clone(),
        RunEvent::RunEnded { .. } => return None,
    })
}
