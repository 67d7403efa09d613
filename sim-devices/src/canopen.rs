//! CANopen at the far end of a CAN wire: a node in front of each simulated drive (CiA 301).
//!
//! Each node has network management, boot-up, heartbeats both ways, an SDO server (expedited and in segments), four PDOs each way
//! that follow SYNC, and emergency messages. Time is an argument: the nodes do not care whether their frames come over a
//! socket or from the same process.
//!
//! Not there: block transfers, PDOs by event or remote request, TIME, node guarding, LSS, a SYNC counter, the error history 1003h.
//! Resetting a node takes the torque away and gives its communication objects their first values; the drive keeps its settings, as
//! if they had been stored.

mod faults;
mod line;
mod link;
mod node;
mod objects;
mod process_data;
mod sdo;

pub use faults::NodeFault;
pub use line::CanOpenLine;
pub(crate) use line::Line;
pub use link::{InProcessCan, serve};

#[cfg(test)]
mod tests;
