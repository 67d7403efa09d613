//! Delays: from a phase slope, beside dynamics, between two records, from the onset of steps; clocks side by side.
//!
//! No number of a delay means anything without what it holds: every result says so in [`Includes`].

mod correlate;
mod input;
mod joint;
mod onset;
mod skew;
mod slope;
#[cfg(test)]
mod tests;

pub use correlate::{Band, CrossDelay, cross_correlation};
pub use input::InputError;
pub(crate) use input::{check_lines, line_sd};
pub use joint::{Dynamics, JointDelay, joint};
pub use onset::{Onset, OnsetShape, Step, half_rise, step_onset};
pub use skew::{ClockFit, clock_fit};
pub use slope::{PhaseSlope, phase_slope};

use crate::goodness::Hopeless;

/// What a delay holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Includes {
    /// The slope of the phase: transport, computing, Σ2ζ/ω of all dynamics below the band, Ts/2 of a hold in the path.
    WholePhaseSlope,
    /// Transport, computing, and Ts/2 of a hold in the path; the fitted dynamics are taken out.
    TransportAndHold,
    /// Transport and computing from the command to the first movement; neither lag nor hold.
    TransportToOnset,
}

/// Why there is no delay.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DelayError {
    /// The input is none.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Delay and dynamics act alike on these lines.
    #[error(
        "delay and dynamics are not separable: correlation {correlation}, at most {most}: measure up to a \
         higher frequency, or take the dynamics from another measurement"
    )]
    NotSeparable {
        /// Largest correlation of the delay with a parameter of the dynamics, by size.
        correlation: f64,
        /// The most that was allowed.
        most: f64,
    },
    /// The model does not describe the lines.
    #[error(transparent)]
    Hopeless(#[from] Hopeless),
    /// No convergence from any start.
    #[error("no fit: the response is not a delay with the given dynamics")]
    NoFit,
    /// The records do not resemble each other in the band.
    #[error(
        "largest correlation {found} between the records, at least {least} is needed: wrong channel, or too much noise"
    )]
    Unlike {
        /// Largest normalised correlation found.
        found: f64,
        /// Least that is taken.
        least: f64,
    },
    /// Nothing moves after the command.
    #[error("repeat {repeat}: no response above the noise after the command")]
    NoOnset {
        /// Index of the repeat.
        repeat: usize,
    },
}
