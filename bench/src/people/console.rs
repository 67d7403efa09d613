//! The console: what the program says on stdout (its result) and on stderr (everything else).
//!
//! A verb that moves nothing writes directly and waits for its reader, as every Unix tool does. A run must not: a
//! terminal held by Ctrl-S, or a pipe that nobody reads, may delay neither a stop nor the end of the program. After
//! [`open`], a thread for each stream writes, and whoever says something hands it over without waiting. What a stalled
//! reader leaves no room for is dropped and counted, and the count is shown when the reader goes on. The queue holds more
//! than any campaign says, so a reader that is merely slow gets everything. Nothing is lost by a drop: journal, logs and
//! results have it all.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::fs::File;
use std::io::{ErrorKind, IsTerminal, Write};
use std::os::fd::AsFd;
use std::sync::atomic::{AtomicU16, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use reports::printable;

use crate::clock::{self, Stopwatch};
use crate::people::event::{Guarded, Listener, Part, RunEvent, Shown};

#[cfg(test)]
mod tests;

/// Messages that wait for a slow reader.
const QUEUE: usize = 1 << 14;
/// So often time passes for a listener that hears nothing.
const TICK: Duration = Duration::from_millis(200);
/// At the end a reader is waited for as long as it takes something within this time, …
const STALLED_S: f64 = 0.5;
/// … and no longer than this.
const DRAIN_S: f64 = 5.0;

static CONSOLE: OnceLock<Console> = OnceLock::new();
/// Why the result could not be written.
static FAILED: OnceLock<String> = OnceLock::new();

/// Both streams of a run.
struct Console {
    result: Lane,
    notes: Lane,
}

/// Who writes on each stream.
pub(crate) struct Writers {
    /// On stdout.
    pub result: Box<dyn Listener>,
    /// On stderr, where the operator reads.
    pub notes: Box<dyn Listener>,
}

/// From now on nobody waits for stdout or stderr, a thread that panics included. A writer that panics sets `stop`.
///
/// # Errors
/// When a thread cannot be started.
pub(crate) fn open(writers: Writers, stop: &Arc<AtomicU16>) -> std::io::Result<()> {
    let result = Lane::start("stdout", writers.result, Arc::clone(stop), QUEUE)?;
    let notes = Lane::start("stderr", writers.notes, Arc::clone(stop), QUEUE)?;
    // A second run in one process says its things where the first one did.
    let _ = CONSOLE.set(Console { result, notes });
    std::panic::set_hook(Box::new(|info| {
        let thread = std::thread::current();
        note(&format!("thread `{}`: {info}", thread.name().unwrap_or("unnamed")));
        let trace = Backtrace::capture();
        if trace.status() == BacktraceStatus::Captured {
            note(&trace.to_string());
        }
    }));
    Ok(())
}

/// A result on stdout, with its line feed.
pub(crate) fn say(text: &str) {
    match CONSOLE.get() {
        Some(console) => console.result.hear(RunEvent::Notice { text: text.to_owned() }),
        None => write(stdout(), text),
    }
}

/// A result on stdout in parts, each in its colour where stdout takes any.
pub(crate) fn say_parts(parts: Vec<Part>) {
    match CONSOLE.get() {
        Some(console) => console.result.hear(RunEvent::Result { parts }),
        None => write(stdout(), &parts.into_iter().map(|part| part.text).collect::<String>()),
    }
}

/// Whether stdout shows colours: on a terminal that is no dumb one, unless `NO_COLOR` is set (no-color.org).
pub(crate) fn takes_colour() -> bool {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let plain = set("NO_COLOR").is_some() || set("TERM").is_none_or(|term| term == "dumb");
    std::io::stdout().is_terminal() && !plain
}

/// A note on stderr, with its line feed.
pub(crate) fn note(text: &str) {
    match CONSOLE.get() {
        Some(console) => console.notes.hear(RunEvent::Notice { text: text.to_owned() }),
        None => write(stderr(), text),
    }
}

fn write(sink: std::io::Result<Sink>, text: &str) {
    let text = printable::text(text);
    let _ = sink.and_then(|mut sink| sink.write_all(format!("{text}\n").as_bytes()));
}

/// Waits until both streams have taken what was said, as long as they take anything.
pub(crate) fn drain() {
    if let Some(Console { result, notes }) = CONSOLE.get() {
        drain_lanes(&[result, notes]);
    }
}

/// Why the result could not be written to stdout, if it could not. A reader that went away is no failure: that is its
/// choice.
pub(crate) fn failure() -> Option<&'static str> {
    FAILED.get().map(String::as_str)
}

/// Hands the events of a run to the streams: as results where a program reads them, else as notes.
pub(crate) struct Speaker {
    /// Events go to stdout; the operator still sees the questions.
    pub as_result: bool,
}

