//! The recorder: takes rows out of the loop without a lock, writes the log on its own thread.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::Notice;
use procedures::log::{
    Attachment, EndedBy, Event, LatenessHistogram, LogError, LogWriter, Plan, PointStatus, STOP_SUFFIX,
    Stall, Topic,
};
use rtrb::{Consumer, Producer, PushError, RingBuffer};

use super::channels;
use crate::clock::{self, Stopwatch};
use crate::model::rig::Rig;
use crate::record::durable::Identity;
use crate::rig::devices;
use crate::rig::hearing::HearingNews;

/// Most channels that a topic may have.
pub const MAX_CHANNELS: usize = 20;

/// Rows that a ring holds where the loop waits for it: more than two seconds of three topics at 4 kHz.
const RING_ROWS: usize = 32_768;
/// Time for which a ring takes every row of every topic where the loop does not wait: a disk may stall for two seconds.
const RING_S: f64 = 2.5;
/// Rest of a writer that found its ring empty, where the loop waits for it: a few hundred ticks, a hundredth of the ring. Waking more
/// often takes a fifteenth of a processor from the simulation.
const REST: Duration = Duration::from_millis(2);

/// What goes through the ring: plain data, so that the tick never allocates; only an error has text.
#[derive(Clone, Debug)]
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

/// Events of the loop as plain data, but for the error of a device.
#[derive(Clone, Debug)]
#[allow(missing_docs)]
pub enum LoopEvent {
    PointStarted {
        point: usize,
    },
    SegmentStarted {
        point: usize,
        segment: usize,
        position_rad: f64,
    },
    SegmentEnded {
        point: usize,
        segment: usize,
        by: EndedBy,
    },
    Tripped {
        point: usize,
        trip: crate::cycle::interlock::Trip,
    },
    Stopped {
        point: usize,
        stop: crate::cycle::stops::StopNumbers,
    },
    Left {
        point: usize,
        left: crate::cycle::safe::SafeAxis,
    },
    RingHalfFull {
        point: usize,
    },
    Stall {
        point: usize,
        stall: Stall,
    },
    Noticed {
        point: usize,
        notice: Notice,
    },
    /// A device failed.
    DeviceFailed {
        point: usize,
        error: Box<DeviceError>,
    },
    /// How a device is heard, by its place in [`devices::names`].
    Heard {
        point: usize,
        device: usize,
        news: HearingNews,
    },
    Lateness {
        point: usize,
        histogram: LatenessHistogram,
    },
    PointEnded {
        point: usize,
        status: PointStatus,
    },
}

impl LoopEvent {
    fn spelled_out(self, names: &Names) -> Event {
        let axes = &names.axes;
        match self {
            Self::PointStarted { point } => Event::PointStarted { point },
            Self::SegmentStarted { point, segment, position_rad } => {
                Event::SegmentStarted { point, segment, position_rad }
            }
            Self::SegmentEnded { point, segment, by } => Event::SegmentEnded { point, segment, by },
            Self::Tripped { point, trip } => {
                Event::Tripped { point, interlock: trip.interlock.to_owned(), reason: trip.reason(axes) }
            }
            Self::RingHalfFull { point } => Event::RingHalfFull { point },
            Self::Stall { point, stall } => Event::Stall { point, stall },
            Self::Noticed { point, notice } => {
                Event::Notice { point, station: notice.station, what: notice.news.text() }
            }
            Self::DeviceFailed { point, error } => Event::DeviceNotice { point, what: error.to_string() },
            Self::Heard { point, device, news } => {
                let name = names.devices.get(device).map_or("device", String::as_str);
                Event::DeviceNotice { point, what: news.text(name) }
            }
            Self::Lateness { point, histogram } => Event::Lateness { point, histogram: Box::new(histogram) },
            Self::Left { point, left } => left.spelled_out(point, axes),
            Self::Stopped { point, stop } => stop.spelled_out(point, axes),
            Self::PointEnded { point, status } => Event::PointEnded { point, status },
        }
    }
}

/// What events call axes and devices that the loop knows by their places.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// Axes of the rig.
    pub axes: Vec<String>,
    /// Devices that are polled in the tick.
    pub devices: Vec<String>,
}

/// What a log begins with.
pub struct LogHead<'a> {
    /// What is to be carried out.
    pub plan: &'a Plan,
    /// Topics of its rows.
    pub topics: Vec<Topic>,
    /// Files that it carries.
    pub attachments: &'a [Attachment],
    /// Names in its events.
    pub names: Names,
    /// What the log is about, for whoever looks at the file alone; it depends on the day, and no finding rests on it.
    pub about: BTreeMap<String, String>,
}

impl<'a> LogHead<'a> {
    /// The head of a log without attachments: the topics are those of the rig's axes and devices.
    pub fn new(plan: &'a Plan, rig: &Rig) -> Self {
        let axes = rig.axis_names();
        let topics = channels::topics(&axes, &devices::groups(rig));
        let names = Names { axes, devices: devices::names(rig) };
        Self { plan, topics, attachments: &[], names, about: BTreeMap::new() }
    }
}

