//! Wires: the only seam between real and simulated devices.

use std::ops::Range;
use std::time::Duration;

use crate::device::DeviceError;

mod analog;
pub mod can;
pub mod canopen;
mod datagram;
mod digital;
pub mod ethercat;
mod ethernet;
pub mod fault;
#[cfg(all(target_os = "linux", feature = "igh"))]
pub mod igh;
mod line;
#[cfg(target_os = "linux")]
pub mod lines;
#[cfg(target_os = "linux")]
mod packet_socket;
mod tap;

pub use analog::AnalogPort;
use can::CanErrorFrame;
use canopen::NmtState;
pub use datagram::DatagramPort;
pub use digital::DigitalPort;
pub use ethernet::{EthernetLink, MAX_FRAME_BYTES, StoredFrame, Way};
pub use line::ByteLine;
#[cfg(target_os = "linux")]
pub use packet_socket::{PacketSocket, addresses};
pub use tap::{FrameSink, Tap, TappedFrame};

/// Operating state of a bus (EtherCAT names).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BusState {
    /// Mailboxes only.
    PreOp,
    /// Inputs valid, outputs ignored.
    SafeOp,
    /// Inputs and outputs valid.
    Op,
}

/// What an exchange brought back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// Working counter of the frame.
    pub working_counter: u16,
    /// Working counter if every station took part.
    pub expected: u16,
}

/// The process image of one bus.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ProcessImage {
    /// Host to stations.
    pub outputs: Vec<u8>,
    /// Stations to host.
    pub inputs: Vec<u8>,
}

/// A station's part of the process image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Slot {
    /// Bytes that the host sends.
    pub outputs: Range<usize>,
    /// Bytes that the station sends.
    pub inputs: Range<usize>,
}

/// Why an SDO transfer failed: the CiA 301 abort code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SdoAbort(
    /// Abort code, e.g. 0602_0000h no such object.
    pub u32,
);

/// A transfer of an object of a station's dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SdoRequest<'a> {
    /// Station.
    pub station: u16,
    /// Index of the object.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
    /// Little-endian bytes of the object's exact width that are written; `None` reads.
    pub write: Option<&'a [u8]>,
}

/// How a wire carries process data objects (PDOs), which decides how a station's mapping is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PdoTransport {
    /// One PDO each way holds all objects of a station; the lists 1C12h and 1C13h assign it (EtherCAT).
    Assigned,
    /// Up to four PDOs each way, each of them a CAN frame of at most 8 bytes that 1400h... and 1800h... switch on (CANopen). In
    /// the process image the PDOs of a station follow each other without gaps.
    Frames,
}

/// Something that a station said by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Station; 0 is the bench's own end of the bus.
    pub station: u16,
    /// What it said.
    pub news: News,
}

/// What a station says by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// An emergency message: error code as in 603Fh, error register as in 1001h.
    Emergency {
        /// Error code; 0000h says that an earlier error is gone.
        code: u16,
        /// Error register.
        register: u8,
    },
    /// It refused a state of the bus or left one: AL status code (ETG.1000.6).
    AlError {
        /// AL status code.
        code: u16,
    },
    /// It left the state "operational" of a CANopen network, or began anew.
    NmtState {
        /// The state that it says it is in.
        state: NmtState,
    },
    /// Its heartbeat stays out.
    HeartbeatLost {
        /// How long it has been silent.
        silent: Duration,
    },
    /// The CAN controller of the bench reports an error.
    CanError(CanErrorFrame),
}

impl News {
    /// In words, with the code and what it means.
    pub fn text(&self) -> String {
        match *self {
            Self::Emergency { code: 0, .. } => "emergency 0000h, an earlier error is gone".to_owned(),
            Self::Emergency { code, register } => {
                let meaning = crate::cia402::error_code_meaning(code);
                format!("emergency {code:04X}h, {meaning} (error register {register:02X}h)")
            }
            Self::AlError { code } => {
                let meaning = ethercat::al_status_meaning(code);
                format!("left or refused a state of the bus: AL status code {code:04X}h, {meaning}")
            }
            Self::NmtState { state } => {
                format!("left the state operational by itself: it is {}", state.name())
            }
            Self::HeartbeatLost { silent } => format!("no heartbeat for {:.3} s", silent.as_secs_f64()),
            Self::CanError(error) => error.text(),
        }
    }
}

/// Acyclic access to the object dictionaries on a bus. One transfer is under way at a time; it is begun and then asked for,
/// so that no transfer holds up a cycle.
pub trait SdoWire {
    /// How the wire carries process data objects.
    fn pdo_transport(&self) -> PdoTransport;

    /// Begins a transfer. One that was under way is forgotten.
    fn start(&mut self, now: Duration, request: &SdoRequest<'_>);

    /// Whether the transfer that was begun last is over; what was read is then in `into`, as the station sent it.
    ///
    /// # Errors
    /// The station's abort code.
    fn poll(&mut self, now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort>;
}

/// One fieldbus: one exchange a tick for all its stations.
pub trait Fieldbus: SdoWire {
    /// Name for errors, e.g. `bus 0`.
    fn name(&self) -> &str;

    /// Stations found on the bus, in position order.
    fn stations(&self) -> Vec<u16>;

    /// Ends configuration: the stations' mappings are read and slots are laid out in station order.
    ///
    /// # Errors
    /// When a mapping is invalid.
    fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError>;

    /// Asks for a state; [`Fieldbus::state`] says when all stations have it.
    fn request(&mut self, state: BusState);

    /// The lowest state of all stations.
    fn state(&self) -> BusState;

    /// Whether a station took part in the last exchange, although not all did: its inputs are those of that exchange. What is known
    /// of no single station is false.
    fn took_part(&self, _station: u16) -> bool {
        false
    }

    /// No station holds anything: whoever drops the bus may take the stations out of operation altogether. Holds until the bus is
    /// asked for another state.
    fn let_go(&mut self) {}

    /// By how many nanoseconds the last exchange passed later than it should by the clock of the bus, or earlier by a negative
    /// number; `None` for a bus without a clock.
    fn lateness_ns(&self) -> Option<i64> {
        None
    }

    /// Time of the bus since the start of the run; `None` for a bus that has none of its own. Opening and mapping take time on a bus
    /// whose time passes while somebody waits for an answer.
    fn now(&self) -> Option<Duration> {
        None
    }

    /// Tells what stations have said by themselves since this was last called, oldest first.
    fn tell_notices(&mut self, _tell: &mut dyn FnMut(Notice)) {}

    /// Sends the outputs and takes the inputs that were sampled at `now` (since the start of the run).
    ///
    /// # Errors
    /// When no frame came back.
    fn exchange(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError>;
}
