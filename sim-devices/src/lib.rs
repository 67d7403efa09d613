//! Devices that do not exist: the far ends of the wires, and the world they act on.
//!
//! Nothing here reads a clock or draws a number by order: time is an argument, and noise is addressed by place.

mod bus;
pub mod cia402;
pub mod physics;
pub mod rig;
pub mod unit;
pub mod world;
