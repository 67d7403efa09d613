//! What sees a target: trackers, the mirror before them, loops that are closed on them.

pub(in crate::kinds) mod atmosphere;
pub(in crate::kinds) mod frames;
pub(in crate::kinds) mod optical_gain;
pub(in crate::kinds) mod track;
pub(in crate::kinds) mod tracker_latency;
