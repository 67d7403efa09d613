//! Pieces of physics that the world and the devices are made of.

pub mod cogging;
pub mod current_loop;
pub mod delay;
pub mod encoder;
pub mod flexible;
pub mod inertial;
pub mod lugre;
pub mod noise;
pub mod octave_table;
pub mod phasor;
pub mod piezo;
pub mod stops;
pub mod supply;
pub mod thermal;
