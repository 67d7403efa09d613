//! A node as the main device sees it: its state, its heartbeat and its PDOs.

use std::ops::Range;
use std::time::Duration;

use super::super::Slot;
use super::message::NmtState;
use crate::cia402::frames::{FRAME_BYTES, PDOS};

const MOST_BYTES: usize = PDOS as usize * FRAME_BYTES;

/// Lengths of the PDOs of one direction; 0 for one that is switched off.
pub(super) type Lengths = [usize; PDOS as usize];

/// A node.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) id: u8,
    pub(super) state: NmtState,
    /// State that it was last told to take.
    pub(super) wanted: NmtState,
    /// Its boot-up has been heard.
    pub(super) has_booted: bool,
    /// When it was last heard; `None` before its heartbeat is watched.
    pub(super) heard: Option<Duration>,
    /// It was lost, or left a state by itself. There is no way back: the bus must be opened anew.
    pub(super) has_fallen: bool,
    pub(super) rpdos: Lengths,
    pub(super) tpdos: Lengths,
    pub(super) slot: Slot,
    /// Its inputs of the last exchange were whole.
    pub(super) took_part: bool,
    /// Inputs as they come in, PDO after PDO.
    received: [u8; MOST_BYTES],
    /// Which TPDOs came since the last SYNC, one bit each.
    came: u8,
}

impl Node {
    pub(super) fn new(id: u8) -> Self {
        Self {
            id,
            state: NmtState::BootUp,
            wanted: NmtState::BootUp,
            has_booted: false,
            heard: None,
            has_fallen: false,
            rpdos: Lengths::default(),
            tpdos: Lengths::default(),
            slot: Slot::default(),
            took_part: false,
            received: [0; MOST_BYTES],
            came: 0,
        }
    }

    /// Takes a heartbeat; whether the node has left its state by itself, which is told once.
    pub(super) fn hear(&mut self, now: Duration, state: NmtState) -> bool {
        self.heard = self.heard.map(|_| now);
        let was = std::mem::replace(&mut self.state, state);
        self.has_booted |= state == NmtState::BootUp;
        let has_left = match state {
            NmtState::Operational => false,
            NmtState::BootUp => self.wanted != NmtState::BootUp,
            NmtState::Stopped | NmtState::PreOperational => {
                self.wanted == NmtState::Operational && was == NmtState::Operational
            }
        };
        let is_new = has_left && !self.has_fallen;
        self.has_fallen |= has_left;
        is_new
    }

    /// How long the node has been silent if that is longer than `limit`; told once, then the node is lost.
    pub(super) fn lose(&mut self, now: Duration, limit: Duration) -> Option<Duration> {
        let silent = now.saturating_sub(self.heard?);
        if silent <= limit || self.has_fallen {
            return None;
        }
        self.has_fallen = true;
        Some(silent)
    }

    /// Takes a PDO. One that is shorter than its mapping does not count as having come.
    pub(super) fn receive(&mut self, k: usize, data: &[u8]) {
        let Some(range) = range(&self.tpdos, k) else { return };
        if let (Some(data), false) = (data.get(..range.len()), range.is_empty()) {
            self.received[range].copy_from_slice(data);
            self.came |= 1 << k;
        }
    }

    /// Whether all TPDOs came since the last SYNC.
    pub(super) fn is_complete(&self) -> bool {
        let all = (0..self.tpdos.len()).filter(|&k| self.tpdos[k] > 0).fold(0, |all, k| all | 1 << k);
        self.came == all
    }

    /// Copies what came into the node's inputs if it is complete and the node stands; whether it did. The next SYNC begins.
    pub(super) fn hand_over(&mut self, inputs: &mut [u8]) -> bool {
        let is_good = self.is_complete() && !self.has_fallen;
        self.took_part = is_good;
        self.came = 0;
        if let (true, Some(place)) = (is_good, inputs.get_mut(self.slot.inputs.clone())) {
            let count = place.len().min(MOST_BYTES);
            place[..count].copy_from_slice(&self.received[..count]);
        }
        is_good
    }

