//! Devices that do not exist: the far ends of the wires, and the world they act on.
//!
//! Nothing here reads a clock or draws a number by order: time is an argument, and noise is addressed by place.

mod analog_card;
pub mod analyser;
pub mod atmosphere;
mod bus;
pub mod canopen;
pub mod cia402;
mod director;
pub mod ethercat;
pub mod faults;
pub mod force_gauge;
mod inertial_unit;
pub mod kvh;
pub mod mirror;
pub mod motion;
pub mod operator;
mod payload;
pub mod physics;
pub mod reader;
pub mod reference;
pub mod rig;
pub mod scene;
pub mod scope;
mod scpi;
#[cfg(target_os = "linux")]
pub mod served;
pub mod stim300;
pub mod supply;
mod table;
pub mod target;
pub mod tracker;
mod transmitter;
pub mod unit;
pub mod world;
