//! One JSON object a line, for programs.

use std::io::Write;

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
            let _ = writeln!(self.0, "{line}");
        }
    }
}
