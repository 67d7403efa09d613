//! What a run leaves in its folder beside its logs: title page, journal, evidence. Whoever reads a folder reads it here.

/// The file of this very program, also where it was replaced since the program began.
pub(crate) const ITSELF: &str = "/proc/self/exe";

pub(crate) mod bounded;
pub(crate) mod durable;
pub mod evidence;
pub mod journal;
pub(crate) mod log;
pub(crate) mod page;
pub(crate) mod polarity;
pub mod tap;