/// The loop's end of the ring.
pub struct Recorder {
    /// None: nothing is kept.
    ring: Option<Producer<Item>>,
    failed: Arc<AtomicBool>,
    /// Signs of life of the writer.
    beats: Arc<AtomicU64>,
    waits: bool,
    /// Rows that the ring holds.
    capacity: usize,
    /// Index of the first topic for the ticks of stops.
    stops_from: u8,
    /// An item was refused: the log is no longer complete.
    lost: bool,
    patience_s: f64,
    thread: Option<JoinHandle<Result<(), LogError>>>,
    path: PathBuf,
    /// Which file `path` must still be in the end; `None` over any other sink.
    identity: Option<Identity>,
}

impl Recorder {
    /// Creates the log and starts its thread. `waits`: whether a full ring makes the loop wait (virtual tier).
    ///
    /// # Errors
    /// When the log cannot be created.
    pub fn start(path: &Path, head: LogHead<'_>, waits: bool) -> Result<Self, LogError> {
        let file = File::create_new(path).map_err(|e| io_error(path, e))?;
        let identity = Some(Identity::of(&file).map_err(|e| io_error(path, e))?);
        let log = Log { sink: file, sync: File::sync_all, path: path.to_owned() };
        Ok(Self { identity, ..Self::over(log, head, waits)? })
    }

