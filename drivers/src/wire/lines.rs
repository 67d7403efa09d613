//! Lines of the operating system: serial ports, TCP connections and UDP ports, as [`ByteLine`](super::ByteLine) and
//! [`DatagramPort`](super::DatagramPort).
//!
//! The host's end of a line is a pair of rings. One thread moves bytes between the rings and the operating system, for all
//! lines of a session. So no call in the tick waits for a serial port or a socket. A write is followed by one call of the system
//! that wakes the thread and never waits.
//!
//! A byte has arrived when the thread has read it, on the clock of the run. [`ByteLine::read`](super::ByteLine::read) gives what
//! had arrived by its `now` and leaves what came later: what a tick sees depends on its time and not on when in the tick the
//! line is read.
//!
//! Timeouts are those of the drivers. A line that is silent is not gone.

mod address;
mod host;
mod mover;
mod ring;
mod serial;
mod shared;
mod socket;
#[cfg(test)]
mod tests;

use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use tokio::runtime::{Builder, Handle, Runtime};
use tokio::sync::oneshot;
use tokio::task;
use tokio::time::timeout;

pub use address::{LINE_SORTS, LineAddress};
pub use host::{HostLine, HostPort};

use crate::device::DeviceError;
use host::LONGEST_DATAGRAM_BYTES;
use mover::{LONGEST_LINGER, SharedClock, Sort, Wire};
use ring::{Drain, Feed, RingSize, ring};
use shared::{Shared, failure};

/// Longest time that closing takes: what serial ports still send, and a little for all else.
const LONGEST_CLOSING: Duration = LONGEST_LINGER.saturating_add(Duration::from_millis(100));
/// Rings of a socket: several answers of an instrument, or 8192 messages of a tracker.
const SOCKET_RING: RingSize = RingSize { bytes: 256 << 10, chunks: 8192 };
/// Smallest ring of a serial port.
const LEAST_SERIAL_BYTES: usize = 8192;
/// Ring of what is to be sent; a datagram of any length fits.
const OUT_RING: RingSize = RingSize { bytes: 64 << 10, chunks: 1024 };

/// All lines of a session, and the thread that moves their bytes.
///
/// The thread is an ordinary one that inherits priority and processors from whoever starts it.
pub struct Lines {
    clock: SharedClock,
    runtime: Handle,
    open: Vec<OpenLine>,
    stop: Option<oneshot::Sender<Vec<task::JoinHandle<()>>>>,
    thread: Option<JoinHandle<()>>,
}

/// A line that was opened, and the task that ends it.
struct OpenLine {
    shared: Arc<Shared>,
    sending: task::JoinHandle<()>,
}

/// The host's rings of a line.
struct Ends {
    shared: Arc<Shared>,
    out: Feed,
    back: Drain,
    back_bytes: usize,
}

