//! Real time: what a ticking thread asks of Linux, how late its ticks come, and what a machine can do.
//!
//! Everything that is asked for is best effort: a thread that is refused a right ticks without it, and the run says so.

mod beat;
mod fifo;
mod phase;
mod processors;
mod rights;

pub mod check;
pub mod facts;
pub mod privileges;

pub use beat::{Woken, wake};
pub use phase::PhaseLock;
pub(crate) use rights::keep_off;
pub use rights::{Rights, lock_present_memory};
