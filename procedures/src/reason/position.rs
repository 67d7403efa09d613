//! Why a step, a slew, a profile, a rest or the accuracy of positions gives no value.

use analysis::step::StepError;
use analysis::stillness::StillnessError;

use crate::quantity::QuantityKind as Q;

/// Why a step, a slew, a profile, a rest or the accuracy of positions gives no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the sentence of each says what it is")]
pub enum PositionReason {
    #[error("{name} is not measured here")]
    NotMeasured { name: String },
    #[error("no pose was recorded")]
    NoPose,
    #[error("rows are missing at a target")]
    RowsMissingAtTarget,
    #[error(
        "no face of the polygon in view at {near_deg:.2} deg of the encoder, where the rig file has one: \
         the error of the encoder's zero exceeds the range of the autocollimator, or the polygon is turned"
    )]
    NoFaceInSight { near_deg: f64 },
    #[error("the polygon has no faces")]
    NoFaces,
    #[error("no reference was followed for long enough")]
    NothingFollowed,
    #[error("the reference does not move")]
    ReferenceRests,
    #[error("no interval of constant acceleration is long enough")]
    NoConstantAcceleration,
    #[error("too few rows")]
    TooFewRows,
    #[error("encoder and gyro disagree: {by_encoder:.4} and {by_gyro:.4} rad/s^2")]
    SensorsDisagree { by_encoder: f64, by_gyro: f64 },
    #[error("no cruise is long enough")]
    NoCruise,
    #[error("the move is shorter than 0.1 s")]
    ShortMove,
    #[error("no slew was recorded")]
    NoSlew,
    #[error("no rest after the slew to cue {cue}")]
    NoRestAfter { cue: usize },
    #[error("a slew without a planned end")]
    NoPlannedEnd,
    #[error("rows are missing in the slew to cue {cue}")]
    RowsMissingInSlew { cue: usize },
    #[error("slew to cue {cue}: {error}")]
    SlewNotRead { cue: usize, error: StepError },
    #[error("no move was recorded")]
    NoMove,
    #[error("the point was aborted")]
    BrokenOff,
    #[error("the point was aborted ({trip})")]
    Aborted { trip: String },
    #[error("no move is long enough")]
    NoLongMove,
    #[error("no end")]
    NoEnd,
    #[error("the slew to cue {cue} did not settle")]
    NotSettled { cue: usize },
    #[error("the axis was not at rest before")]
    NotAtRest,
    #[error("the torque constant is unknown")]
    NoTorqueConstant,
    #[error("position: {0}")]
    PositionAtRest(StillnessError),
    #[error("torque: {0}")]
    TorqueAtRest(StillnessError),
    #[error("the drive kept its torque: the axis was not at rest when the torque was to be switched off")]
    TorqueKept,
    #[error("{rows} rows without torque, at least {least} are needed")]
    TooFewReleased { rows: usize, least: usize },
    #[error("row {row} without torque: the position is not a number")]
    ReleasedNoNumber { row: usize },
    #[error("the point has no height of its steps")]
    NoHeight,
    #[error("{steps} steps `{label}`, at least {least} are needed")]
    TooFewSteps { steps: usize, label: &'static str, least: i64 },
    #[error("rows are missing around a step")]
    RowsMissingAroundStep,
    #[error("steps `{label}`: {error}")]
    StepNotRead { label: &'static str, error: StepError },
    #[error("the motor delivered {} where {} was commanded; the move was ended by {trip}",
        Q::Torque.format(*.shown_nm), Q::Torque.format(*.told_nm))]
    Weak { shown_nm: f64, told_nm: f64, trip: String },
    #[error("reference instrument missing")]
    NoReference,
}
