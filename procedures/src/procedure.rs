//! A procedure file: one experiment on one axis.

use crate::diagnostic::{Diagnostic, SourceFile};
use crate::kinds::Experiment;
use crate::quantity::Limit;

/// A condition that the log must meet for a point to count.
#[derive(Clone, Debug, PartialEq)]
pub enum ValidIf {
    /// The achieved condition lies within this ratio of the requested one, e.g. `velocity = "within 5 % of requested"`.
    Near {
        /// Name of the condition.
        condition: String,
        /// Allowed relative deviation.
        ratio: f64,
    },
    /// `dropped-cycles = "< 0.1 %, longest < 5 ms"`.
    DroppedCycles {
        /// Largest share of missed periods.
        ratio: f64,
        /// Longest gap.
        longest_s: f64,
    },
}

/// A procedure.
#[derive(Debug)]
pub struct Procedure {
    /// E.g. `AZ-FRICTION`; also the log's file name.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Name of its kind.
    pub kind: &'static str,
    /// Axis it moves.
    pub axis: String,
    /// Rows per second in the log; the loop rate if `None`.
    pub log_rate_hz: Option<f64>,
    /// What must hold before motion, by channel, e.g. heat-sink `< 60 degC`.
    pub gates: Vec<(String, Limit)>,
    /// What must hold of a point.
    pub valid_if: Vec<ValidIf>,
    /// The kind's own part.
    pub experiment: Box<dyn Experiment>,
    /// The file, kept verbatim for the log.
    pub source: SourceFile,
}

impl Procedure {
    /// Parses a procedure file. `points` of a campaign (`{ velocity = ["10 deg/s"] }`) narrow a sweep: see
    /// [`crate::campaign`]; they are applied by the kind's planning through [`Procedure::plan`].
    ///
    /// # Errors
    /// All mistakes at once.
    pub fn parse(source: SourceFile) -> Result<Self, Vec<Diagnostic>> {
        let _ = source;
        todo!()
    }
}
