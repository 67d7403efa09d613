//! Runs of a regression: two controllers on the same units with the same seeds, many runs at a time, and the files that they leave.
//!
//! Everything here is in virtual time. What the arms measured is kept as [`ArmRecord`]; what it comes to is computed from these
//! records alone, so that merged shards give the bytes of one run.

pub mod population;
mod program;
mod replicate;
pub mod store;
mod work;

pub use program::this_program;
pub use replicate::RunFailure;
pub use work::{Arm, ArmFiles, Asked, Course, Stopped, planned_record, run_arms};

use procedures::regression::ArmRecord;

/// Records of both arms.
#[derive(Clone, Debug, PartialEq)]
pub struct Records {
    /// The baseline.
    pub baseline: ArmRecord,
    /// The candidate.
    pub candidate: ArmRecord,
}
