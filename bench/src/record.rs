//! What a run leaves in its folder beside its logs: title page, journal, evidence. Whoever reads a folder reads it here.

pub(crate) mod bounded;
pub(crate) mod durable;
pub mod evidence;
pub mod journal;
pub(crate) mod log;
pub(crate) mod page;
pub(crate) mod polarity;
pub mod tap;