impl Listener for Speaker {
    fn hear(&mut self, event: &RunEvent) {
        let Some(Console { result, notes }) = CONSOLE.get() else { return };
        if !self.as_result {
            return notes.hear(event.clone());
        }
        if let RunEvent::Question { text, .. } = event {
            notes.hear(event.clone());
            // What a program has read, the operator has not seen.
            result.hear(RunEvent::Question { text: text.clone(), shown: Shown::default() });
        } else {
            result.hear(event.clone());
        }
    }
}

#[derive(Debug, Default)]
struct Counts {
    /// Handed over.
    given: AtomicU64,
    /// Of these, written.
    written: AtomicU64,
    /// Refused, because the queue was full.
    dropped: AtomicU64,
}

/// A stream with its thread.
struct Lane {
    queue: SyncSender<RunEvent>,
    counts: Arc<Counts>,
}

impl Lane {
    fn start(
        name: &str,
        listener: Box<dyn Listener>,
        stop: Arc<AtomicU16>,
        room: usize,
    ) -> std::io::Result<Self> {
        let (queue, events) = sync_channel(room);
        let counts = Arc::new(Counts::default());
        let counted = Arc::clone(&counts);
        let work = move || write_all(listener, &events, &counted, &stop);
        std::thread::Builder::new().name(name.to_owned()).spawn(work)?;
        Ok(Self { queue, counts })
    }

    /// Takes a message, or drops it. Never waits.
    fn hear(&self, event: RunEvent) {
        self.counts.given.fetch_add(1, Ordering::AcqRel);
        if self.queue.try_send(event).is_err() {
            self.counts.dropped.fetch_add(1, Ordering::AcqRel);
        }
    }

    fn written(&self) -> u64 {
        self.counts.written.load(Ordering::Acquire) + self.counts.dropped.load(Ordering::Acquire)
    }

    fn is_behind(&self) -> bool {
        self.written() < self.counts.given.load(Ordering::Acquire)
    }
}

fn write_all(
    mut listener: Box<dyn Listener>,
    events: &Receiver<RunEvent>,
    counts: &Counts,
    stop: &AtomicU16,
) {
    let mut listener = Guarded::new(listener.as_mut(), stop);
    let mut told = 0;
    loop {
        let event = match events.recv_timeout(TICK) {
            Ok(event) => event,
            Err(RecvTimeoutError::Timeout) => {
                listener.tick();
                continue;
            }
            Err(RecvTimeoutError::Disconnected) => return,
        };
        listener.hear(&event);
        if let RunEvent::Question { shown, .. } = &event {
            shown.set();
        }
        // What was dropped came after everything that was in the queue then.
        let dropped = counts.dropped.load(Ordering::Acquire);
        if dropped > told {
            let count = dropped - told;
            told = dropped;
            let text = format!("{count} messages are missing here, because the terminal did not accept them");
            listener.hear(&RunEvent::Notice { text });
        }
        counts.written.fetch_add(1, Ordering::AcqRel);
    }
}

fn drain_lanes(lanes: &[&Lane]) {
    let written = || lanes.iter().map(|lane| lane.written()).sum::<u64>();
    let begun = Stopwatch::start();
    let mut seen = written();
    let mut since = Stopwatch::start();
    while lanes.iter().any(|lane| lane.is_behind()) {
        if since.elapsed_s() > STALLED_S || begun.elapsed_s() > DRAIN_S {
            return;
        }
        clock::nap();
        let now = written();
        if now != seen {
            (seen, since) = (now, Stopwatch::start());
        }
    }
}

/// A stream as it is, without a buffer.
pub(crate) struct Sink {
    file: File,
    is_result: bool,
}

/// Stdout; a write that fails is remembered, see [`failure`].
///
/// # Errors
/// When there is none.
pub(crate) fn stdout() -> std::io::Result<Sink> {
    Ok(Sink { file: std::io::stdout().as_fd().try_clone_to_owned()?.into(), is_result: true })
}

/// Stderr.
///
/// # Errors
/// When there is none.
pub(crate) fn stderr() -> std::io::Result<Sink> {
    Ok(Sink { file: std::io::stderr().as_fd().try_clone_to_owned()?.into(), is_result: false })
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        loop {
            match self.file.write(bytes) {
                // Whoever else has this terminal made it so.
                Err(error) if error.kind() == ErrorKind::WouldBlock => clock::nap(),
                Err(error) => {
                    let is_failure = !matches!(error.kind(), ErrorKind::BrokenPipe | ErrorKind::Interrupted);
                    if self.is_result && is_failure {
                        let _ = FAILED.set(error.to_string());
                    }
                    return Err(error);
                }
                taken => return taken,
            }
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
