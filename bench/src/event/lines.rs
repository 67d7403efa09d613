//! Plain lines, for logs and pipes.

use std::io::Write;

use reports::printable;

use super::{Listener, RunEvent};

/// Writes one line per event to a sink.
pub struct PlainLines<W>(
    /// Where to.
    pub W,
);

impl<W: Write + Send> Listener for PlainLines<W> {
    fn hear(&mut self, event: &RunEvent) {
        if let Some(line) = line(event) {
            // In one piece: a line that is cut in two by another program's is no line.
            let _ = self.0.write_all(format!("{line}\n").as_bytes());
        }
    }
}

/// The line for an event, where it deserves one; nothing in it steers a terminal.
pub(super) fn line(event: &RunEvent) -> Option<String> {
    let line = match event {
        RunEvent::RunStarted { campaign, rig, unit, procedures, planned_s, folder } => format!(
            "{campaign}: {procedures} procedures, {planned_s:.0} s planned, rig {rig}, unit {unit}, into {folder}"
        ),
        RunEvent::ProcedureStarted { procedure, points } => format!("{procedure}: {points} points"),
        RunEvent::PointEnded { procedure, point, status, reason, .. } => match reason {
            Some(reason) => format!("{procedure} [{point}]: {status}: {reason}"),
            None => return None,
        },
        RunEvent::ProcedureEnded { procedure, status } => format!("{procedure}: {status}"),
        RunEvent::Notice { text } | RunEvent::Question { text, .. } => text.clone(),
        RunEvent::RunEnded { .. } => return None,
    };
    Some(printable::text(&line))
}
