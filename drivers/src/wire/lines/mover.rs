//! The tasks that move bytes between the operating system and rings: two a line, all in one thread.

use std::io;
use std::os::fd::{AsFd, AsRawFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rustix::io::{Errno, retry_on_intr};
use rustix::net::{RecvFlags, SendFlags};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;
use tokio::task::AbortHandle;
use tokio::time::{sleep, timeout};

use super::host::LONGEST_DATAGRAM_BYTES;
use super::ring::{Drain, Feed};
use super::serial;
use super::shared::{Shared, failure};
use crate::device::DeviceError;

/// Bits of a character on a serial line: start, eight data bits, stop.
const BITS_PER_BYTE: f64 = 10.0;
/// Time between two looks at a ring that is full, and at a far end that takes nothing.
const LOOK: Duration = Duration::from_millis(1);
/// Longest wait for a far end that takes nothing, once the host is done with the line.
const PATIENCE: Duration = Duration::from_millis(50);
/// Longest wait for a serial port to send what it was given, once the host is done with it.
pub(super) const LONGEST_LINGER: Duration = Duration::from_millis(200);

/// What there is to read: bytes, the end of input, or an error such as a refused datagram.
const ARRIVING: Interest = Interest::READABLE.add(Interest::ERROR);

/// Time since the start of the run.
pub(super) type SharedClock = Arc<dyn Fn() -> Duration + Send + Sync>;

/// What a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sort {
    Serial { baud: u32 },
    Tcp,
    Udp,
}

/// A line of the operating system.
pub(super) struct Wire {
    sort: Sort,
    fd: AsyncFd<OwnedFd>,
    /// Whether everything has left that the host wrote.
    is_sent: AtomicBool,
}

impl Wire {
    /// Must be called inside the runtime.
    pub(super) fn new(sort: Sort, fd: OwnedFd) -> io::Result<Self> {
        Ok(Self { sort, fd: watched(fd, ARRIVING.add(Interest::WRITABLE))?, is_sent: AtomicBool::new(false) })
    }

    /// Waits for bytes and takes them; 0 from a line, not from a port, says that the far end closed it.
    async fn read(&self, into: &mut [u8]) -> io::Result<usize> {
        let mut receive = |fd: &OwnedFd| match self.sort {
            Sort::Udp => {
                retry_on_intr(|| rustix::net::recv(fd, &mut *into, RecvFlags::DONTWAIT)).map(|got| got.1)
            }
            Sort::Serial { .. } | Sort::Tcp => retry_on_intr(|| rustix::io::read(fd, &mut *into)),
        };
        self.fd.async_io(ARRIVING, |fd| receive(fd).map_err(io::Error::from)).await
    }

    /// Waits until some of the bytes are taken; how many.
    async fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
        let send = |fd: &OwnedFd| match self.sort {
            Sort::Serial { .. } => retry_on_intr(|| rustix::io::write(fd, bytes)),
            Sort::Tcp | Sort::Udp => retry_on_intr(|| rustix::net::send(fd, bytes, flags)),
        };
        self.fd.async_io(Interest::WRITABLE, |fd| send(fd).map_err(io::Error::from)).await
    }

    /// The error of a line that is gone.
    fn gone(&self, address: &str, error: Option<&io::Error>) -> DeviceError {
        let errno = error.and_then(io::Error::raw_os_error).map(Errno::from_raw_os_error);
        let words = error.map_or_else(|| "end of input".to_owned(), ToString::to_string);
        let (found, help) = match (self.sort, errno) {
            (Sort::Serial { .. }, None | Some(Errno::IO | Errno::NXIO | Errno::NODEV)) => (
                format!("one that was unplugged or closed by the far end ({words})"),
                "check plug and supply of the adapter, then start again",
            ),
            (Sort::Tcp, None) => (
                "one that the device closed".to_owned(),
                "check whether the device was switched off, or serves another client; then start again",
            ),
            (Sort::Tcp, Some(Errno::CONNRESET | Errno::PIPE)) => (
                format!("one that the device reset ({words})"),
                "check whether the device was started again; then start again",
            ),
            _ => (words, "check device, cable and network, then start again"),
        };
        failure(address, "line", "an open line", found, help)
    }
}

impl Drop for Wire {
    fn drop(&mut self) {
        if matches!(self.sort, Sort::Serial { .. }) {
            serial::release(self.fd.get_ref(), self.is_sent.load(Ordering::Relaxed));
        }
    }
}

/// Whatever ends a task ends the line for the host.
struct Ending(Arc<Shared>);

impl Drop for Ending {
    fn drop(&mut self) {
        let help = "open it again";
        self.0.fail(failure(self.0.address(), "line", "an open line", "one that this program closed", help));
    }
}

