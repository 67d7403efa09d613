//! ethercrab alone: its futures polled by hand, one packet socket, and nothing else.

use std::future::Future;
use std::num::NonZeroU32;
use std::os::fd::{AsRawFd, OwnedFd};
use std::pin::{Pin, pin};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use ethercrab::error::Error;
use ethercrab::subdevice_group::{DcConfiguration, HasDc, SafeOp};
use ethercrab::{
    DcSync, DefaultLock, MainDevice, MainDeviceConfig, PduRx, PduStorage, PduTx, ReceiveAction,
    SubDeviceGroup, Timeouts,
};
use rustix::net::sockopt::{Timeout, set_socket_timeout};
use rustix::net::{AddressFamily, Protocol, RecvFlags, SendFlags, SocketFlags, SocketType};

use super::clock;
use super::compare::{Outcome, REPLY_LIMIT};
use super::meter::{Meter, measured};
use drivers::wire::MAX_FRAME_BYTES;

/// EtherType of EtherCAT.
const ETHERTYPE: u16 = 0x88A4;
/// Frames that may be under way at once.
const SLOTS: usize = 4;
const MOST_STATIONS: usize = 16;
const MOST_BYTES: usize = 1486;
/// Frames in a row that are no replies, after which nobody answers.
const MOST_FOREIGN: u32 = 1000;
/// Longest step of the start.
const STEP_LIMIT: Duration = Duration::from_secs(20);

type Group = SubDeviceGroup<MOST_STATIONS, MOST_BYTES, DefaultLock, SafeOp, HasDc>;

/// Why a future was given up.
#[derive(Debug)]
enum Stopped {
    NoReply,
    TooLong,
    Socket(rustix::io::Errno),
}

/// A socket and ethercrab's two ends of it.
struct Wire {
    socket: Option<OwnedFd>,
    tx: PduTx<'static>,
    rx: PduRx<'static>,
    /// Frames that were sent and have no reply yet.
    awaited: u32,
    received: Box<[u8; MAX_FRAME_BYTES]>,
    meter: Meter,
}

/// ethercrab's main device and its group in SAFE-OP, in which it exchanges whatever state the stations are in.
pub(crate) struct Bare {
    interface: String,
    wire: Wire,
    main: MainDevice<'static>,
    group: Box<Group>,
}

impl Bare {
    /// Brings all stations behind an interface into SAFE-OP, with SYNC0 where they can have it; then lets go of the interface.
    pub(crate) fn open(interface: &str, cycle: Duration) -> Result<Self, String> {
        // ethercrab's handles borrow their store: it stays for the rest of the program.
        let store: &'static PduStorage<SLOTS, MAX_FRAME_BYTES> = Box::leak(Box::new(PduStorage::new()));
        let (tx, rx, pdu_loop) =
            store.try_split().map_err(|()| "internal error: the store is split".to_owned())?;
        let config = MainDeviceConfig { dc_static_sync_iterations: 1000, ..MainDeviceConfig::default() };
        let main = MainDevice::new(pdu_loop, Timeouts::default(), config);
        let received = Box::new([0; MAX_FRAME_BYTES]);
        let mut wire =
            Wire { socket: Some(socket(interface)?), tx, rx, awaited: 0, received, meter: Meter::default() };
        let mut group = wire.step(main.init_single_group::<MOST_STATIONS, MOST_BYTES>(now_ns))?;
        for mut station in group.iter_mut(&main) {
            let has_sync0 = station.dc_support().enhanced();
            station.set_dc_sync(if has_sync0 { DcSync::Sync0 } else { DcSync::Disabled });
        }
        let group = wire.step(group.into_pre_op_pdi(&main))?;
        let timing = DcConfiguration {
            start_delay: Duration::from_millis(100),
            sync0_period: cycle,
            sync0_shift: cycle / 2,
        };
        let group = wire.step(group.configure_dc_sync(&main, timing))?;
        let group = Box::new(wire.step(group.into_safe_op(&main))?);
        wire.socket = None;
        Ok(Self { interface: interface.to_owned(), wire, main, group })
    }

    pub(crate) fn connect(&mut self) -> Result<(), String> {
        self.wire.socket = Some(socket(&self.interface)?);
        Ok(())
    }

    pub(crate) fn disconnect(&mut self) {
        self.wire.socket = None;
    }

    pub(crate) fn exchange(&mut self, expected: u16) -> Result<Outcome, String> {
        self.wire.meter.reset();
        let exchange = pin!(self.group.tx_rx_dc(&self.main));
        match self.wire.run(REPLY_LIMIT, exchange) {
            Ok(Ok(response)) if response.working_counter == expected => Ok(Outcome::Complete),
            Ok(Ok(_)) => Ok(Outcome::Short),
            Ok(Err(_)) | Err(Stopped::NoReply | Stopped::TooLong) => Ok(Outcome::Lost),
            Err(why) => Err(failure(why)),
        }
    }