    /// The bytes of an RPDO within the outputs of the bus; `None` for one that is switched off.
    pub(super) fn rpdo<'a>(&self, k: usize, outputs: &'a [u8]) -> Option<&'a [u8]> {
        let range = range(&self.rpdos, k).filter(|range| !range.is_empty())?;
        outputs.get(self.slot.outputs.clone())?.get(range)
    }
}

/// Bytes of PDO `k` among those of its node.
fn range(lengths: &Lengths, k: usize) -> Option<Range<usize>> {
    let length = *lengths.get(k)?;
    let first = lengths[..k].iter().sum();
    Some(first..first + length)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Duration = Duration::from_secs(1);
    const LIMIT: Duration = Duration::from_millis(150);

    fn operational() -> Node {
        let mut node = Node::new(2);
        (node.wanted, node.heard) = (NmtState::Operational, Some(NOW));
        assert!(!node.hear(NOW, NmtState::PreOperational), "it has not got there yet");
        assert!(!node.hear(NOW, NmtState::Operational));
        node
    }

    #[test]
    fn a_node_that_leaves_operational_is_told_once_and_stays_fallen() {
        for state in [NmtState::PreOperational, NmtState::Stopped, NmtState::BootUp] {
            let mut node = operational();
            assert!(node.hear(NOW, state));
            assert!(!node.hear(NOW, state), "{state:?}");
            node.hear(NOW, NmtState::Operational);
            assert!(node.has_fallen, "there is no way back");
        }
        let mut node = operational();
        node.wanted = NmtState::PreOperational;
        assert!(!node.hear(NOW, NmtState::PreOperational), "as it was told");
    }

    #[test]
    fn a_node_is_lost_after_the_limit_and_not_before() {
        let mut node = operational();
        assert_eq!(node.lose(NOW + LIMIT, LIMIT), None);
        let later = NOW + LIMIT + Duration::from_millis(1);
        assert_eq!(node.lose(later, LIMIT), Some(LIMIT + Duration::from_millis(1)));
        assert_eq!(node.lose(later, LIMIT), None, "told once");
        assert_eq!(Node::new(2).lose(later, LIMIT), None, "not watched yet");
    }

    #[test]
    fn inputs_are_handed_over_only_when_all_pdos_came() {
        let mut node = operational();
        (node.tpdos, node.slot.inputs) = ([6, 8, 0, 2], 1..17);
        let mut inputs = [0xEE; 18];
        node.receive(0, &[1; 6]);
        node.receive(1, &[2; 8]);
        node.receive(3, &[3]);
        assert!(!node.hand_over(&mut inputs), "the last one is too short");
        assert_eq!(inputs, [0xEE; 18]);
        node.receive(3, &[3; 8]);
        assert!(!node.hand_over(&mut inputs), "the others are of the SYNC before");
        for (k, data) in [(0, [1; 8]), (1, [2; 8]), (2, [9; 8]), (3, [3; 8])] {
            node.receive(k, &data);
        }
        node.receive(4, &[4; 8]);
        assert!(node.hand_over(&mut inputs));
        assert_eq!(inputs, [0xEE, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 3, 3, 0xEE]);
    }

    #[test]
    fn outputs_are_cut_into_pdos() {
        let mut node = operational();
        (node.rpdos, node.slot.outputs) = ([8, 2, 0, 0], 1..11);
        let outputs = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
        assert_eq!(node.rpdo(0, &outputs), Some(&outputs[1..9]));
        assert_eq!(node.rpdo(1, &outputs), Some(&outputs[9..11]));
        assert_eq!(node.rpdo(2, &outputs), None);
        assert_eq!(node.rpdo(1, &outputs[..10]), None);
    }
}
