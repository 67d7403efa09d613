//! A node: network management, heartbeats and emergencies in front of a drive.

use std::time::Duration;

use super::objects::Communication;
use super::process_data::{self, ProcessData, Receipt};
use super::sdo::{Demand, SdoServer};
use crate::bus::{Plant, VirtualBus};
use drivers::wire::BusState;
use drivers::wire::can::CanFrame;

/// Error register 1001h: generic, communication.
const COMMUNICATION: u8 = 1 | 1 << 4;
/// Error codes of emergencies (CiA 301, 7.2.7): heartbeat lost, PDO not processed for its length.
const HEARTBEAT_LOST: u16 = 0x8130;
const PDO_LENGTH: u16 = 0x8210;

/// State of network management, as a heartbeat tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NodeState {
    Stopped = 0x04,
    Operational = 0x05,
    PreOperational = 0x7F,
}

/// What a node does wrong, for tests of main devices.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Misbehaviour {
    pub(super) is_silent: bool,
    pub(super) has_no_heartbeat: bool,
    pub(super) is_sdo_mute: bool,
}

/// A node in front of drive `k` of its bus.
pub(super) struct Node {
    pub(super) id: u8,
    pub(super) k: usize,
    pub(super) state: NodeState,
    pub(super) communication: Communication,
    pub(super) sdo: SdoServer,
    pub(super) misbehaviour: Misbehaviour,
    process_data: ProcessData,
    heartbeat_due: Option<Duration>,
    /// When the heartbeats that it supervises are overdue; `None` before the first one.
    overdue: [Option<Duration>; 2],
    /// Error code of the drive that was told last.
    told: u16,
    /// Frames that it sends.
    sent: Vec<CanFrame>,
}

impl Node {
    /// A node whose supply has just come on.
    pub(super) fn new<P: Plant>(bus: &mut VirtualBus<P>, k: usize) -> Self {
        let id = k as u8 + 1;
        let mut node = Self {
            id,
            k,
            state: NodeState::PreOperational,
            communication: Communication::new(id),
            sdo: SdoServer::default(),
            misbehaviour: Misbehaviour::default(),
            process_data: ProcessData::default(),
            heartbeat_due: None,
            overdue: [None; 2],
            told: 0,
            sent: Vec::new(),
        };
        node.reset_communication(bus);
        node
    }

    /// Frames that it has to send.
    pub(super) fn take_sent(&mut self) -> impl Iterator<Item = CanFrame> {
        if self.misbehaviour.is_silent {
            self.sent.clear();
        }
        self.sent.drain(..)
    }

    /// Begins anew: communication objects as after power-up, boot-up message, pre-operational.
    pub(super) fn reset_communication<P: Plant>(&mut self, bus: &mut VirtualBus<P>) {
        self.leave(bus, NodeState::PreOperational);
        self.communication = Communication::new(self.id);
        (self.heartbeat_due, self.overdue, self.told) = (None, [None; 2], 0);
        self.sdo.reset();
        process_data::map_by_default(bus, self.k);
        self.send(0x700, [0]);
    }

    /// The supply was interrupted, or the whole node is to begin anew.
    pub(super) fn reset<P: Plant>(&mut self, bus: &mut VirtualBus<P>) {
        bus.drive_mut(self.k).restart();
        self.reset_communication(bus);
    }

    /// When it has something to do by itself.
    pub(super) fn next_due(&self) -> Option<Duration> {
        self.overdue.into_iter().chain([self.heartbeat_due]).flatten().min()
    }

    /// Time passes: heartbeat, supervised heartbeats, faults of the drive.
    pub(super) fn advance<P: Plant>(&mut self, bus: &mut VirtualBus<P>, now: Duration) {
        if let Some(due) = self.heartbeat_due.filter(|&due| due <= now) {
            let period = Duration::from_millis(u64::from(self.communication.heartbeat_ms.max(1)));
            let missed = now.saturating_sub(due).as_nanos() / period.as_nanos();
            self.heartbeat_due = Some(due + period * (missed as u32 + 1));
            if !self.misbehaviour.has_no_heartbeat {
                self.send(0x700, [self.state as u8]);
            }
        }
        for k in 0..self.overdue.len() {
            if self.overdue[k].is_some_and(|due| due <= now) {
                self.overdue[k] = None;
                self.send_emergency(HEARTBEAT_LOST, COMMUNICATION);
                // Error behaviour 1029h:1 as after power-up: out of operational. The drive reacts as 6007h says.
                if self.state == NodeState::Operational {
                    self.leave(bus, NodeState::PreOperational);
                }
            }
        }
        self.tell_fault(bus);
    }

    /// A fault is told once, and once that it is gone: error code 0000h.
    fn tell_fault<P: Plant>(&mut self, bus: &VirtualBus<P>) {
        let [code, register] = bus.drive(self.k).error();
        if code != self.told {
            self.told = code;
            self.send_emergency(code, register as u8);
        }
    }

