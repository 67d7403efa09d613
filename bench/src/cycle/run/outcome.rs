//! How a point ends: what stopped it, what failed, how the rig was left.

use std::fmt::Display;

use procedures::log::PointStatus;

use crate::cycle::interlock::Trip;
use crate::cycle::safe::Safe;
use crate::cycle::stops::StopNumbers;

/// What failed in the bench.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PointError {
    /// A defect of the bench: a part of it panicked.
    #[error("internal error: {0}")]
    Internal(&'static str),
    /// A device, the log, the rig, or the time that the point took.
    #[error("{0}")]
    Bench(String),
}

/// How a point ended.
#[derive(Clone, Debug, PartialEq)]
pub struct PointOutcome {
    /// Status for the log.
    pub status: PointStatus,
    /// What tripped first.
    pub trip: Option<Trip>,
    /// What was wrong with the sensor that the interlock missed, or with the external law, where it did.
    pub cause: Option<String>,
    /// A gate that refused before motion.
    pub refused: Option<String>,
    /// What failed in the bench.
    pub error: Option<PointError>,
    /// Exit code of the signal that stopped it.
    pub signal: Option<u8>,
    /// Loop time that passed, `make_safe` included.
    pub loop_s: f64,
    /// How the rig was left.
    pub safe: Safe,
    /// The stops, one an axis at the most.
    pub stops: Vec<StopNumbers>,
}

/// Why the loop proper ended.
#[derive(Debug, Default)]
pub(super) struct Ending {
    pub(super) trip: Option<Trip>,
    /// What was wrong with the sensor that it missed.
    pub(super) cause: Option<String>,
    pub(super) refused: Option<String>,
    pub(super) error: Option<PointError>,
    pub(super) signal: Option<u8>,
    /// The trip is what the point was to show: a limit of its own that held.
    pub(super) expected: bool,
}

impl Ending {
    /// Whether the point is being stopped.
    pub(super) fn stops(&self) -> bool {
        self.trip.is_some() || self.error.is_some() || self.signal.is_some() || self.refused.is_some()
    }

    /// An interlock tripped: the first one counts, with what is wrong with the sensor that it missed, or with the law.
    pub(super) fn take_trip(&mut self, trip: Trip, cause: impl FnOnce() -> Option<String>) {
        if self.trip.is_none() {
            (self.trip, self.cause) = (Some(trip), cause());
        }
    }

    /// Something failed that is no defect of the bench; what failed before it stays the reason.
    pub(super) fn fail(&mut self, what: impl Display) {
        self.error.get_or_insert_with(|| PointError::Bench(what.to_string()));
    }

    /// Status for the log.
    pub(super) fn status(&self) -> PointStatus {
        if self.error.is_some() {
            PointStatus::Errored
        } else if self.signal.is_some() || self.refused.is_some() || (self.trip.is_some() && !self.expected) {
            PointStatus::Aborted
        } else {
            PointStatus::Completed
        }
    }
}
