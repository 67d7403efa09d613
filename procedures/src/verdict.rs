//! Measurement against limit: acceptance, guard band, verdict, roll-up.

use serde::{Deserialize, Serialize};

use crate::measurement::Measurement;
use crate::requirement::{Requirement, Requirements};

/// Verdict. Order is the roll-up: the greatest of several counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum Verdict {
    /// Report only, or not judged.
    None,
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
    /// Procedure and judgement that decided; `None` if nothing was measured.
    pub decided_by: Option<(String, Judgement)>,
    /// How many measurements were judged.
    pub judged: usize,
    /// Whether the campaign must measure it.
    pub required: bool,
}

/// What a whole campaign comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum Overall {
    Pass,
    ConditionalPass,
    Incomplete,
    Inconclusive,
    ConditionalFail,
    Fail,
}

/// Holds one measurement against one requirement.
pub fn judge(measurement: &Measurement, index: usize, requirement: &Requirement) -> Judgement {
    let _ = (measurement, index, requirement);
    todo!()
}

/// Whether the requirement judges this measurement at all (measurand, axis, conditions).
pub fn applies(requirement: &Requirement, measurement: &Measurement) -> bool {
    let _ = (requirement, measurement);
    todo!()
}

/// Every requirement's outcome over all procedures (id, measurements), in the order of the requirements file.
pub fn roll_up(
    requirements: &Requirements,
    procedures: &[(String, Vec<Measurement>)],
    must_measure: &[String],
) -> (Vec<Outcome>, Overall) {
    let _ = (requirements, procedures, must_measure);
    todo!()
}
