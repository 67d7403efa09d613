//! Drivers: how the bench talks to devices. A driver speaks to a [`wire`]; it cannot tell a simulated far end from
//! a real one. Time is an argument, nothing here reads a clock.

pub mod analyser;
mod answer;
pub mod cia402;
pub mod crc32;
pub mod device;
mod framing;
pub mod gcs;
mod identity_range;
pub mod kvh;
pub mod mirror;
pub mod reader;
pub mod scope;
pub mod scpi;
pub mod stim300;
pub mod supply;
pub mod tracker;
pub mod wire;