    /// How long the last exchange spent in calls of the system.
    pub(crate) fn meter(&self) -> &Meter {
        &self.wire.meter
    }
}

impl Wire {
    /// One step of the start.
    fn step<T>(&mut self, step: impl Future<Output = Result<T, Error>>) -> Result<T, String> {
        let mut step = Box::pin(step);
        match self.run(STEP_LIMIT, step.as_mut()) {
            Ok(done) => done.map_err(|error| format!("ethercrab alone: {error}")),
            Err(why) => Err(failure(why)),
        }
    }

    /// Polls a future until it is ready, sends what it makes and waits for the replies.
    ///
    /// ethercrab's timers stand still here, so they cost nothing and never end; receiving has a time-out of its own.
    fn run<F: Future>(&mut self, limit: Duration, mut future: Pin<&mut F>) -> Result<F::Output, Stopped> {
        let Self { socket, tx, rx, awaited, received, meter } = self;
        let Some(socket) = socket else { return Err(Stopped::Socket(rustix::io::Errno::NOTCONN)) };
        let (mut foreign, mut idle_until) = (0, None);
        loop {
            if let Poll::Ready(output) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
                return Ok(output);
            }
            while let Some(frame) = tx.next_sendable_frame() {
                let sent = frame.send_blocking(|bytes| {
                    let send = || rustix::net::send(&*socket, bytes, SendFlags::empty());
                    measured(&meter.called, send).map_err(|_| Error::SendFrame)
                });
                *awaited += u32::from(sent.is_ok());
            }
            if *awaited == 0 {
                // Starting looks again at what is not there yet; otherwise, the interface's queue is full.
                if clock::now() > *idle_until.get_or_insert_with(|| clock::now() + limit) {
                    return Err(Stopped::TooLong);
                }
                continue;
            }
            let receive = || rustix::net::recv(&*socket, &mut received[..], RecvFlags::empty());
            match measured(&meter.waited, receive) {
                Ok((_, length)) if is_reply(rx, &received[..length.min(MAX_FRAME_BYTES)]) => *awaited -= 1,
                Ok(_) if foreign < MOST_FOREIGN => foreign += 1,
                Err(rustix::io::Errno::INTR) => {}
                Ok(_) | Err(rustix::io::Errno::WOULDBLOCK) => {
                    *awaited = 0;
                    return Err(Stopped::NoReply);
                }
                Err(error) => return Err(Stopped::Socket(error)),
            }
        }
    }
}

fn is_reply(rx: &mut PduRx<'_>, frame: &[u8]) -> bool {
    rx.receive_frame(frame) == Ok(ReceiveAction::Processed)
}

fn failure(why: Stopped) -> String {
    match why {
        Stopped::NoReply => "ethercrab alone: no reply; check the far end of the interface".to_owned(),
        Stopped::TooLong => format!("ethercrab alone: a step took more than {} s", STEP_LIMIT.as_secs()),
        Stopped::Socket(error) => format!("ethercrab alone: the interface failed: {error}"),
    }
}

/// A packet socket on an interface; receiving waits at most for the longest reply.
fn socket(interface: &str) -> Result<OwnedFd, String> {
    let failed = |error: std::io::Error| format!("interface {interface}: {error}");
    let protocol = NonZeroU32::new(u32::from(ETHERTYPE.to_be())).map(Protocol::from_raw);
    let socket =
        rustix::net::socket_with(AddressFamily::PACKET, SocketType::RAW, SocketFlags::CLOEXEC, protocol)
            .map_err(|error| failed(error.into()))?;
    let mut all = nix::ifaddrs::getifaddrs().map_err(|error| failed(error.into()))?;
    let address = all.find_map(|found| {
        let address = found.address.filter(|address| address.as_link_addr().is_some());
        address.filter(|_| found.interface_name == interface)
    });
    let address = address.ok_or_else(|| format!("interface {interface}: no such Ethernet interface"))?;
    nix::sys::socket::bind(socket.as_raw_fd(), &address).map_err(|error| failed(error.into()))?;
    set_socket_timeout(&socket, Timeout::Recv, Some(REPLY_LIMIT)).map_err(|error| failed(error.into()))?;
    Ok(socket)
}

/// Time of the monotonic clock in nanoseconds, as ethercrab wants it.
fn now_ns() -> u64 {
    u64::try_from(clock::now().as_nanos()).unwrap_or(u64::MAX)
}
