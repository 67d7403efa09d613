//! What can go wrong on the wire and at the nodes, and nowhere behind them.

use drivers::wire::can::CanErrorFrame;

/// Something that goes wrong from now on, or is put right again. `node` is a node-ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeFault {
    /// A node neither hears nor sends: its cable is broken, or mended.
    Silent {
        /// The node.
        node: u8,
        /// Whether the cable is broken.
        is_silent: bool,
    },
    /// The heartbeat of a node stops, or goes on.
    HeartbeatStopped {
        /// The node.
        node: u8,
        /// Whether it has stopped.
        is_stopped: bool,
    },
    /// A node does not answer SDO requests, or does so again.
    SdoMute {
        /// The node.
        node: u8,
        /// Whether it is mute.
        is_mute: bool,
    },
    /// The next answer with a toggle bit has the wrong one.
    WrongToggle {
        /// The node.
        node: u8,
    },
    /// A node answers every SDO request that begins a transfer by an abort.
    RefusesSdo {
        /// The node.
        node: u8,
        /// Abort code; `None` puts it right.
        code: Option<u32>,
    },
    /// A node sends an emergency message.
    Emergency {
        /// The node.
        node: u8,
        /// Error code as in 603Fh.
        code: u16,
        /// Error register as in 1001h.
        register: u8,
    },
    /// The supply of a node is interrupted: it begins anew.
    Restart {
        /// The node.
        node: u8,
    },
    /// The controller of the host reports an error. It shows where the wire is in process; on a real interface the controller
    /// itself would have to report it.
    ControllerError(CanErrorFrame),
}
