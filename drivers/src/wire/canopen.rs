//! A CANopen bus (CiA 301) on a CAN interface, for drives that speak CiA 402.
//!
//! The bench is the NMT main device, the producer of SYNC and an SDO client; a station is a node and goes by its node-ID.
//!
//! - **Exchange.** It takes the TPDOs that the nodes have sent at the SYNC before, then sends the RPDOs, SYNC and, when it is
//!   due, the heartbeat of the bench. Inputs are thus one exchange older than on EtherCAT; outputs act at the SYNC that
//!   follows them. The working counter counts the nodes whose TPDOs all came.
//! - **States.** `PreOp` is NMT pre-operational. `SafeOp` is NMT operational without RPDOs: inputs are valid, nothing is
//!   commanded. `Op` is NMT operational with RPDOs. A drive that no longer gets RPDOs must stop by itself: its process data
//!   watchdog is set when the drive is opened.
//! - **After a fault.** Bus-off of the bench's controller, an interface that is gone and a second main device fail every
//!   exchange from then on. A node that is lost (no heartbeat for three periods) or leaves operational by itself gets no RPDOs
//!   any more and does not count. Nothing restarts by itself: the bus must be opened anew.
//! - **Held axes.** Opening the bus resets the nodes, and their drives let go. A drive that may hold an axis is refused unless the
//!   settings say that the axes are secured.

mod cycle;
mod load;
mod map;
mod message;
mod node;
mod open;
mod sdo;
mod settings;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

pub use self::load::shortest_cycle_s;
pub use self::message::NmtState;
pub use self::settings::CanOpenSettings;

use self::message::{Message, NmtCommand};
use self::node::Node;
use self::sdo::{Place, SdoClient};
use super::can::{CanErrorFrame, CanEvent, CanFrame, CanLink};
use super::{
    BusState, Exchange, Fieldbus, News, Notice, PdoTransport, ProcessImage, SdoAbort, SdoRequest, SdoWire,
    Slot,
};
use crate::device::DeviceError;

/// Notices that wait; when there are more, the oldest goes.
const MOST_NOTICES: usize = 64;
/// Frames that are taken in one look: more than a bus carries in a period.
const MOST_FRAMES: usize = 1024;

/// A CANopen bus.
pub struct CanOpenBus {
    name: String,
    settings: CanOpenSettings,
    link: Box<dyn CanLink>,
    nodes: Vec<Node>,
    sdo: SdoClient,
    /// Bytes of outputs and inputs, once they are mapped.
    mapped: Option<[usize; 2]>,
    /// No other main device was heard: the nodes are this bus's to command.
    is_alone: bool,
    /// RPDOs are sent.
    commands: bool,
    heartbeat_due: Option<Duration>,
    /// Why nothing is exchanged any more.
    failure: Option<String>,
    notices: VecDeque<Notice>,
    /// The error that was told last, so that a lasting one is told once.
    last_error: Option<CanErrorFrame>,
}

impl CanOpenBus {
    /// Waits until the interface's time is `now`.
    fn reach(&mut self, now: Duration) {
        while self.link.now() < now {
            if let Err(error) = self.link.wait(now) {
                return self.fail(&error);
            }
            self.listen();
        }
    }

    /// Takes what has arrived, and acts on what is overdue.
    fn listen(&mut self) {
        for _ in 0..MOST_FRAMES {
            match self.link.receive() {
                Ok(Some(CanEvent::Frame(frame))) => self.hear(&frame),
                Ok(Some(CanEvent::Error(error))) => self.take_error(error),
                Ok(None) => break,
                Err(error) => {
                    self.fail(&error);
                    return;
                }
            }
        }
        let now = self.link.now();
        if let Some(abort) = self.sdo.expire(now) {
            self.send_sdo(abort);
        }
        let limit = self.settings.silence();
        for k in 0..self.nodes.len() {
            if let Some(silent) = self.nodes[k].lose(now, limit) {
                self.tell(u16::from(self.nodes[k].id), News::HeartbeatLost { silent });
            }
        }
    }

    fn hear(&mut self, frame: &CanFrame) {
        let now = self.link.now();
        match Message::of(frame) {
            Message::MainDevice => {
                let id = frame.id();
                self.fail_with(format!(
                    "another main device sends on this bus (identifier {id:03X}h); remove it"
                ));
            }
            Message::Emergency { node, code, register } => {
                if self.place(node).is_some() {
                    self.tell(u16::from(node), News::Emergency { code, register });
                }
            }
            Message::Tpdo { node, k } => {
                if let Some(place) = self.place(node) {
                    self.nodes[place].receive(k, frame.data());
                }
            }
            Message::SdoAnswer { node } if node == self.sdo.node() => {
                if let Some(request) = self.sdo.take(frame.data()) {
                    self.send_sdo(request);
                }
            }
            Message::Heartbeat { node, .. } if node == self.settings.own_node => {
                self.fail_with(format!(
                    "another device has node-ID {node}, which is the bench's own; change one of the two"
                ));
            }
            Message::Heartbeat { node, state } => {
                if let Some(place) = self.place(node)
                    && self.nodes[place].hear(now, state)
                {
                    self.tell(u16::from(node), News::NmtState { state });
                }
            }
            Message::SdoAnswer { .. } | Message::Other => {}
        }
    }

    fn take_error(&mut self, error: CanErrorFrame) {
        if self.last_error != Some(error) {
            self.last_error = Some(error);
            self.tell(0, News::CanError(error));
        }
        if error.is_bus_off() {
            self.fail_with(
                "the CAN controller of the bench is off the bus; check wiring, termination and bit rate, restart the interface \
                 and begin another run"
                    .to_owned(),
            );
        }
    }

