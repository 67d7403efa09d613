//! The nodes on one CAN bus.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Duration;

use super::faults::NodeFault;
use super::node::Node;
use crate::bus::{Plant, VirtualBus};
use drivers::wire::can::{CanEvent, CanFrame};

/// Identifier of SYNC.
const SYNC: u16 = 0x080;

/// CANopen nodes at the far end of a CAN wire. Node 1 is the first drive.
pub trait CanOpenLine {
    /// A frame arrives at all nodes.
    fn take(&mut self, now: Duration, frame: &CanFrame);

    /// Time passes without a frame: heartbeats are due, the world moves on.
    fn advance(&mut self, now: Duration);

    /// The oldest frame that a node has sent and that nobody has taken yet.
    fn give(&mut self) -> Option<CanEvent>;

    /// When a node has something to do by itself.
    fn next_due(&self) -> Option<Duration>;

    /// Something goes wrong from now on.
    ///
    /// # Errors
    /// When there is no such node.
    fn inject(&mut self, now: Duration, fault: NodeFault) -> Result<(), String>;
}

/// A node in front of each drive of a bus.
pub(crate) struct Line<P: Plant> {
    bus: Rc<RefCell<VirtualBus<P>>>,
    nodes: Vec<Node>,
    sent: VecDeque<CanEvent>,
}

impl<P: Plant> Line<P> {
    /// Nodes whose supply has just come on: node 1 for the first drive.
    pub(crate) fn new(bus: Rc<RefCell<VirtualBus<P>>>) -> Self {
        let nodes = {
            let mut bus = bus.borrow_mut();
            (0..bus.stations_count()).map(|k| Node::new(&mut bus, k)).collect()
        };
        let mut line = Self { bus, nodes, sent: VecDeque::new() };
        line.collect();
        line
    }

    /// Does something with every node, and takes what it sends.
    fn for_each(&mut self, mut act: impl FnMut(&mut Node, &mut VirtualBus<P>)) {
        let mut bus = self.bus.borrow_mut();
        self.nodes.iter_mut().for_each(|node| act(node, &mut bus));
        drop(bus);
        self.collect();
    }

    /// Nodes send in the order of their node-IDs, which is that of arbitration for equal messages.
    fn collect(&mut self) {
        let Self { nodes, sent, .. } = self;
        nodes.iter_mut().for_each(|node| sent.extend(node.take_sent().map(CanEvent::Frame)));
    }

    fn with_node(
        &mut self,
        wanted: u8,
        act: impl FnOnce(&mut Node, &mut VirtualBus<P>),
    ) -> Result<(), String> {
        let count = self.nodes.len();
        let place = usize::from(wanted).checked_sub(1);
        let Some(node) = place.and_then(|place| self.nodes.get_mut(place)) else {
            return Err(format!("no node {wanted}: expected 1 to {count}"));
        };
        act(node, &mut self.bus.borrow_mut());
        self.collect();
        Ok(())
    }
}

impl<P: Plant> CanOpenLine for Line<P> {
    fn take(&mut self, now: Duration, frame: &CanFrame) {
        self.advance(now);
        if frame.id() != SYNC {
            return self.for_each(|node, bus| node.receive(bus, now, frame));
        }
        self.bus.borrow_mut().trigger(now);
        let arrives = self.bus.borrow_mut().frame_arrives(now);
        if arrives {
            self.for_each(|node, bus| node.sync(bus, now));
        }
    }

    fn advance(&mut self, now: Duration) {
        self.bus.borrow_mut().advance_to(now);
        self.for_each(|node, bus| node.advance(bus, now));
    }

    fn give(&mut self) -> Option<CanEvent> {
        self.sent.pop_front()
    }

    fn next_due(&self) -> Option<Duration> {
        self.nodes.iter().filter_map(Node::next_due).min()
    }

    fn inject(&mut self, now: Duration, fault: NodeFault) -> Result<(), String> {
        self.advance(now);
        match fault {
            NodeFault::Silent { node, is_silent } => {
                self.with_node(node, |node, _| node.misbehaviour.is_silent = is_silent)
            }
            NodeFault::HeartbeatStopped { node, is_stopped } => {
                self.with_node(node, |node, _| node.misbehaviour.has_no_heartbeat = is_stopped)
            }
            NodeFault::SdoMute { node, is_mute } => {
                self.with_node(node, |node, _| node.misbehaviour.is_sdo_mute = is_mute)
            }
            NodeFault::WrongToggle { node } => self.with_node(node, |node, _| node.sdo.errs_in_toggle = true),
            NodeFault::RefusesSdo { node, code } => self.with_node(node, |node, _| node.sdo.refuses = code),
            NodeFault::Emergency { node, code, register } => {
                self.with_node(node, |node, _| node.send_emergency(code, register))
            }
            NodeFault::Restart { node } => self.with_node(node, |node, bus| node.reset(bus)),
            NodeFault::ControllerError(error) => {
                self.sent.push_back(CanEvent::Error(error));
                Ok(())
            }
        }
    }
}
