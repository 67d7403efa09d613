//! A procedure file: one experiment on one axis.

use crate::axis::Axes;
use crate::campaign::Subset;
use crate::case::Case;
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::kinds::Experiment;
use crate::log::Window;
use crate::measurement::PointResult;
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

    /// The points to run: the kind's plan, narrowed to `subsets`, each checked against the axis limits by its
    /// envelope (travel, velocity, acceleration, torque) with a diagnostic for each excess.
    ///
    /// # Errors
    /// What the axis cannot do, or a subset value that the sweep does not have (with the values it has).
    pub fn plan(&self, axes: &Axes, subsets: &[Subset]) -> Result<Vec<Case>, Vec<Diagnostic>> {
        let _ = (axes, subsets);
        todo!()
    }

    /// Analyses one point and applies `valid-if`: measurements of a point whose window or achieved conditions break
    /// it become inconclusive with the reason; so does everything of a point that did not complete.
    pub fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        let _ = (case, window, axes);
        todo!()
    }
}
