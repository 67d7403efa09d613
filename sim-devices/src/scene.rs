//! What the cameras see: target, atmosphere, line of sight, mirror.

pub mod spectrum;
