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
