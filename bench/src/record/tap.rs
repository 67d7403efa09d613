//! Every frame of a run's EtherCAT interface in files: for Wireshark (`.pcapng`), and beside the logs (`.mcap`).
//!
//! A tap is no evidence: its files stand outside the run folder. The tick hands frames to a ring of fixed size and never
//! waits; a thread writes them. Frames that find no room are counted and left out.
//!
//! Time: the time since the start of the run's first session, by the monotonic clock. Where a file wants a date, that is
//! added to the UTC of that start, which is read once; the computer's clock may be set meanwhile, and no time jumps.

mod mcap_file;
mod pcapng;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use drivers::wire::{FrameSink, StoredFrame, TappedFrame, Way};
use rtrb::{Consumer, Producer, RingBuffer};

use crate::clock::{self, Clock};
use mcap_file::McapFile;
use pcapng::PcapNg;

/// Frames that wait while the disk stalls: two seconds at 4 kHz with an acyclic frame in every tick (50 MB).
const FRAMES: usize = 32_768;
/// Time of the run after which files are flushed: what a killed process loses at most.
const FLUSH_NS: u64 = 250_000_000;

/// What a file is called by its ending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// For Wireshark.
    PcapNg,
    /// For whatever reads the logs.
    Mcap,
}

impl Format {
    /// The format that a path's ending asks for.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "pcapng" => Some(Self::PcapNg),
            "mcap" => Some(Self::Mcap),
            _ => None,
        }
    }
}

/// A frame on its way into the files.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// Since the start of the run.
    time_ns: u64,
    /// Since 1970, UTC.
    unix_ns: u64,
    /// Frames that found no room since the one before.
    lost_before: u64,
    way: Way,
    frame: StoredFrame,
}

impl Kept {
    const BLANK: Self =
        Self { time_ns: 0, unix_ns: 0, lost_before: 0, way: Way::Out, frame: StoredFrame::EMPTY };
}

/// A file that frames are written to.
trait FrameFile: Send {
    fn frame(&mut self, kept: &Kept) -> io::Result<()>;

    /// What was written so far can be read even if nothing follows.
    fn flush(&mut self) -> io::Result<()>;

    fn finish(self: Box<Self>, counts: TapCounts) -> io::Result<()>;
}

/// What became of the frames of a tap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TapCounts {
    /// Frames in the files.
    pub frames: u64,
    /// Frames that found no room in the ring, and are in no file.
    pub lost: u64,
}

/// When the first session of a run began.
#[derive(Clone, Debug)]
struct Start {
    clock: Clock,
    unix_ns: u64,
}

/// What the threads share.
#[derive(Default)]
struct Shared {
    /// The ring's end for frames, while no session has it.
    ring: Mutex<Option<Producer<Kept>>>,
    lost: AtomicU64,
    is_over: AtomicBool,
    start: OnceLock<Start>,
}

/// A tap on the wire of a run, with the thread that writes its files.
pub struct WireTap {
    paths: Vec<PathBuf>,
    shared: Arc<Shared>,
    thread: JoinHandle<io::Result<u64>>,
}

impl WireTap {
    /// Creates the files, which must not exist, and starts the thread.
    ///
    /// # Errors
    /// The file that cannot be created or begun, and why; no thread.
    pub fn create(paths: &[PathBuf], interface: &str) -> Result<Self, String> {
        let named = |path: &Path, error: io::Error| format!("{}: {error}", path.display());
        let files = paths.iter().map(|path| open(path, interface).map_err(|error| named(path, error)));
        let files = files.collect::<Result<Vec<_>, _>>()?;
        let (ring, kept) = warm_ring();
        let shared = Arc::new(Shared { ring: Mutex::new(Some(ring)), ..Shared::default() });
        let seen = Arc::clone(&shared);
        let work = move || write(files, kept, &seen);
        let thread = std::thread::Builder::new().name("wire-tap".to_owned()).spawn(work);
        let thread = thread.map_err(|error| format!("cannot start a thread: {error}"))?;
        Ok(Self { paths: paths.to_vec(), shared, thread })
    }

