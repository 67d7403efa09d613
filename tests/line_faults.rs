//! Faults of lines against what docs/safety.md §4 asks for: reaction and deadline, words that name device, field, expected,
//! found and what to do, and a log that is whole and re-judges alike.
//!
//! Devices are at the far ends of byte lines and datagram ports in process, in virtual time.

mod bed;
mod imu;
mod instruments;
mod mirror;
mod trackers;
mod troubles;