impl Lines {
    /// Starts the thread. The clock gives the time since the start of the run, of the monotonic clock; it stamps what arrives.
    ///
    /// # Errors
    /// When the operating system has no thread or no event queue left.
    pub fn start(clock: Box<dyn Fn() -> Duration + Send + Sync>) -> Result<Self, DeviceError> {
        let failed = |what: &str, error: std::io::Error| DeviceError::Bus {
            device: "lines".to_owned(),
            reason: format!("{what}: {error}"),
        };
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime =
            runtime.map_err(|error| failed("no event queue for serial ports and sockets", error))?;
        let handle = runtime.handle().clone();
        let (stop, stopped) = oneshot::channel();
        let run = move || move_bytes(&runtime, stopped);
        let thread = std::thread::Builder::new().name("lines".to_owned()).spawn(run);
        let thread = thread.map_err(|error| failed("no thread for serial ports and sockets", error))?;
        Ok(Self {
            clock: Arc::from(clock),
            runtime: handle,
            open: Vec::new(),
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Opens a serial port or connects to a TCP port. Waits up to 3 s for each address of the host, so it has no place in the tick.
    ///
    /// # Errors
    /// When the port cannot be had, or no connection is made.
    pub fn open_line(&mut self, address: &LineAddress) -> Result<HostLine, DeviceError> {
        let name = address.to_string();
        let (sort, fd, size) = match address {
            LineAddress::Serial { path, baud } => {
                (Sort::Serial { baud: *baud }, serial::open(&name, path, *baud)?, serial_ring(*baud))
            }
            LineAddress::Tcp { host, port } => {
                (Sort::Tcp, socket::connect_tcp(&name, host, *port)?, SOCKET_RING)
            }
            LineAddress::Udp { .. } => {
                let help = "give the device a `serial:` or `tcp:` address";
                return Err(failure(&name, "address", "a line of bytes", "a port of datagrams", help));
            }
        };
        let Ends { shared, out, back, back_bytes } = self.attach(name, sort, fd, size)?;
        Ok(HostLine::new(shared, out, back, back_bytes))
    }

    /// Opens a UDP port. Waits for the host's name to be looked up, so it has no place in the tick.
    ///
    /// # Errors
    /// When the port cannot be had.
    pub fn open_port(&mut self, address: &LineAddress) -> Result<HostPort, DeviceError> {
        let name = address.to_string();
        let LineAddress::Udp { host, port, bind } = address else {
            let help = "give the device a `udp:` address";
            return Err(failure(&name, "address", "a port of datagrams", "a line of bytes", help));
        };
        let fd = socket::connect_udp(&name, host, *port, *bind)?;
        let Ends { shared, out, back, back_bytes } = self.attach(name, Sort::Udp, fd, SOCKET_RING)?;
        Ok(HostPort::new(shared, out, back, back_bytes))
    }

    /// Starts the tasks of a line.
    fn attach(&mut self, name: String, sort: Sort, fd: OwnedFd, size: RingSize) -> Result<Ends, DeviceError> {
        let help = "close other programs that have many files open";
        let none_left = |error: std::io::Error| {
            failure(&name, "line", "a place in the event queue", error.to_string(), help)
        };
        let shared = Arc::new(Shared::new(name.clone()).map_err(|errno| none_left(errno.into()))?);
        let _inside = self.runtime.enter();
        let wire = Arc::new(Wire::new(sort, fd).map_err(none_left)?);
        let (arriving, back) = ring(size);
        let (out, leaving) = ring(OUT_RING);
        let received =
            mover::receive(Arc::clone(&wire), Arc::clone(&shared), arriving, Arc::clone(&self.clock));
        let receiver = self.runtime.spawn(received).abort_handle();
        let sent = mover::send(wire, Arc::clone(&shared), leaving, Arc::clone(&self.clock), receiver);
        let sending = self.runtime.spawn(sent);
        self.open.retain(|line| !line.sending.is_finished());
        self.open.push(OpenLine { shared: Arc::clone(&shared), sending });
        Ok(Ends { shared, out, back, back_bytes: size.bytes })
    }
}

impl Drop for Lines {
    /// Closes all lines; what was written still goes out. Ends within 0.3 s.
    fn drop(&mut self) {
        let lines = std::mem::take(&mut self.open);
        lines.iter().for_each(|line| line.shared.close());
        let sending = lines.into_iter().map(|line| line.sending).collect();
        if let Some(stop) = self.stop.take()
            && stop.send(sending).is_ok()
            && let Some(thread) = self.thread.take()
        {
            // A thread that panicked has nothing left to be waited for.
            let _ = thread.join();
        }
    }
}

/// A second of a serial port, in chunks of 8 bytes on average.
fn serial_ring(baud: u32) -> RingSize {
    let bytes = (baud as usize / 10).max(LEAST_SERIAL_BYTES);
    RingSize { bytes, chunks: bytes / 8 }
}

/// Runs all tasks until the session ends, then those that still send for a while.
fn move_bytes(runtime: &Runtime, stopped: oneshot::Receiver<Vec<task::JoinHandle<()>>>) {
    runtime.block_on(async {
        let sending = stopped.await.unwrap_or_default();
        let ended = async {
            for task in sending {
                // A task that panicked is over, too.
                let _ = task.await;
            }
        };
        let _ = timeout(LONGEST_CLOSING, ended).await;
    });
}

const _: () = assert!(OUT_RING.bytes >= LONGEST_DATAGRAM_BYTES);
