//! Devices that do not exist: the far ends of the wires, and the world they act on.

pub mod rig;
pub mod unit;
