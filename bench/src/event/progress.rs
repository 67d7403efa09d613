//! A progress bar with the time left, on a terminal only.

use indicatif::{ProgressBar, ProgressStyle};

use reports::printable;

use super::{Listener, RunEvent, lines};

/// The bar counts planned seconds, because points differ in length by orders of magnitude.
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
        if let Some(line) = lines::line(event) {
            self.bar.println(line);
        }
    }
}
