//! What a rig is: plain structs without a parser, a clock or a loop. [`crate::files`] makes them; loop, interlocks, plan and
//! judge read them.

pub mod address;
pub mod axis;
pub(crate) mod device;
pub(crate) mod instrument;
pub mod rig;
pub mod safety;
pub(crate) mod signs;
pub mod stopping;
pub mod terminal;
