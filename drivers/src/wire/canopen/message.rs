//! Messages of CANopen as CAN frames: the predefined connection set, network management, heartbeats, emergencies (CiA 301).

use super::super::can::CanFrame;

/// Identifiers; those of a node have its node-ID added.
mod cob {
    pub(super) const NMT: u16 = 0x000;
    pub(super) const SYNC: u16 = 0x080;
    /// First PDO that a node receives; the next ones follow in steps of 100h.
    pub(super) const RPDO: u16 = 0x200;
    pub(super) const TPDO: u16 = 0x180;
    pub(super) const PDO_STEP: u16 = 0x100;
    pub(super) const SDO_REQUEST: u16 = 0x600;
    pub(super) const HEARTBEAT: u16 = 0x700;
}

/// Commands of network management.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NmtCommand {
    Start = 0x01,
    EnterPreOperational = 0x80,
    ResetCommunication = 0x82,
}

/// State of a node in network management, as its heartbeat tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NmtState {
    /// It has just begun anew; pre-operational comes next.
    BootUp,
    /// It answers nothing but network management.
    Stopped,
    /// PDOs and SDOs.
    Operational,
    /// SDOs only.
    PreOperational,
}

impl NmtState {
    /// From the byte of a heartbeat; bit 7 is the toggle bit of node guarding and counts for nothing.
    const fn from_byte(byte: u8) -> Option<Self> {
        match byte & 0x7F {
            0x00 => Some(Self::BootUp),
            0x04 => Some(Self::Stopped),
            0x05 => Some(Self::Operational),
            0x7F => Some(Self::PreOperational),
            _ => None,
        }
    }

    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::BootUp => "begun anew (boot-up)",
            Self::Stopped => "stopped",
            Self::Operational => "operational",
            Self::PreOperational => "pre-operational",
        }
    }
}

/// What a frame on the bus is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Message {
    /// A command or a SYNC: only the main device sends them.
    MainDevice,
    /// An emergency: error code (603Fh) and error register (1001h).
    Emergency { node: u8, code: u16, register: u8 },
    /// A PDO that a node has sent, the first being 0.
    Tpdo { node: u8, k: usize },
    /// An answer of an SDO server.
    SdoAnswer { node: u8 },
    /// A heartbeat or boot-up message.
    Heartbeat { node: u8, state: NmtState },
    /// Anything else.
    Other,
}

impl Message {
    pub(super) fn of(frame: &CanFrame) -> Self {
        let node = (frame.id() & 0x7F) as u8;
        match (frame.id() >> 7, node, frame.data()) {
            (0x0, 0, _) | (0x1, 0, _) => Self::MainDevice,
            (_, 0, _) => Self::Other,
            (0x1, _, &[low, high, register, ..]) => {
                Self::Emergency { node, code: u16::from_le_bytes([low, high]), register }
            }
            (function @ (0x3 | 0x5 | 0x7 | 0x9), ..) => Self::Tpdo { node, k: usize::from(function - 3) / 2 },
            (0xB, ..) => Self::SdoAnswer { node },
            (0xE, _, &[byte]) => {
                NmtState::from_byte(byte).map_or(Self::Other, |state| Self::Heartbeat { node, state })
            }
            _ => Self::Other,
        }
    }
}

/// Identifier of a PDO that a node receives, the first being 0.
pub(super) const fn rpdo_id(node: u8, k: u16) -> u16 {
    cob::RPDO + cob::PDO_STEP * k + node as u16
}

/// Identifier of a PDO that a node sends, the first being 0.
pub(super) const fn tpdo_id(node: u8, k: u16) -> u16 {
    cob::TPDO + cob::PDO_STEP * k + node as u16
}

pub(super) fn nmt(command: NmtCommand, node: u8) -> CanFrame {
    CanFrame::of(cob::NMT, [command as u8, node])
}

pub(super) fn sync() -> CanFrame {
    CanFrame::of(cob::SYNC, [])
}

pub(super) fn sdo_request(node: u8, request: [u8; 8]) -> CanFrame {
    CanFrame::of(cob::SDO_REQUEST + u16::from(node), request)
}

/// Heartbeat of the bench itself, which is always operational.
pub(super) fn heartbeat(node: u8) -> CanFrame {
    CanFrame::of(cob::HEARTBEAT + u16::from(node), [0x05])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Section 4.1 of docs/protocols.md.
    #[test]
    fn messages_are_told_apart_by_their_identifiers() {
        let rows: [(u16, &[u8], Message); 14] = [
            (0x000, &[0x01, 0x02], Message::MainDevice),
            (0x080, &[], Message::MainDevice),
            (0x081, &[0x01, 0x20, 0x02, 0, 1, 2, 3, 4], emergency(1, 0x2001, 2)),
            (0x0FF, &[0, 0, 0, 0, 0, 0, 0, 0], emergency(127, 0, 0)),
            (0x081, &[0x01, 0x20], Message::Other),
            (0x182, &[0; 8], Message::Tpdo { node: 2, k: 0 }),
            (0x482, &[], Message::Tpdo { node: 2, k: 3 }),
            (0x202, &[0; 8], Message::Other),
            (0x582, &[0x60], Message::SdoAnswer { node: 2 }),
            (0x602, &[0x40], Message::Other),
            (0x702, &[0x00], Message::Heartbeat { node: 2, state: NmtState::BootUp }),
            (0x702, &[0x05], Message::Heartbeat { node: 2, state: NmtState::Operational }),
            (0x702, &[0xFF], Message::Heartbeat { node: 2, state: NmtState::PreOperational }),
            (0x702, &[0x55], Message::Other),
        ];
        for (id, data, message) in rows {
            let frame = CanFrame::new(id, data).expect("a classic frame");
            assert_eq!(Message::of(&frame), message, "{id:03X}");
        }
    }

    fn emergency(node: u8, code: u16, register: u8) -> Message {
        Message::Emergency { node, code, register }
    }

    #[test]
    fn frames_of_the_main_device_are_those_of_the_predefined_connection_set() {
        let frame = |id, data: &[u8]| CanFrame::new(id, data).expect("a classic frame");
        assert_eq!(nmt(NmtCommand::Start, 2), frame(0x000, &[0x01, 0x02]));
        assert_eq!(nmt(NmtCommand::EnterPreOperational, 0), frame(0x000, &[0x80, 0]));
        assert_eq!(nmt(NmtCommand::ResetCommunication, 1), frame(0x000, &[0x82, 1]));
        assert_eq!(sync(), frame(0x080, &[]));
        assert_eq!(heartbeat(127), frame(0x77F, &[0x05]));
        assert_eq!([rpdo_id(2, 0), rpdo_id(2, 3)], [0x202, 0x502]);
        assert_eq!([tpdo_id(2, 0), tpdo_id(2, 3)], [0x182, 0x482]);
    }

    proptest! {
        #[test]
        fn no_frame_is_too_strange(id in 0_u16..0x800, data in prop::collection::vec(any::<u8>(), 0..=8)) {
            let frame = CanFrame::new(id, &data).expect("a classic frame");
            if let Message::Tpdo { node, k } = Message::of(&frame) {
                prop_assert_eq!(tpdo_id(node, k as u16), id);
            }
        }
    }
}