    /// A recorder that writes to any sink.
    ///
    /// # Errors
    /// When the head of the log cannot be written.
    pub fn over<W: Write + Seek + Send + 'static>(
        log: Log<W>,
        head: LogHead<'_>,
        waits: bool,
    ) -> Result<Self, LogError> {
        let LogHead { plan, topics, attachments, names, about } = head;
        let Log { sink, sync, path } = log;
        let sink = BufWriter::with_capacity(1 << 20, sink);
        let writer = LogWriter::about(sink, plan, &topics, attachments, &about)?;
        let (ring, consumer) =
            if waits { RingBuffer::new(RING_ROWS) } else { touched_ring(plan, topics.len()) };
        let capacity = ring.buffer().capacity();
        let is_of_stops = |topic: &Topic| topic.name.ends_with(STOP_SUFFIX);
        let stops_from = topics.iter().position(is_of_stops).unwrap_or(topics.len()) as u8;
        let failed = Arc::new(AtomicBool::new(false));
        let beats = Arc::new(AtomicU64::new(0));
        let told = Arc::clone(&failed);
        let shown = path.clone();
        let alive = Arc::clone(&beats);
        let work = move || {
            let rows = Inlet { ring: consumer, waits };
            let result = write_all(writer, sync, rows, &topics, &names, &shown, &alive);
            told.store(result.is_err(), Ordering::Release);
            result
        };
        let thread = std::thread::Builder::new().name("recorder".to_owned()).spawn(work);
        let thread = Some(thread.map_err(|e| io_error(&path, e))?);
        let ring = Some(ring);
        let lost = false;
        let patience_s = PATIENCE_S;
        let identity = None;
        Ok(Self {
            ring,
            failed,
            beats,
            waits,
            capacity,
            stops_from,
            lost,
            patience_s,
            thread,
            path,
            identity,
        })
    }

    /// Waits this long, in real seconds, for a writer that gives no sign of life.
    pub fn with_patience(self, patience_s: f64) -> Self {
        Self { patience_s, ..self }
    }

    /// A recorder that keeps nothing: for benchmarks of the loop alone.
    pub fn discarding() -> Self {
        let (failed, beats) = Default::default();
        Self {
            ring: None,
            failed,
            beats,
            waits: false,
            capacity: 1,
            stops_from: 0,
            lost: false,
            patience_s: PATIENCE_S,
            thread: None,
            path: PathBuf::new(),
            identity: None,
        }
    }

    /// Whether anything is kept: rows need not be made otherwise.
    pub fn keeps(&self) -> bool {
        self.ring.is_some()
    }

    /// Hands an item over. A full ring waits in the virtual tier; in real time the item is refused.
    pub fn push(&mut self, item: Item) -> bool {
        let Some(ring) = &mut self.ring else { return true };
        let mut item = item;
        let mut patience = Patience::new(&self.beats, self.patience_s);
        loop {
            match ring.push(item) {
                Ok(()) => return true,
                Err(PushError::Full(back))
                    if self.waits && !self.lost && !gone(&self.failed, ring) && !patience.is_over() =>
                {
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

    /// Hands over the row of an axis of one tick of a stop.
    pub fn push_stop(&mut self, axis: usize, time_ns: u64, values: [f64; MAX_CHANNELS]) -> bool {
        self.push(Item::Row { topic: self.stops_from + axis as u8, time_ns, values })
    }

    /// Whether the loop waits for the writer instead of losing rows: only where time is virtual.
    pub fn waits(&self) -> bool {
        self.waits
    }

    /// Share of the ring that is taken.
    pub fn ring_ratio(&self) -> f64 {
        self.ring.as_ref().map_or(0.0, |ring| 1.0 - ring.slots() as f64 / self.capacity as f64)
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
        let beats = Arc::clone(&self.beats);
        let lost = self.lost;
        let identity = self.identity;
        let mut patience = Patience::new(&beats, self.patience_s);
        drop(self); // the ring's end tells the writer to close
        while !thread.is_finished() {
            if patience.is_over() {
                let reason = "the log writer does not respond: rows not yet written are lost".to_owned();
                return Err(LogError::Damaged { file: path.display().to_string(), reason });
            }
            clock::nap();
        }
        let damaged =
            |reason: &str| LogError::Damaged { file: path.display().to_string(), reason: reason.to_owned() };
        thread.join().unwrap_or_else(|_| Err(damaged("the writer thread panicked")))?;
        if lost {
            return Err(damaged("rows were lost: the log writer did not keep up"));
        }
        if identity.is_some_and(|identity| !identity.is_at(&path)) {
            return Err(damaged("it was removed or replaced while it was being written"));
        }
        crate::record::durable::sync_folder_of(&path).map_err(|e| io_error(&path, e))
    }
}

/// A ring whose memory is there before the first tick: a page that is touched for the first time takes its time.
fn touched_ring(plan: &Plan, topics: usize) -> (Producer<Item>, Consumer<Item>) {
    let rows = (RING_S * plan.loop_rate_hz * topics as f64).ceil().max(RING_ROWS as f64) as usize;
    let (mut ring, mut consumer) = RingBuffer::new(rows);
    let nothing = || Item::Row { topic: 0, time_ns: 0, values: [0.0; MAX_CHANNELS] };
    while ring.push(nothing()).is_ok() {}
    while consumer.pop().is_ok() {}
    (ring, consumer)
}

/// Where a log goes, and how it is made to last.
pub struct Log<W> {
    /// Takes the bytes.
    pub sink: W,
    /// Brings them to where they survive a loss of power.
    pub sync: fn(&W) -> std::io::Result<()>,
    /// Name of the file in errors.
    pub path: PathBuf,
}

/// How long a writer may give no sign of life: a disk that is busy takes seconds.
const PATIENCE_S: f64 = 30.0;

/// Waits for a writer as long as it does anything.
struct Patience<'a> {
    beats: &'a AtomicU64,
    seen: u64,
    limit_s: f64,
    watch: Stopwatch,
}

impl<'a> Patience<'a> {
    fn new(beats: &'a AtomicU64, limit_s: f64) -> Self {
        Self { beats, seen: beats.load(Ordering::Relaxed), limit_s, watch: Stopwatch::start() }
    }

    fn is_over(&mut self) -> bool {
        let beats = self.beats.load(Ordering::Relaxed);
        if beats != self.seen {
            (self.seen, self.watch) = (beats, Stopwatch::start());
        }
        self.watch.elapsed_s() > self.limit_s
    }
}

/// A writer that panicked cannot say so, but its end of the ring is gone.
fn gone(failed: &AtomicBool, ring: &Producer<Item>) -> bool {
    failed.load(Ordering::Acquire) || ring.is_abandoned()
}

/// What the writer takes from.
struct Inlet {
    ring: Consumer<Item>,
    /// Whether the loop waits where the ring is full.
    waits: bool,
}

fn write_all<W: Write + Seek>(
    mut writer: LogWriter<BufWriter<W>>,
    sync: fn(&W) -> std::io::Result<()>,
    mut inlet: Inlet,
    topics: &[Topic],
    names: &Names,
    path: &Path,
    beats: &AtomicU64,
) -> Result<(), LogError> {
    loop {
        beats.fetch_add(1, Ordering::Relaxed);
        // Asked before the pop: what was pushed before the producer left is still taken.
        let abandoned = inlet.ring.is_abandoned();
        match inlet.ring.pop() {
            Ok(Item::Row { topic, time_ns, values }) => {
                let topic = usize::from(topic);
                writer.row(topic, time_ns, &values[..topics[topic].channels.len()])?;
            }
            Ok(Item::Event { time_ns, event }) => writer.event(time_ns, &event.spelled_out(names))?,
            Err(_) if abandoned => break,
            Err(_) if inlet.waits => clock::rest(REST),
            Err(_) => clock::nap(),
        }
    }
    let sink = writer.finish()?;
    let sink = sink.into_inner().map_err(|e| io_error(path, e.into_error()))?;
    sync(&sink).map_err(|e| io_error(path, e))
}

fn io_error(path: &Path, source: std::io::Error) -> LogError {
    LogError::Io { file: path.display().to_string(), source }
}