    /// The end for frames of a session whose clock this is; `None` while another session has it.
    pub fn sink(&self, clock: &Clock) -> Option<TapSink> {
        let ring = self.shared.ring.lock().unwrap_or_else(PoisonError::into_inner).take()?;
        let unix_ns = clock::unix_ns().saturating_sub(ns(clock.now()));
        let begun = || Start { clock: clock.clone(), unix_ns };
        let start = self.shared.start.get_or_init(begun);
        let after = clock.started_after(&start.clock);
        Some(TapSink {
            ring: Some(ring),
            shared: Arc::clone(&self.shared),
            after_ns: ns(after),
            start_unix_ns: start.unix_ns,
            lost_before: 0,
        })
    }

    /// Closes the files. Those of a run that passed no frame are taken away.
    ///
    /// # Errors
    /// What the thread ran into.
    pub fn finish(self) -> Result<TapCounts, String> {
        let Self { paths, shared, thread } = self;
        shared.is_over.store(true, Ordering::Release);
        let written =
            thread.join().map_err(|_| "internal error: the thread of the tap panicked".to_owned())?;
        let names = || paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ");
        let frames = written.map_err(|error| format!("{}: {error}", names()))?;
        let counts = TapCounts { frames, lost: shared.lost.load(Ordering::Relaxed) };
        if counts == TapCounts::default() {
            for path in &paths {
                // What cannot be taken away is a file without a frame, and does no harm.
                let _ = std::fs::remove_file(path);
            }
        }
        Ok(counts)
    }
}

/// The end of a tap for the frames of one session. It goes back when the session ends.
pub struct TapSink {
    ring: Option<Producer<Kept>>,
    shared: Arc<Shared>,
    /// From the start of the first session to that of this one.
    after_ns: u64,
    start_unix_ns: u64,
    lost_before: u64,
}

impl FrameSink for TapSink {
    fn take(&mut self, frame: &TappedFrame) {
        let Some(ring) = &mut self.ring else { return };
        let time_ns = self.after_ns.saturating_add(ns(frame.at));
        let kept = Kept {
            time_ns,
            unix_ns: self.start_unix_ns.saturating_add(time_ns),
            lost_before: self.lost_before,
            way: frame.way,
            frame: frame.frame,
        };
        if ring.push(kept).is_ok() {
            self.lost_before = 0;
        } else {
            self.lost_before += 1;
            self.shared.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Drop for TapSink {
    fn drop(&mut self) {
        *self.shared.ring.lock().unwrap_or_else(PoisonError::into_inner) = self.ring.take();
    }
}

fn ns(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

/// A ring whose memory has been touched: the first frames bring no page faults into the tick.
fn warm_ring() -> (Producer<Kept>, Consumer<Kept>) {
    let (mut ring, mut kept) = RingBuffer::new(FRAMES);
    while ring.push(Kept::BLANK).is_ok() {}
    while kept.pop().is_ok() {}
    (ring, kept)
}

fn open(path: &Path, interface: &str) -> io::Result<Box<dyn FrameFile>> {
    let format = Format::of(path).ok_or_else(|| {
        io::Error::new(io::ErrorKind::InvalidInput, "expected a name that ends with `.pcapng` or `.mcap`")
    })?;
    let file = BufWriter::new(File::create_new(path)?);
    Ok(match format {
        Format::PcapNg => Box::new(PcapNg::new(file, interface)?),
        Format::Mcap => Box::new(McapFile::new(file, interface)?),
    })
}

/// Writes frames until the run is over; how many.
fn write(mut files: Vec<Box<dyn FrameFile>>, mut ring: Consumer<Kept>, shared: &Shared) -> io::Result<u64> {
    clock::give_way();
    let (mut frames, mut flushed_ns) = (0, 0);
    loop {
        // Asked before the pop: what was pushed before the end is still written.
        let is_over = shared.is_over.load(Ordering::Acquire);
        match ring.pop() {
            Ok(kept) => {
                frames += 1;
                for file in &mut files {
                    file.frame(&kept)?;
                }
                if kept.time_ns.saturating_sub(flushed_ns) >= FLUSH_NS {
                    flushed_ns = kept.time_ns;
                    for file in &mut files {
                        file.flush()?;
                    }
                }
            }
            Err(_) if is_over => break,
            Err(_) => clock::nap(),
        }
    }
    let counts = TapCounts { frames, lost: shared.lost.load(Ordering::Relaxed) };
    files.into_iter().try_for_each(|file| file.finish(counts))?;
    Ok(frames)
}
