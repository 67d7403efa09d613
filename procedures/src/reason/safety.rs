//! Why a check of signs, limits, stops, heat or channels gives no value.

use analysis::least_squares::FitError;

use super::Reason;
use super::in_brackets;
use crate::log::StopManner;
use crate::quantity::QuantityKind as Q;

/// Why a check of signs, limits, stops, heat or channels gives no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the sentence of each says what it is")]
pub enum SafetyReason {
    #[error("no segment ran")]
    NoSegment,
    #[error("no rows of {topic} while segments ran")]
    NoRows { topic: String },
    #[error("`{channel}` in {topic} contains a value that is not a number")]
    NotANumber { topic: String, channel: String },
    #[error("no whole cycle")]
    NoCycle,
    #[error("no samples")]
    NoSamples,
    #[error(
        "the record is too short, or the rise too small, to determine the time constant: run more cycles"
    )]
    ShortRecord,
    #[error("{reason}: the rig has no current clamps on the DC link")]
    NoClamps { reason: Box<Reason> },
    #[error("nothing was commanded")]
    NothingCommanded,
    #[error("torque and encoder: {0}")]
    TorqueAndEncoder(FitError),
    #[error("gyro and encoder: {0}")]
    GyroAndEncoder(FitError),
    #[error("the log has no topic /imu: there is no gyro to check the encoders against")]
    NoGyro,
    #[error("no rows in segment `{label}`")]
    NoRestRows { label: String },
    #[error("stopped by `{trip}` on the way: the axis was not ordered past the ends")]
    EndsTripped { trip: String },
    #[error("the plan does not give the ends")]
    NoEnds,
    #[error("the plan does not give the limits")]
    NoLimits,
    #[error("the plan does not give the zone")]
    NoZone,
    #[error("the area beside the zone is not restricted, but `{trip}` ended the move there")]
    Hindered { trip: String },
    #[error("the move did not reach the position of the zone")]
    BesideNotReached,
    #[error("the log has no channel {channel}")]
    NoChannel { channel: String },
    #[error("no new message came")]
    NoMessage,
    #[error("nothing is in view")]
    NothingInSight,
    #[error("the log has no {topic} {channel}")]
    NoAngle { topic: String, channel: &'static str },
    #[error("{topic} begins later")]
    BeginsLater { topic: String },
    #[error("{channel}: {reason}")]
    OfChannel { channel: String, reason: Box<Reason> },
    #[error("no rows, or values that are not numbers")]
    NoRowsOrNumbers,
    #[error("the name `{point}` does not give the manner of the stop")]
    NoManner { point: String },
    #[error("no stop of axis `{axis}` is in the log")]
    NoStop { axis: String },
    #[error("it was to be stopped {}, but was stopped {}", in_words(*.asked), in_words(*.found))]
    OtherManner { asked: StopManner, found: StopManner },
    #[error("it did not end at standstill")]
    NoStandstill,
    #[error("the record of the stop contains a value that is not a number")]
    StopNoNumber,
    #[error("no time is computed for stops without torque")]
    NoTimeComputed,
    #[error("the move came only to {} from the limit{}: the limit was not tested", Q::Angle.format(*.short_rad), and_ended(trip.as_deref()))]
    NotTested { short_rad: f64, trip: Option<String> },
    #[error("the point did not complete{}", in_brackets(.trips))]
    NotCompleted { trips: Vec<String> },
    #[error("tripped, {trip}")]
    Tripped { trip: String },
    #[error("the point was aborted")]
    BrokenOff,
}

fn in_words(manner: StopManner) -> &'static str {
    match manner {
        StopManner::Controlled => "under control",
        StopManner::QuickStop => "by the drive's quick stop",
        StopManner::LinkLimited => "as far as the DC link allowed",
        StopManner::TorqueOff => "without torque",
    }
}

fn and_ended(trip: Option<&str>) -> String {
    trip.map_or_else(String::new, |trip| format!(", and interlock `{trip}` ended it"))
}