    /// Takes a frame that is no SYNC.
    pub(super) fn receive<P: Plant>(&mut self, bus: &mut VirtualBus<P>, now: Duration, frame: &CanFrame) {
        if self.misbehaviour.is_silent {
            return;
        }
        match (frame.id(), frame.data()) {
            (0x000, &[command, node]) if node == 0 || node == self.id => self.manage(bus, command),
            (0x000, _) => {}
            (id, data) if id == 0x600 + u16::from(self.id) && self.state != NodeState::Stopped => {
                self.serve(bus, data);
            }
            (id @ 0x701..=0x77F, _) => self.hear(now, (id - 0x700) as u8),
            _ => self.take_outputs(frame),
        }
        self.tell_fault(bus);
    }

    /// Takes a frame that may be an RPDO.
    fn take_outputs(&mut self, frame: &CanFrame) {
        let is_operational = self.state == NodeState::Operational;
        if is_operational && self.process_data.receive(frame) == Receipt::TooShort {
            self.send_emergency(PDO_LENGTH, COMMUNICATION);
        }
    }

    /// Takes a SYNC.
    pub(super) fn sync<P: Plant>(&mut self, bus: &mut VirtualBus<P>, now: Duration) {
        if self.state == NodeState::Operational && !self.misbehaviour.is_silent {
            let Self { process_data, sent, k, .. } = self;
            process_data.sync(bus, *k, now, &mut |frame| sent.push(frame));
        }
        self.tell_fault(bus);
    }

    pub(super) fn send_emergency(&mut self, code: u16, register: u8) {
        let [low, high] = code.to_le_bytes();
        self.send(0x080, [low, high, register, 0, 0, 0, 0, 0]);
    }

    /// Network management (CiA 301, 7.3.2).
    fn manage<P: Plant>(&mut self, bus: &mut VirtualBus<P>, command: u8) {
        match command {
            0x01 if self.state != NodeState::Operational => self.start(bus),
            0x02 => self.leave(bus, NodeState::Stopped),
            0x80 => self.leave(bus, NodeState::PreOperational),
            0x81 => self.reset(bus),
            0x82 => self.reset_communication(bus),
            _ => {}
        }
    }

    /// Into operational; a node whose mapping does not fit says so and stays where it is.
    fn start<P: Plant>(&mut self, bus: &mut VirtualBus<P>) {
        match ProcessData::lay_out(self, bus) {
            Ok(process_data) => {
                self.process_data = process_data;
                self.state = NodeState::Operational;
                bus.enter(self.k, BusState::SafeOp);
            }
            Err(_) => self.send_emergency(PDO_LENGTH, COMMUNICATION),
        }
    }

    /// Out of operational: process data end, and with torque on the drive reacts as 6007h says.
    fn leave<P: Plant>(&mut self, bus: &mut VirtualBus<P>, state: NodeState) {
        self.state = state;
        bus.enter(self.k, BusState::PreOp);
    }

    /// A heartbeat of another node.
    fn hear(&mut self, now: Duration, node: u8) {
        for (consumer, overdue) in self.communication.consumers.iter().zip(&mut self.overdue) {
            if consumer.node == node && consumer.node != 0 && consumer.limit_ms != 0 {
                *overdue = Some(now + Duration::from_millis(u64::from(consumer.limit_ms)));
            }
        }
    }

    /// Heartbeats begin with the settings that were just written.
    pub(super) fn heartbeats_changed(&mut self, now: Duration, index: u16) {
        match (index, self.communication.heartbeat_ms) {
            (0x1016, _) => self.overdue = [None; 2],
            (0x1017, 0) => self.heartbeat_due = None,
            (0x1017, period_ms) => {
                self.heartbeat_due = Some(now + Duration::from_millis(u64::from(period_ms)))
            }
            _ => {}
        }
    }

    /// Answers an SDO request.
    fn serve<P: Plant>(&mut self, bus: &mut VirtualBus<P>, request: &[u8]) {
        if self.misbehaviour.is_sdo_mute {
            return;
        }
        let answer = match self.sdo.request(request) {
            Demand::Nothing => return,
            Demand::Answer(answer) => answer,
            Demand::Upload(place) => {
                let read = self.upload(bus, place.index, place.sub);
                self.sdo.uploaded(read)
            }
            Demand::Download { place, mut data, has_size } => {
                if !has_size && let Ok(present) = self.upload(bus, place.index, place.sub) {
                    data.truncate(present.len());
                }
                let written = self.download(bus, place.index, place.sub, &data);
                self.sdo.downloaded(written)
            }
        };
        self.send(0x580, answer);
    }

    /// Sends a frame whose identifier has the node-ID added.
    fn send<const N: usize>(&mut self, function: u16, data: [u8; N]) {
        self.sent.push(CanFrame::of(function + u16::from(self.id), data));
    }
}
