//! Listeners: JSON lines for programs, plain lines for logs and pipes, a line that moves for terminals.

use std::io::Write;

use indicatif::{ProgressBar, ProgressStyle};
use procedures::verdict::Verdict;
use reports::printable;
use serde::Serialize;

use super::bar::{self, Extent};
use super::{Listener, Part, RunEvent};
use crate::clock::{self, Stopwatch};
use crate::people::columns::Columns;
use crate::people::underway::Underway;

/// Where nothing else is said, a log hears so often how far the run is, s.
const SILENCE_S: f64 = 60.0;

/// Writes JSON lines to a sink, each with the time at which it was written.
pub struct JsonLines<W> {
    sink: W,
    since: Stopwatch,
}

/// A line: when, then what.
#[derive(Serialize)]
struct Timed<'a> {
    utc: String,
    elapsed_s: f64,
    #[serde(flatten)]
    event: &'a RunEvent,
}

impl<W> JsonLines<W> {
    /// Lines for this sink; `elapsed_s` counts from now.
    pub fn new(sink: W) -> Self {
        Self { sink, since: Stopwatch::start() }
    }
}

impl<W: Write + Send> Listener for JsonLines<W> {
    fn hear(&mut self, event: &RunEvent) {
        let elapsed_s = (self.since.elapsed_s() * 1e3).round() / 1e3;
        // A listener that cannot write must not stop a run in motion.
        if let Ok(line) = serde_json::to_string(&Timed { utc: clock::utc_now(), elapsed_s, event }) {
            let _ = self.sink.write_all(format!("{}\n", without_controls(line)).as_bytes());
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

/// Writes one line per event to a sink, and how far the run is where a minute passes without one.
pub struct PlainLines<W> {
    sink: W,
    underway: Underway,
    extent: Extent,
    begun: Stopwatch,
    silent: Stopwatch,
    colour: bool,
}

impl<W> PlainLines<W> {
    /// Lines for this sink, without colour.
    pub fn new(sink: W, underway: Underway) -> Self {
        let [begun, silent] = [Stopwatch::start(), Stopwatch::start()];
        Self { sink, underway, extent: Extent::default(), begun, silent, colour: false }
    }

    /// The same in colour, where the sink shows any.
    #[must_use]
    pub fn coloured(self, colour: bool) -> Self {
        Self { colour, ..self }
    }
}

impl<W: Write + Send> PlainLines<W> {
    fn write(&mut self, line: &str) {
        // In one piece: a line that is cut in two by another program's is no line.
        let _ = self.sink.write_all(format!("{line}\n").as_bytes());
        self.silent = Stopwatch::start();
    }
}

impl<W: Write + Send> Listener for PlainLines<W> {
    fn hear(&mut self, event: &RunEvent) {
        self.extent.hear(event);
        if let RunEvent::Result { parts } = event {
            let text: String = parts.iter().map(|part| painted(part, self.colour)).collect();
            self.write(&text);
        } else if let Some(line) = line(event) {
            self.write(&line);
        }
    }

    fn tick(&mut self) {
        let now = self.underway.standing();
        if self.silent.elapsed_s() > SILENCE_S && !now.is_empty() {
            let done = 100.0 * self.extent.done_ratio(&now);
            let all: Vec<String> = now.iter().map(bar::what).collect();
            let at = bar::clock(self.begun.elapsed_s());
            self.write(&printable::text(&format!("{at}, {done:.0} % done: {}", all.join("; "))));
        }
    }
}

/// A part of a result; nothing in its text steers a terminal, its colour does.
fn painted(part: &Part, colour: bool) -> String {
    let text = printable::text(&part.text);
    let code = match part.verdict.filter(|_| colour) {
        None => return text,
        Some(Verdict::Fail | Verdict::ConditionalFail) => "31;1",
        Some(Verdict::Pass) => "32",
        Some(_) => "33",
    };
    format!("\u{1b}[{code}m{text}\u{1b}[0m")
}

/// The line for an event, where it deserves one; nothing in it steers a terminal.
fn line(event: &RunEvent) -> Option<String> {
    let line = match event {
        RunEvent::RunStarted { campaign, rig, unit, procedures, planned_s, folder } => {
            let planned = bar::clock(*planned_s);
            format!(
                "{campaign}: {}, {planned} planned on the rig {rig}, unit {unit}, into {folder}",
                printable::counted(*procedures, "procedure")
            )
        }
        RunEvent::ProcedureStarted { procedure, points } => {
            format!("{procedure}: {}", printable::counted(*points, "point"))
        }
        RunEvent::PointEnded { procedure, point, status, reason, .. } => match reason {
            Some(reason) => format!("{procedure} [{point}]: {status}: {reason}"),
            None => return None,
        },
        RunEvent::ProcedureEnded { procedure, status, verdicts, .. } => {
            let each = verdicts.iter().map(|one| format!("{} {}", one.requirement, one.verdict));
            let each: Vec<String> = each.collect();
            let colon = if each.is_empty() { "" } else { "; " };
            format!("{procedure}: {status}{colon}{}", each.join(", "))
        }
        RunEvent::Notice { text } | RunEvent::Question { text, .. } => text.clone(),
        RunEvent::PointStarted { .. }
        | RunEvent::Answered { .. }
        | RunEvent::Result { .. }
        | RunEvent::RunEnded { .. } => return None,
    };
    Some(printable::text(&line))
}

/// A line at the bottom of a terminal that says how far the run is; what else is said scrolls by above it.
pub struct Progress {
    bar: ProgressBar,
    underway: Underway,
    extent: Extent,
    begun: Stopwatch,
    /// A question stands: whoever answers types on a line of their own.
    asks: bool,
}

impl Progress {
    /// A line on stderr, where that is a terminal that can draw one.
    pub fn new(underway: Underway) -> Option<Self> {
        let bar = ProgressBar::new_spinner();
        bar.set_style(
            ProgressStyle::with_template("{msg}").unwrap_or_else(|_| ProgressStyle::default_spinner()),
        );
        let is_dumb = std::env::var_os("TERM").is_none_or(|term| term == "dumb");
        let begun = Stopwatch::start();
        let usable = !bar.is_hidden() && !is_dumb;
        usable.then(|| Self { bar, underway, extent: Extent::default(), begun, asks: false })
    }

    fn draw(&self) {
        let columns = usize::from(console::Term::stderr().size().1);
        let now = self.underway.standing();
        let line = bar::line(columns, self.begun.elapsed_s(), &self.extent, &now);
        self.bar.set_message(printable::text(&line));
        self.bar.tick();
    }
}

impl Listener for Progress {
    fn hear(&mut self, event: &RunEvent) {
        self.extent.hear(event);
        match event {
            RunEvent::Question { .. } => self.asks = true,
            RunEvent::Answered { .. } | RunEvent::ProcedureEnded { .. } => self.asks = false,
            _ => {}
        }
        if let Some(line) = line(event) {
            let line = Columns::of_stderr().lines(&line);
            self.bar.suspend(|| {
                let _ = console::Term::stderr().write_line(&line);
            });
        }
        match event {
            RunEvent::RunEnded { .. } => self.bar.finish_and_clear(),
            RunEvent::Question { .. } => {
                self.bar.set_message("");
                self.bar.tick();
            }
            _ => {}
        }
    }

    fn tick(&mut self) {
        if !self.asks && !self.bar.is_finished() {
            self.draw();
        }
    }
}
