//! The recorder: takes rows out of the loop without a lock, writes the log on its own thread.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use procedures::log::{Attachment, EndedBy, Event, LogError, LogWriter, Plan, PointStatus, Topic};
use rtrb::{Consumer, Producer, PushError, RingBuffer};

use crate::clock;

/// Most channels that a topic may have.
pub const MAX_CHANNELS: usize = 16;

/// Rows that the ring holds: more than two seconds of three topics at 4 kHz.
const RING_ROWS: usize = 32_768;

/// What goes through the ring: plain data, so that the tick never allocates.
#[derive(Clone, Copy, Debug)]
pub enum Item {
    /// A row of a topic.
    Row {
        /// Index of the topic.
        topic: u8,
        /// Log time.
        time_ns: u64,
        /// Values, in channel order; the topic says how many count.
        values: [f64; MAX_CHANNELS],
    },
    /// An event.
    Event {
        /// Log time.
        time_ns: u64,
        /// What happened.
        event: LoopEvent,
    },
}

/// Events of the loop as plain data.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)]
pub enum LoopEvent {
    PointStarted { point: usize },
    SegmentStarted { point: usize, segment: usize, position_rad: f64 },
    SegmentEnded { point: usize, segment: usize, by: EndedBy },
    Tripped { point: usize, trip: crate::interlock::Trip },
    PointEnded { point: usize, status: PointStatus },
}

impl LoopEvent {
    fn spelled_out(self, axes: &[String]) -> Event {
        match self {
            Self::PointStarted { point } => Event::PointStarted { point },
            Self::SegmentStarted { point, segment, position_rad } => {
                Event::SegmentStarted { point, segment, position_rad }
            }
            Self::SegmentEnded { point, segment, by } => Event::SegmentEnded { point, segment, by },
            Self::Tripped { point, trip } => {
                Event::Tripped { point, interlock: trip.interlock.to_owned(), reason: trip.reason(axes) }
            }
            Self::PointEnded { point, status } => Event::PointEnded { point, status },
        }
    }
}

/// The loop's end of the ring.
pub struct Recorder {
    /// None: nothing is kept.
    ring: Option<Producer<Item>>,
    failed: Arc<AtomicBool>,
    waits: bool,
    /// An item was refused: the log is no longer complete.
    lost: bool,
    thread: Option<JoinHandle<Result<(), LogError>>>,
    path: PathBuf,
}

impl Recorder {
    /// Creates the log and starts its thread. `waits`: whether a full ring makes the loop wait (virtual tier).
    ///
    /// # Errors
    /// When the log cannot be created.
    pub fn start(
        path: &Path,
        plan: &Plan,
        topics: Vec<Topic>,
        attachments: &[Attachment],
        axes: Vec<String>,
        waits: bool,
    ) -> Result<Self, LogError> {
        let file = File::create_new(path).map_err(|e| io_error(path, e))?;
        let writer = LogWriter::new(BufWriter::with_capacity(1 << 20, file), plan, &topics, attachments)?;
        let (ring, consumer) = RingBuffer::new(RING_ROWS);
        let failed = Arc::new(AtomicBool::new(false));
        let (told, shown) = (Arc::clone(&failed), path.to_owned());
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || {
                let result = write_all(writer, consumer, &topics, &axes, &shown);
                told.store(result.is_err(), Ordering::Release);
                result
            })
            .map_err(|e| io_error(path, e))?;
        let (ring, thread) = (Some(ring), Some(thread));
        Ok(Self { ring, failed, waits, lost: false, thread, path: path.to_owned() })
    }

    /// A recorder that keeps nothing: for benchmarks of the loop alone.
    pub fn discarding() -> Self {
        let failed = Arc::new(AtomicBool::new(false));
        Self { ring: None, failed, waits: false, lost: false, thread: None, path: PathBuf::new() }
    }

    /// Whether anything is kept: rows need not be made otherwise.
    pub fn keeps(&self) -> bool {
        self.ring.is_some()
    }

    /// Hands an item over. A full ring waits in the virtual tier; in real time the item is refused.
    pub fn push(&mut self, item: Item) -> bool {
        let Some(ring) = &mut self.ring else { return true };
        let mut item = item;
        loop {
            match ring.push(item) {
                Ok(()) => return true,
                Err(PushError::Full(back)) if self.waits && !gone(&self.failed, ring) => {
                    item = back;
                    clock::nap();
                }
                Err(PushError::Full(_)) => {
                    self.lost = true;
                    return false;
                }
            }
        }
    }

    /// Whether the writer has given up (disk full, device gone).
    pub fn failed(&self) -> bool {
        self.lost || self.ring.as_ref().is_some_and(|ring| gone(&self.failed, ring))
    }

    /// Closes the log: everything handed over is on disk when this returns.
    ///
    /// # Errors
    /// What the writer ran into.
    pub fn finish(mut self) -> Result<(), LogError> {
        let Some(thread) = self.thread.take() else { return Ok(()) };
        let path = std::mem::take(&mut self.path);
        drop(self); // the ring's end tells the writer to close
        thread.join().unwrap_or_else(|_| {
            Err(LogError::Damaged {
                file: path.display().to_string(),
                reason: "the writer thread panicked".into(),
            })
        })
    }
}

/// A writer that panicked cannot say so, but its end of the ring is gone.
fn gone(failed: &AtomicBool, ring: &Producer<Item>) -> bool {
    failed.load(Ordering::Acquire) || ring.is_abandoned()
}

fn write_all(
    mut writer: LogWriter<BufWriter<File>>,
    mut ring: Consumer<Item>,
    topics: &[Topic],
    axes: &[String],
    path: &Path,
) -> Result<(), LogError> {
    loop {
        // Asked before the pop: what was pushed before the producer left is still taken.
        let abandoned = ring.is_abandoned();
        match ring.pop() {
            Ok(Item::Row { topic, time_ns, values }) => {
                let topic = usize::from(topic);
                writer.row(topic, time_ns, &values[..topics[topic].channels.len()])?;
            }
            Ok(Item::Event { time_ns, event }) => writer.event(time_ns, &event.spelled_out(axes))?,
            Err(_) if abandoned => break,
            Err(_) => clock::nap(),
        }
    }
    let sink = writer.finish()?;
    let file = sink.into_inner().map_err(|e| io_error(path, e.into_error()))?;
    file.sync_all().map_err(|e| io_error(path, e))
}

fn io_error(path: &Path, source: std::io::Error) -> LogError {
    LogError::Io { file: path.display().to_string(), source }
}
