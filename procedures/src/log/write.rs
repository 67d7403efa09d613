//! Writing a log.

use std::io::{Seek, Write};

use super::{Attachment, Event, LogError, Plan, Topic};

/// Writes one procedure's log.
pub struct LogWriter<W: Write + Seek> {
    sink: W,
}

impl<W: Write + Seek> LogWriter<W> {
    /// Starts a log: header, schemas, channels, attachments (the plan becomes attachment `plan.json`).
    ///
    /// # Errors
    /// When the sink cannot be written.
    pub fn new(sink: W, plan: &Plan, topics: &[Topic], attachments: &[Attachment]) -> Result<Self, LogError> {
        let _ = (plan, topics, attachments, &sink);
        todo!()
    }

    /// Writes one row of a topic (index into `topics`), `values` in channel order; narrowed to the channels' widths.
    ///
    /// # Errors
    /// When the sink cannot be written.
    pub fn row(&mut self, topic: usize, log_time_ns: u64, values: &[f64]) -> Result<(), LogError> {
        let _ = (topic, log_time_ns, values, &mut self.sink);
        todo!()
    }

    /// Writes an event.
    ///
    /// # Errors
    /// When the sink cannot be written.
    pub fn event(&mut self, log_time_ns: u64, event: &Event) -> Result<(), LogError> {
        let _ = (log_time_ns, event);
        todo!()
    }

    /// Closes the log and gives the sink back.
    ///
    /// # Errors
    /// When the sink cannot be written.
    pub fn finish(self) -> Result<W, LogError> {
        todo!()
    }
}