/// Moves what arrives into the ring until the line is gone.
pub(super) async fn receive(wire: Arc<Wire>, shared: Arc<Shared>, mut feed: Feed, clock: SharedClock) {
    let _ending = Ending(Arc::clone(&shared));
    let mut buffer = vec![0; LONGEST_DATAGRAM_BYTES];
    loop {
        let most_bytes = match wire.sort {
            // The network holds the device up: nothing is lost.
            Sort::Tcp => room_bytes(&mut feed).await.min(buffer.len()),
            Sort::Serial { .. } | Sort::Udp => buffer.len(),
        };
        let count = match wire.read(&mut buffer[..most_bytes]).await {
            Ok(0) if wire.sort != Sort::Udp => return shared.fail(wire.gone(shared.address(), None)),
            Ok(count) => count,
            Err(error) if is_refusal(&wire, &error) => {
                shared.count_refusal();
                continue;
            }
            Err(error) => return shared.fail(wire.gone(shared.address(), Some(&error))),
        };
        let at = clock();
        if wire.sort != Sort::Tcp && !shared.is_heard() {
            continue;
        }
        let lost_count = match wire.sort {
            Sort::Udp => usize::from(!feed.push(at, &buffer[..count])),
            // After a stall of this thread one read can give more than the whole ring holds.
            Sort::Serial { .. } | Sort::Tcp => count - feed.push_what_fits(at, &buffer[..count]),
        };
        shared.count_lost(lost_count);
    }
}

/// Waits until there is room in the ring.
async fn room_bytes(feed: &mut Feed) -> usize {
    loop {
        match feed.room_bytes() {
            0 => sleep(LOOK).await,
            room_bytes => return room_bytes,
        }
    }
}

/// Moves what the host writes to the line until the host is done and all of it is sent.
pub(super) async fn send(
    wire: Arc<Wire>,
    shared: Arc<Shared>,
    mut out: Drain,
    clock: SharedClock,
    receiver: AbortHandle,
) {
    let _ending = Ending(Arc::clone(&shared));
    let mut sender = Sender { wire, shared, clock, idle_at: Duration::ZERO };
    let served = sender.serve(&mut out).await;
    if let Err(error) = &served {
        sender.shared.fail(sender.wire.gone(sender.shared.address(), Some(error)));
    }
    let is_sent = sender.linger().await && served.is_ok_and(|is_taken| is_taken);
    sender.wire.is_sent.store(is_sent, Ordering::Relaxed);
    receiver.abort();
}

struct Sender {
    wire: Arc<Wire>,
    shared: Arc<Shared>,
    clock: SharedClock,
    /// When a serial port has sent all that it was given.
    idle_at: Duration,
}

impl Sender {
    /// Sends until the host is done; whether all of it was taken.
    async fn serve(&mut self, out: &mut Drain) -> io::Result<bool> {
        let bell = watched(self.shared.bell(), Interest::READABLE)?;
        let mut buffer = vec![0; LONGEST_DATAGRAM_BYTES];
        loop {
            let mut rung = bell.readable().await?;
            self.shared.silence()?;
            rung.clear_ready();
            let is_closed = self.shared.is_closed();
            while let Some(count) = self.next(out, &mut buffer) {
                if !self.send_all(&buffer[..count]).await? {
                    return Ok(false);
                }
            }
            if is_closed {
                return Ok(true);
            }
        }
    }

    /// The next datagram, or as many bytes as there are.
    fn next(&self, out: &mut Drain, into: &mut [u8]) -> Option<usize> {
        match self.wire.sort {
            Sort::Udp => out.next_chunk(Duration::MAX, into),
            Sort::Serial { .. } | Sort::Tcp => Some(out.read(Duration::MAX, into)).filter(|&count| count > 0),
        }
    }

    /// Sends bytes; `false` if they are not taken and the host is done.
    async fn send_all(&mut self, mut bytes: &[u8]) -> io::Result<bool> {
        loop {
            let count = match timeout(PATIENCE, self.wire.write(bytes)).await {
                Ok(Ok(count)) => count,
                Ok(Err(error)) if is_refusal(&self.wire, &error) => {
                    // The refusal of an earlier datagram; this one was not sent.
                    self.shared.count_refusal();
                    continue;
                }
                Ok(Err(error)) => return Err(error),
                Err(_) if self.shared.is_closed() => return Ok(false),
                Err(_) => continue,
            };
            if let Sort::Serial { baud } = self.wire.sort {
                let lasts = Duration::from_secs_f64(count as f64 * BITS_PER_BYTE / f64::from(baud));
                self.idle_at = self.idle_at.max((self.clock)()) + lasts;
            }
            bytes = &bytes[count..];
            if bytes.is_empty() {
                return Ok(true);
            }
        }
    }

    /// Waits until a serial port has sent what it was given; `false` if that takes too long.
    async fn linger(&self) -> bool {
        let left = self.idle_at.saturating_sub((self.clock)());
        sleep(left.min(LONGEST_LINGER)).await;
        left <= LONGEST_LINGER
    }
}

/// Hands a descriptor to the event queue. Must be called inside the runtime.
#[expect(
    deprecated,
    reason = "a type can give away a wrong descriptor by itself; those that own theirs cannot"
)]
fn watched<T: AsFd + AsRawFd>(fd: T, interest: Interest) -> io::Result<AsyncFd<T>> {
    AsyncFd::with_interest(fd, interest)
}

/// Whether this says that nobody listened when an earlier datagram arrived (RFC 1122, 4.1.3.3). The port goes on.
fn is_refusal(wire: &Wire, error: &io::Error) -> bool {
    wire.sort == Sort::Udp && error.kind() == io::ErrorKind::ConnectionRefused
}
