//! Why friction, breakaway, the torque constant or the check of a model gives no value.

use analysis::breakaway::NoBreakaway;
use analysis::effort::NoEffort;
use analysis::stillness::StillnessError;
use analysis::stribeck::NoCurve;

use super::{Reason, after_colon};
use crate::missing::Missing;
use crate::quantity::QuantityKind as Q;

/// Why friction, breakaway, the torque constant or the check of a model gives no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the sentence of each says what it is")]
pub enum FrictionReason {
    #[error("fewer than {least} dwells with repeats broke away at 1 A/s or more")]
    TooFewDwells { least: usize },
    #[error("the point has no multisine")]
    NoMultisine,
    #[error("the presliding fit did not converge, or too few periods")]
    NoPresliding,
    #[error("z_ss unknown: the exponential fit did not converge for any ramp")]
    BendingUnknown,
    #[error("the exponential fit did not converge for any ramp")]
    NoFit,
    #[error("the point has no release")]
    NoRelease,
    #[error("does not hold: it slid when released, and {0}")]
    SlidOffReleased(NoBreakaway),
    #[error("map missing: the procedure has no stroke")]
    NoStroke,
    #[error("map missing: the stroke was not run")]
    StrokeNotRun,
    #[error("map missing: {reason}")]
    NoMap { reason: Box<Reason> },
    #[error("map missing: the stroke does not cover a cogging period in both directions")]
    StrokeTooShort,
    #[error("the point gave no result")]
    NothingReduced,
    #[error("the point has no `{label}`")]
    NoRamp { label: String },
    #[error("the point did not complete{}", after_colon(.trips))]
    NotCompleted { trips: Vec<String> },
    #[error("segment `{label}` is not in the log")]
    SegmentNotLogged { label: String },
    #[error("topic `{topic}` is not in the log")]
    TopicNotLogged { topic: String },
    #[error("channel `position_rad` is not in the log")]
    AngleNotLogged,
    #[error("neither `current_a` with a torque constant nor `torque_nm` is in the log")]
    TorqueNotLogged,
    #[error("position or torque contains values that are not numbers")]
    NoNumbers,
    #[error("saturated: the motor torque reached its limit of {limit_nm:.0} N·m")]
    Saturated { limit_nm: f64 },
    #[error("too few rows between {start_s:.3} s and {end_s:.3} s")]
    TooFewRows { start_s: f64, end_s: f64 },
    #[error("{0}")]
    NoEffort(NoEffort),
    #[error("the ramp's settle and dwell are not in the log")]
    NoSettleOrDwell,
    #[error("no rows just before {at_s:.3} s")]
    NoRowsBefore { at_s: f64 },
    #[error("the multisine segment contains no multisine")]
    NotAMultisine,
    #[error("the axis slid during the multisine")]
    SlidInMultisine,
    #[error("the multisine has no rows")]
    MultisineWithoutRows,
    #[error("the multisine's period has {samples:.3} rows, expected a whole number")]
    MultisinePeriod { samples: f64 },
    #[error("the axis slid during the dwell: it does not hold there")]
    SlidInDwell,
    #[error("no breakaway within {lasted_s:.1} s: {moved_mrad:.3} mrad moved, {most_nm:.1} N·m reached")]
    NoBreakawayWithin { lasted_s: f64, moved_mrad: f64, most_nm: f64 },
    #[error("the axis moved against the ramp, by {moved_mrad:.3} mrad: it does not hold there")]
    AgainstRamp { moved_mrad: f64 },
    #[error("the point gives no rate")]
    NoRate,
    #[error("the point gives no dwell")]
    NoDwell,
    #[error(
        "no valid point with {least} whole cogging periods at a velocity where the acceleration follows cogging"
    )]
    NoCogging { least: usize },
    #[error("no line above noise between orders {from:.0} and {to:.0}")]
    NoLine { from: f64, to: f64 },
    #[error(
        "the fastest measured velocity is {}, but {} were planned: a line through slow velocities alone \
         would follow the falling part of the Stribeck curve",
        Q::AngularVelocity.format(*.reached_rad_per_s),
        Q::AngularVelocity.format(*.fastest_rad_per_s)
    )]
    SlowOnly { reached_rad_per_s: f64, fastest_rad_per_s: f64 },
    #[error("not determined: {why}")]
    NoCurve { why: NoCurve },
    #[error(
        "unbalance (cos θ) and spring (θ) cannot be separated on this span: variance inflation \
         {inflation:.1} above {most:.0}"
    )]
    NotSeparated { inflation: f64, most: f64 },
    #[error("no valid point at ≤ 10 deg/s with {least} whole cogging periods where the loop had settled")]
    NoSlowPoint { least: usize },
    #[error("the plan has no axis {axis}")]
    NoAxis { axis: String },
    #[error("no steady sliding")]
    NoSteadySliding,
    #[error("{topic} has neither current_a nor torque_nm")]
    NeitherChannel { topic: String },
    #[error("{topic} contains values that are not numbers in position_rad or {channel}")]
    NotANumber { topic: String, channel: &'static str },
    #[error("no segment `{forward}` or `{reverse}` with {least} rows")]
    NoBranch { forward: &'static str, reverse: &'static str, least: usize },
    #[error("too few points for a spectrum")]
    TooFewPoints,
    #[error("one direction only: friction needs both")]
    OneDirection,
    #[error("the point gives no velocity")]
    NoVelocity,
    #[error("the strokes did not run")]
    StrokesNotRun,
    #[error("rows are missing in the strokes, or time does not advance")]
    RowsMissingInStrokes,
    #[error("the log rate is too low for an acceleration")]
    LogTooSlow,
    #[error("the branches have no whole cogging period in common, or fewer than two points in one")]
    NoSharedPeriod,
    #[error("a branch does not cover the common cogging periods")]
    BranchNotCovering,
    #[error("the strokes are shorter than the differentiator's window")]
    StrokesTooShort,
    #[error("a stroke does not cover the common cogging periods")]
    StrokeNotCovering,
    #[error("the plateau is shorter than one cogging period ({}) within 5 % of {} in both directions; the axis reached {}",
        Q::Angle.format(*.period_rad), Q::AngularVelocity.format(*.asked_rad_per_s), Q::AngularVelocity.format(*.reached_rad_per_s))]
    NotSteady { period_rad: f64, asked_rad_per_s: f64, reached_rad_per_s: f64 },
    #[error("{found} of 3 phases of the cogging were measured")]
    FewPhases { found: usize },
    #[error("the torque constant is unknown: the record is in amperes")]
    InAmpere,
    #[error("the strokes have no whole cogging period in common")]
    StrokesShareNone,
    #[error("not all of its three points ran")]
    NotAllRan,
    #[error("a point has no angles")]
    NoAngles,
    #[error("the points have no whole cogging period in common")]
    PointsShareNone,
    #[error("{point} does not cover the common angles")]
    NotCovering { point: String },
    #[error("no friction found: a sign is wrong")]
    NoFrictionSeen,
    #[error("{missing}: the rig needs a force gauge")]
    NoGauge { missing: Missing },
    #[error("zero: {0}")]
    Zero(StillnessError),
    #[error("the gauge was loaded before its zero was read")]
    PulledEarly,
    #[error("rows are missing in the pull, or time does not advance")]
    RowsMissingInPull,
    #[error("the pull did not keep the velocity within 10 % over {least} cogging periods")]
    NobodyPulled { least: f64 },
    #[error("the pull is too short, or its log too slow, for an acceleration")]
    PullTooShort,
    #[error("the readings of the gauge are not numbers")]
    GaugeNoNumbers,
}
