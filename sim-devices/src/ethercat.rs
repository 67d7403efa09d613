//! EtherCAT at the far end of an Ethernet wire: a line of SubDevices, in software, in front of the simulated drives and
//! terminals (ETG.1000).
//!
//! A frame passes every SubDevice and comes back. Each has a controller with registers, sync managers, FMMUs, SII
//! and distributed clock, the AL state machine, a mailbox with CANopen over EtherCAT, and a process data watchdog. Time is an
//! argument: the line does not care whether its frames come over a socket or from the same process.

mod application;
mod coe;
mod command;
mod digital;
mod drive;
mod esc;
mod faults;
mod frame;
mod line;
mod link;
mod mailbox;
mod objects;
mod sii;
mod states;
mod subdevice;
mod terminal;

pub use application::Emergency;
pub(crate) use esc::ClockError;
pub use faults::LineFault;
pub use line::{EtherCatLine, Passage, Terminals};
pub(crate) use line::{Line, LineSettings};
pub use link::InProcessLink;

#[cfg(test)]
mod tests;
