//! A progress bar with the time left, on a terminal only.

use indicatif::{ProgressBar, ProgressStyle};

use super::{Listener, RunEvent, lines};

/// The bar counts planned seconds, because points differ in length by orders of magnitude.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar on stderr.
    pub fn new() -> Self {
        let bar = ProgressBar::new(0);
        let style = "{elapsed_precise} [{bar:40}] {percent:>3} %  {eta_precise} left  {msg}";
        bar.set_style(ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self { bar }
    }
}

impl Default for Progress {
    fn default() -> Self {
        Self::new()
    }
}

impl Listener for Progress {
    fn hear(&mut self, event: &RunEvent) {
        match event {
            RunEvent::RunStarted { planned_s, .. } => self.bar.set_length(planned_s.ceil() as u64),
            RunEvent::ProcedureStarted { procedure, .. } => self.bar.set_message(procedure.clone()),
            RunEvent::PointEnded { planned_s, .. } => self.bar.inc(planned_s.round() as u64),
            RunEvent::RunEnded { .. } => self.bar.finish_and_clear(),
            RunEvent::ProcedureEnded { .. } | RunEvent::Notice { .. } => {}
        }
        if let Some(line) = lines::line(event) {
            self.bar.println(line);
        }
    }
}
