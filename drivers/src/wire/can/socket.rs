//! A CAN interface of Linux, through a raw CAN socket.

use std::io;
use std::os::fd::AsFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use socketcan::{CanDataFrame, CanSocket, EmbeddedFrame, Id, Socket, SocketOptions, StandardId};

use super::{CanErrorFrame, CanEvent, CanFrame, CanLink};
use crate::device::DeviceError;

/// Frames of other kinds that are skipped in one look, so that no look takes long.
const MOST_SKIPPED: usize = 64;

/// A CAN interface, e.g. `can0`. Bit rate and restart delay are set outside:
/// `ip link set can0 up type can bitrate 1000000 restart-ms 0`.
///
/// Opening it needs no rights.
pub struct SocketCan {
    name: String,
    socket: CanSocket,
    clock: Box<dyn Fn() -> Duration>,
}

impl SocketCan {
    /// Opens the interface `name`. The clock gives the time since the start of the run, of the monotonic clock.
    ///
    /// # Errors
    /// When there is no such interface, it is not a CAN interface, or it is down; when the kernel has no CAN.
    pub fn open(name: &str, clock: Box<dyn Fn() -> Duration>) -> Result<Self, DeviceError> {
        let socket = CanSocket::open(name).map_err(|error| refused(name, &error))?;
        let failed = |error: io::Error| refused(name, &error);
        socket.set_nonblocking(true).map_err(failed)?;
        socket.set_error_filter_accept_all().map_err(failed)?;
        // A socket of an interface that is down can be bound; the error waits in it.
        if let Some(error) = socket.as_raw_socket().take_error().map_err(failed)? {
            return Err(refused(name, &error));
        }
        Ok(Self { name: name.to_owned(), socket, clock })
    }
}

impl CanLink for SocketCan {
    fn name(&self) -> &str {
        &self.name
    }

    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        let id = StandardId::new(frame.id()).ok_or(io::ErrorKind::InvalidInput)?;
        let frame = CanDataFrame::new(id, frame.data()).ok_or(io::ErrorKind::InvalidInput)?;
        self.socket.write_frame(&frame)
    }

    fn receive(&mut self) -> io::Result<Option<CanEvent>> {
        for _ in 0..MOST_SKIPPED {
            let received = match self.socket.read_frame() {
                Ok(received) => received,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(None),
                Err(error) => return Err(error),
            };
            if let Some(event) = event(&received) {
                return Ok(Some(event));
            }
        }
        Ok(None)
    }

    fn now(&self) -> Duration {
        (self.clock)()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        let left = until.saturating_sub((self.clock)());
        let timeout = Timespec {
            tv_sec: i64::try_from(left.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: left.subsec_nanos().into(),
        };
        match poll(&mut [PollFd::from_borrowed_fd(self.socket.as_fd(), PollFlags::IN)], Some(&timeout)) {
            // A signal: whoever waits looks at the time and waits again.
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }
}

/// What the kernel handed over, if it is of a kind that CANopen uses.
fn event(received: &socketcan::CanFrame) -> Option<CanEvent> {
    match received {
        socketcan::CanFrame::Data(frame) => {
            let Id::Standard(id) = frame.id() else { return None };
            CanFrame::new(id.as_raw(), frame.data()).map(CanEvent::Frame)
        }
        socketcan::CanFrame::Remote(_) => None,
        socketcan::CanFrame::Error(frame) => {
            let mut detail = [0; 8];
            let count = frame.data().len().min(detail.len());
            detail[..count].copy_from_slice(&frame.data()[..count]);
            Some(CanEvent::Error(CanErrorFrame { classes: frame.error_bits(), detail }))
        }
    }
}

/// The error of an interface that cannot be used, with what to do.
fn refused(name: &str, error: &io::Error) -> DeviceError {
    use rustix::io::Errno;
    let help = match error.raw_os_error().map(Errno::from_raw_os_error) {
        Some(Errno::NODEV) => "; correct the interface in the rig file, or load the driver of the adapter",
        Some(Errno::NETDOWN) => "; run `ip link set INTERFACE up type can bitrate 1000000 restart-ms 0`",
        Some(Errno::AFNOSUPPORT) => "; this kernel has no CAN: load the modules `can` and `can-raw`",
        _ => "",
    };
    let reason = format!("the CAN interface cannot be used: {error}{}", help.replace("INTERFACE", name));
    DeviceError::Bus { device: name.to_owned(), reason }
}
