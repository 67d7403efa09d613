//! Real time: what the ticking thread was granted, and how late its ticks came.

use procedures::log::{LatenessHistogram, Stall};
use serde::{Deserialize, Serialize};

/// Something that a ticking thread asked of the operating system.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Grant {
    /// What it asked for, e.g. `real-time priority`.
    pub what: String,
    /// Whether it has it.
    pub granted: bool,
    /// What it has, or what was in the way, e.g. a limit with its value.
    pub found: String,
    /// What to do to get it; `None` where it has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
}

/// How late the ticks of a part of a run came.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LatenessRecord {
    /// Log in the run folder.
    pub log: String,
    /// Name of the point, or `between points`.
    pub point: String,
    /// Loop rate.
    pub loop_rate_hz: f64,
    /// Its ticks.
    pub histogram: LatenessHistogram,
    /// Ticks that missed periods, in order of time; only the first thousand, and later ones that were longer than all before.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stalls: Vec<Stall>,
}
