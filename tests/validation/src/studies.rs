//! One study a module.

pub(crate) mod blind;
pub(crate) mod compare_runs;
pub(crate) mod current_limits;
pub(crate) mod expected_results;
pub(crate) mod loop_margins;
pub(crate) mod measured_flips;
pub(crate) mod mode_map;
pub(crate) mod mutations;
pub(crate) mod planted_changes;
pub(crate) mod polarity;
pub(crate) mod published_tables;
pub(crate) mod recovery_allan;
pub(crate) mod recovery_chain;
pub(crate) mod recovery_margins;
pub(crate) mod recovery_modes;
pub(crate) mod recovery_tracking;
pub(crate) mod signals;
pub(crate) mod track_margins;
pub(crate) mod tracking;
pub(crate) mod trips;
pub(crate) mod twins;
pub(crate) mod wired_scatter;