    fn place(&self, node: u8) -> Option<usize> {
        self.nodes.iter().position(|found| found.id == node)
    }

    fn tell(&mut self, station: u16, news: News) {
        if self.notices.len() == MOST_NOTICES {
            self.notices.pop_front();
        }
        self.notices.push_back(Notice { station, news });
    }

    /// Sends a frame. A queue that is full fails this frame only; an interface that is gone fails the bus.
    fn send(&mut self, frame: &CanFrame) -> Result<(), DeviceError> {
        match self.link.send(frame) {
            Ok(()) => Ok(()),
            Err(error) if is_full(&error) => {
                let reason = format!(
                    "frame {:03X}h was not sent, the queue of the interface is full: no other node acknowledges frames, or the \
                     bus is overloaded",
                    frame.id()
                );
                Err(self.error(reason))
            }
            Err(error) => {
                self.fail(&error);
                self.check()
            }
        }
    }

    /// Sends a command of network management to a node.
    fn command(&mut self, k: usize, command: NmtCommand) -> Result<(), DeviceError> {
        self.nodes[k].wanted = match command {
            NmtCommand::Start => NmtState::Operational,
            NmtCommand::EnterPreOperational => NmtState::PreOperational,
            NmtCommand::ResetCommunication => NmtState::BootUp,
        };
        self.send(&message::nmt(command, self.nodes[k].id))
    }

    /// A request that cannot be sent shows in its transfer, which times out.
    fn send_sdo(&mut self, request: [u8; 8]) {
        let frame = message::sdo_request(self.sdo.node(), request);
        let _ = self.send(&frame);
    }

    fn fail(&mut self, error: &io::Error) {
        self.fail_with(format!(
            "the CAN interface failed: {error}; check adapter and interface, then begin another run"
        ));
    }

    /// The first failure stays.
    fn fail_with(&mut self, reason: String) {
        self.failure.get_or_insert(reason);
    }

    fn check(&self) -> Result<(), DeviceError> {
        self.failure.as_ref().map_or(Ok(()), |reason| Err(self.error(reason.clone())))
    }

    fn error(&self, reason: String) -> DeviceError {
        DeviceError::Bus { device: self.name.clone(), reason }
    }
}

/// Whether a frame could not be sent because there was no room for it.
fn is_full(error: &io::Error) -> bool {
    /// No buffer space available (Linux, ENOBUFS): the queue of a CAN interface is full.
    const NO_BUFFERS: i32 = 105;
    error.kind() == io::ErrorKind::WouldBlock || error.raw_os_error() == Some(NO_BUFFERS)
}

impl SdoWire for CanOpenBus {
    fn pdo_transport(&self) -> PdoTransport {
        PdoTransport::Frames
    }

    fn start(&mut self, now: Duration, request: &SdoRequest<'_>) {
        self.reach(now);
        let node = u8::try_from(request.station).ok().filter(|&node| self.place(node).is_some());
        let place = Place { index: request.index, sub: request.sub };
        let frame = self.sdo.start(self.link.now(), node.unwrap_or(0), place, request.write);
        if node.is_some() && self.failure.is_none() { self.send_sdo(frame) } else { self.sdo.refuse() }
    }

    fn poll(&mut self, now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        self.reach(now);
        self.listen();
        if self.failure.is_some() {
            self.sdo.refuse();
        }
        let Some(outcome) = self.sdo.take_outcome() else { return Ok(false) };
        into.clear();
        into.extend_from_slice(outcome?);
        Ok(true)
    }
}

impl Fieldbus for CanOpenBus {
    fn name(&self) -> &str {
        &self.name
    }

    fn stations(&self) -> Vec<u16> {
        self.nodes.iter().map(|node| u16::from(node.id)).collect()
    }

    /// Ends configuration: reads the mappings, gives the PDOs their identifiers, starts the nodes and takes a first set of
    /// inputs. It takes some SDO transfers for each PDO, and at most three heartbeats.
    fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        self.configure()
    }

    fn request(&mut self, state: BusState) {
        let is_up = state > BusState::PreOp && self.mapped.is_some();
        self.commands = state == BusState::Op && is_up;
        let command = if is_up { NmtCommand::Start } else { NmtCommand::EnterPreOperational };
        for k in 0..self.nodes.len() {
            if !self.nodes[k].has_fallen {
                // A failed interface shows in the exchange.
                let _ = self.command(k, command);
            }
        }
    }

    fn state(&self) -> BusState {
        let is_up = |node: &Node| node.state == NmtState::Operational && !node.has_fallen;
        match self.commands {
            _ if self.failure.is_some() || self.mapped.is_none() || !self.nodes.iter().all(is_up) => {
                BusState::PreOp
            }
            true => BusState::Op,
            false => BusState::SafeOp,
        }
    }

    fn took_part(&self, station: u16) -> bool {
        self.nodes.iter().any(|node| u16::from(node.id) == station && node.took_part)
    }

    fn now(&self) -> Option<Duration> {
        Some(self.link.now())
    }

    fn tell_notices(&mut self, tell: &mut dyn FnMut(Notice)) {
        self.notices.drain(..).for_each(tell);
    }

    fn exchange(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        self.cycle(now, image)
    }
}

impl Drop for CanOpenBus {
    /// Nodes go to pre-operational. A drive that still moves stops by its own watchdog, and by the heartbeat that stays out.
    fn drop(&mut self) {
        if self.is_alone {
            self.request(BusState::PreOp);
        }
    }
}
