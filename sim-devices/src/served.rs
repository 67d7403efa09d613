//! Simulated devices at the far ends of lines of the operating system: ptys, TCP and UDP on the loopback interface.
//!
//! A pump stands between the host's end of a simulated line and the operating system, in the thread that owns the simulation.
//! Each call of `pump` moves what is due and returns at once. A peer that reads slowly, or not at all, never holds the
//! simulation up.

mod line;
mod link;
mod pace;
mod port;
mod pty;

pub use line::{LineCounts, LinePump};
pub use port::{PortCounts, PortPump};
