//! Why something is inconclusive, refused or not applicable: every such sentence of the kinds stands below this module.

use analysis::allan::AllanError;
use analysis::breakaway::NoBreakaway;
use analysis::circuit::CircuitError;
use analysis::circuit::NoResonance;
use analysis::delay::DelayError;
use analysis::following::FollowingError;
use analysis::goodness::Hopeless;
use analysis::heating::HeatingError;
use analysis::lag::LagError;
use analysis::least_squares::FitError;
use analysis::lost_motion::NoLostMotion;
use analysis::margins::MarginError;
use analysis::margins::NoCrossing;
use analysis::modal::{ModalError, Unresolved};
use analysis::periodic::PeriodicError;
use analysis::pitch::PitchError;
use analysis::positioning::PositioningError;
use analysis::rational::RationalError;
use analysis::rejection::RejectionError;
use analysis::residual::ResidualError;
use analysis::spectra::SpectraError;
use analysis::step::StepError;
use analysis::stillness::StillnessError;
use analysis::stribeck::NoCurve;
use analysis::tracking::TrackingError;
use analysis::turning::TurningError;

use crate::axis::NoGimbal;
use crate::condition::shown;
use crate::missing::Missing;
use crate::quantity::QuantityKind;

mod friction;
mod inertial;
mod mirror;
mod optics;
mod position;
mod response;
mod safety;

pub use friction::FrictionReason;
pub use inertial::InertialReason;
pub(crate) use inertial::readable;
pub use mirror::MirrorReason;
pub use optics::{OpticsReason, TargetSeen};
pub use position::PositionReason;
pub use response::ResponseReason;
pub use safety::SafetyReason;

/// Why a point or a measurand has no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the sentence of each says what it is")]
pub enum Reason {
    #[error(transparent)]
    Gimbal(#[from] NoGimbal),
    #[error(transparent)]
    Missing(#[from] Missing),
    #[error("{point}: {reason}")]
    OfPoint { point: String, reason: Box<Reason> },
    #[error(transparent)]
    Allan(#[from] AllanError),
    #[error(transparent)]
    Breakaway(#[from] NoBreakaway),
    #[error(transparent)]
    Circuit(#[from] CircuitError),
    #[error(transparent)]
    Resonance(#[from] NoResonance),
    #[error(transparent)]
    Delay(#[from] DelayError),
    #[error(transparent)]
    Following(#[from] FollowingError),
    #[error(transparent)]
    Heating(#[from] HeatingError),
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error(transparent)]
    Hopeless(#[from] Hopeless),
    #[error(transparent)]
    Lag(#[from] LagError),
    #[error(transparent)]
    LostMotion(#[from] NoLostMotion),
    #[error(transparent)]
    Margin(#[from] MarginError),
    #[error(transparent)]
    Crossing(#[from] NoCrossing),
    #[error(transparent)]
    Damping(#[from] Unresolved),
    #[error(transparent)]
    Modal(#[from] ModalError),
    #[error(transparent)]
    Periodic(#[from] PeriodicError),
    #[error(transparent)]
    Positioning(#[from] PositioningError),
    #[error(transparent)]
    Rational(#[from] RationalError),
    #[error(transparent)]
    Rejection(#[from] RejectionError),
    #[error(transparent)]
    Residual(#[from] ResidualError),
    #[error(transparent)]
    Spectra(#[from] SpectraError),
    #[error(transparent)]
    Step(#[from] StepError),
    #[error(transparent)]
    Stillness(#[from] StillnessError),
    #[error(transparent)]
    Stribeck(#[from] NoCurve),
    #[error(transparent)]
    Tracking(#[from] TrackingError),
    #[error(transparent)]
    Pitch(#[from] PitchError),
    #[error(transparent)]
    Turning(#[from] TurningError),
    #[error(transparent)]
    Friction(#[from] FrictionReason),
    #[error(transparent)]
    Position(#[from] PositionReason),
    #[error(transparent)]
    Inertial(#[from] InertialReason),
    #[error(transparent)]
    Safety(#[from] SafetyReason),
    #[error(transparent)]
    Mirror(#[from] MirrorReason),
    #[error(transparent)]
    Optics(#[from] OpticsReason),
    #[error(transparent)]
    Response(#[from] ResponseReason),
    #[error("the point was {ending}{}", in_brackets(.trips))]
    BrokenOff { ending: Ending, trips: Vec<String> },
    #[error("{condition}: no measurement of the point reports the achieved value")]
    NotReported { condition: String },
    #[error("{condition}: {} requested, not reached", shown(condition, *.requested))]
    NotReached { condition: String, requested: f64 },
    #[error(
        "{condition}: {} requested, {} achieved, {} allowed",
        shown(condition, *.requested),
        shown(condition, *.achieved),
        QuantityKind::Ratio.format(*.allowed_ratio)
    )]
    Far { condition: String, requested: f64, achieved: f64, allowed_ratio: f64 },
    #[error(
        "dropped-cycles: {} of the periods missed, less than {} is allowed",
        QuantityKind::Ratio.format(*.missed_ratio),
        QuantityKind::Ratio.format(*.allowed_ratio)
    )]
    MissedPeriods { missed_ratio: f64, allowed_ratio: f64 },
    #[error(
        "dropped-cycles: longest gap {}, less than {} allowed",
        QuantityKind::Time.format(*.gap_s),
        QuantityKind::Time.format(*.allowed_s)
    )]
    LongGap { gap_s: f64, allowed_s: f64 },
}

impl Reason {
    /// A reason of a point, with its name.
    pub(crate) fn of_point(point: &str, reason: &Self) -> Self {
        Self::OfPoint { point: point.to_owned(), reason: Box::new(reason.clone()) }
    }
}

/// How a point ended that did not complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the sentence of each says what it is")]
pub enum Ending {
    #[error("aborted")]
    Aborted,
    #[error("aborted by an error of the bench")]
    Errored,
    #[error("lost: the log ends inside it")]
    Lost,
}

/// Interlocks that tripped, behind a sentence.
fn in_brackets(trips: &[String]) -> String {
    if trips.is_empty() { String::new() } else { format!(" ({})", trips.join("; ")) }
}

/// Interlocks that tripped, behind a colon.
fn after_colon(trips: &[String]) -> String {
    if trips.is_empty() { String::new() } else { format!(": {}", trips.join("; ")) }
}
