//! The loop: what happens in every tick, from enabling the drives to the safe state, and what a session ticks between points.
//!
//! Nothing here reads files, judges or talks to people: cases, the rig's limits and answers are handed in.

pub mod axis_loop;
pub mod channels;
pub mod dither;
pub(crate) mod gate;
pub mod interlock;
pub mod laws;
pub mod progress;
pub mod prompt;
pub mod recorder;
pub mod run;
pub mod safe;
pub mod sequence;
pub(crate) mod session;
pub mod stops;
pub mod velocity_loop;
