//! Listeners: JSON lines for programs, plain lines for logs and pipes, a progress bar for terminals.

use std::io::Write;

use indicatif::{ProgressBar, ProgressStyle};
use reports::printable;

use super::{Listener, RunEvent};

/// Writes JSON lines to a sink.
pub struct JsonLines<W>(
    /// Where to.
    pub W,
);

impl<W: Write + Send> Listener for JsonLines<W> {
    fn hear(&mut self, event: &RunEvent) {
        // A listener that cannot write must not stop a run in motion.
        if let Ok(line) = serde_json::to_string(event) {
            let _ = self.0.write_all(format!("{}\n", without_controls(line)).as_bytes());
        }
    }
}

/// Control characters that JSON lets stand in a string; a terminal would obey them.
fn without_controls(line: String) -> String {
    if !line.contains(char::is_control) {
        return line;
    }
    let spelled = |c: char| if c.is_control() { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() };
    line.chars().map(spelled).collect()
}

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
fn line(event: &RunEvent) -> Option<String> {
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

/// A progress bar with the time left, on a terminal only. It counts planned seconds, because points differ in length by orders of magnitude.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar on stderr, where that is a terminal that can draw one.
    pub fn new() -> Option<Self> {
        let bar = ProgressBar::new(0);
        let style = "{elapsed_precise} [{bar:40}] {percent:>3} %  {eta_precise} left  {msg}";
        bar.set_style(ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()));
        (!bar.is_hidden()).then_some(Self { bar })
    }
}

impl Listener for Progress {
    fn hear(&mut self, event: &RunEvent) {
        match event {
            RunEvent::RunStarted { planned_s, .. } => self.bar.set_length(planned_s.ceil() as u64),
            RunEvent::ProcedureStarted { procedure, .. } => self.bar.set_message(printable::text(procedure)),
            RunEvent::PointEnded { planned_s, .. } => self.bar.inc(planned_s.round() as u64),
            RunEvent::RunEnded { .. } => self.bar.finish_and_clear(),
            RunEvent::ProcedureEnded { .. } | RunEvent::Notice { .. } | RunEvent::Question { .. } => {}
        }
        if let Some(line) = line(event) {
            self.bar.println(line);
        }
    }
}
