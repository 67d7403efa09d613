//! Measurement against limit: acceptance, guard band, verdict, roll-up.
//!
//! Rules and words: ILAC-G8:09/2019 (non-binary statements), ISO 14253-1:2017 (guard band 1.65 u), JCGM 106:2012
//! (probability of conformity). The coverage factor comes from Student's t with the measurement's effective degrees
//! of freedom, so that the risk of a false accept stays what the rule says also for few repeats.

use serde::{Deserialize, Serialize};

use crate::measurement::Measurement;
use crate::quantity::Limit;
use crate::requirement::Requirement;

mod decide;
mod roll_up;

#[cfg(test)]
mod tests;

pub(crate) use decide::two_sided_tail;
pub use decide::{coverage_factor, judge};
pub use roll_up::roll_up;

/// Below this many effective degrees of freedom u itself is too uncertain for a verdict.
pub const LEAST_DOF: f64 = 4.0;

/// Verdict. Order is the roll-up: the greatest of several counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum Verdict {
    /// Report only, or not judged.
    #[default]
    None,
    /// No shortfall in a first look that did not cover all that the requirement claims: no statement of conformity.
    Screened,
    Pass,
    ConditionalPass,
    Inconclusive,
    ConditionalFail,
    Fail,
}

/// One measurement held against one requirement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// Requirement id.
    pub requirement: String,
    /// Index of the measurement in its procedure's list.
    pub measurement: usize,
    /// Coverage factor k = t(0.97725, ν).
    pub k: f64,
    /// Expanded uncertainty U = k·u.
    pub expanded_u: f64,
    /// Width of the guard band.
    pub guard_band: f64,
    /// Acceptance limits after the guard band.
    pub acceptance: [Option<f64>; 2],
    /// Distance to the nearest limit, positive inside.
    pub margin: Option<f64>,
    /// Probability that the true value is outside the limit (t distribution with ν).
    pub probability_outside: Option<f64>,
    /// The verdict.
    pub verdict: Verdict,
    /// The limit that held for this measurement, where it is not the one that holds for all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<Limit>,
    /// The band of conditions that this limit belongs to, as a person wrote it; `None` where it belongs to none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub band: Option<String>,
    /// Whether the goal is met, if there is one.
    pub goal_met: Option<bool>,
    /// Why it is inconclusive.
    pub reason: Option<String>,
}

/// A requirement's outcome over everything measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Requirement id.
    pub requirement: String,
    /// Roll-up.
    pub verdict: Verdict,
    /// Verdict of what was measured, whatever axes and stretches of conditions it leaves out.
    #[serde(default)]
    pub before_coverage: Verdict,
    /// Procedure and judgement that decided; `None` if nothing was measured.
    pub decided_by: Option<(String, Judgement)>,
    /// The same for each limit of each measurand that the requirement judges and somebody measured, in the order of the requirement.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_measurand: Vec<MeasurandOutcome>,
    /// How many measurements were judged.
    pub judged: usize,
    /// Whether the campaign must measure it.
    pub required: bool,
    /// Why it is inconclusive although everything measured would pass, e.g. what was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// What came of one of the limits of a requirement: that of a measurand, or of one of its bands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasurandOutcome {
    /// The measurand.
    pub measurand: String,
    /// The band of conditions, as text, whose limit it is; `None`: that of everything outside of bands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub band: Option<String>,
    /// Verdict of its worst measurement, as the requirement's coverage leaves it.
    pub verdict: Verdict,
    /// Procedure and judgement of that measurement.
    pub decided_by: (String, Judgement),
    /// How many measurements were judged by this limit.
    pub judged: usize,
}

/// What a whole campaign comes to. Order is the roll-up: the greatest of several counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum Overall {
    Pass,
    ConditionalPass,
    /// No shortfall in a first look: not an acceptance.
    Screening,
    Incomplete,
    Inconclusive,
    ConditionalFail,
    Fail,
}

/// Whether the requirement judges this measurement at all (measurand, axis, conditions).
pub fn applies(requirement: &Requirement, measurement: &Measurement) -> bool {
    let meets = |w: &crate::requirement::Where| {
        let condition = measurement.conditions.iter().find(|c| c.name == w.condition);
        condition.is_none_or(|condition| w.meets.holds(condition))
    };
    requirement.judged(&measurement.measurand).is_some()
        && requirement.axis.as_ref().is_none_or(|axis| *axis == measurement.axis)
        && requirement.conditions.iter().all(meets)
}
