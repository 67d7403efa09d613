//! Why the inertial unit gives no value.

use analysis::least_squares::FitError;

use crate::quantity::QuantityKind as Q;

/// Why the inertial unit gives no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the sentence of each says what it is")]
pub enum InertialReason {
    #[error("{samples} samples of the gyros, at least {least} are needed")]
    TooFewSamples { samples: usize, least: usize },
    #[error("gaps everywhere: no samples without a gap")]
    Gaps,
    #[error("{lost:.0} of {expected:.0} messages of the inertial unit are missing")]
    MessagesMissing { lost: f64, expected: f64 },
    #[error("gyro {gyro}: sample {sample} is not a number")]
    NotANumber { gyro: &'static str, sample: usize },
    #[error("the encoder showed {steps} steps, at least {least} are needed: it does not follow")]
    FewSteps { steps: usize, least: usize },
    #[error(
        "gyro {gyro} shows one value for half of the record, or the record is too short: it has no noise to compare with"
    )]
    NoNoise { gyro: &'static str },
    #[error(
        "gyro {gyro} shows one value for half of the record, or the record is too short: its step is not seen"
    )]
    FewValues { gyro: &'static str },
    #[error(
        "{period_s:.3} s from sample to sample: too long for the counter of the messages that a sample is the mean of"
    )]
    UncountedMessages { period_s: f64 },
    #[error("the steps of the encoder are not multiples of one step: its resolution is finer than its noise")]
    NoQuantum,
    #[error("the longest record without a gap lasts {longest_s:.0} s of {lasts_s:.0} s, but half is needed")]
    Interrupted { longest_s: f64, lasts_s: f64 },
    #[error(
        "the five noise processes do not describe the record: chi2/dof {misfit_ratio:.0}; another \
         disturbance, or the gyro was not at rest"
    )]
    NoNoises { misfit_ratio: f64 },
    #[error("not separable from the other noise processes in this record: at most {} (95 %)", readable(*.kind, *.most))]
    NotToldApart { kind: Q, most: f64 },
    #[error(
        "rests at {elevations} elevations over {}, but zero, gravity and biases need {least} over {}",
        Q::Angle.format(*.spread_rad),
        Q::Angle.format(*.least_rad)
    )]
    FewElevations { elevations: usize, least: usize, spread_rad: f64, least_rad: f64 },
    #[error("elevation by gravity: {0}")]
    Gravity(FitError),
}

/// Small rates are read in degrees an hour.
pub(crate) fn readable(kind: Q, value: f64) -> String {
    match kind {
        Q::AngularVelocity => format!("{:.4} deg/h", value.to_degrees() * 3600.0),
        _ => kind.format(value),
    }
}
