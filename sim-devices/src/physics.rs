//! Pieces of physics that the world and the drives are made of.

pub mod cogging;
pub mod encoder;
pub mod lugre;
pub mod noise;
pub mod phasor;
pub mod stops;
pub mod thermal;
