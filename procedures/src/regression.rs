//! Regression of controllers: a candidate beside a baseline over the same units, criterion by criterion.
//!
//! A criterion names a requirement and a margin. Both arms measure the requirement's measurand on every unit; the replicate is
//! the unit, and several seeds of one unit are averaged first. The shift of a unit is the candidate less the baseline, as a
//! difference or as the logarithm of their ratio, with the sign that makes + worse. [`decide`] calls each criterion by the
//! interval of the mean shift.
//!
//! Equivalence by an interval inside of margins: Schuirmann, *J. Pharmacokin. Biopharm.* 15, 657 (1987). Family of blocking
//! criteria: Holm, *Scand. J. Statist.* 6, 65 (1979). Looks at a growing number of units: Pocock, *Biometrika* 64, 191 (1977).
//! Methods: estimators.md §1.9.

use serde::{Deserialize, Serialize};

use crate::quantity::QuantityKind;
use crate::table::{Field, SCHEMA_FIELD, Shape};

mod arm;
mod criteria;
mod decide;
mod decision;
mod measurands;
mod merge;
mod pairs;
mod proposal;
mod sample;
#[cfg(test)]
mod tests;

pub use arm::{
    ARM_SCHEMA, ArmRecord, Controller, End, Population, Program, Replicate, ReplicateValue, Scenario, Shard,
};
pub use decide::{FAMILY_LEVEL, decide};
pub use decision::{Arm, Call, Decision, LostPass, Outcome, Undecided, UnitShift};
pub use merge::{MergeError, ShardFile, merge};
pub use pairs::{Pairing, PairingError, UnitEnd, pair};
pub use proposal::{Baseline, propose};
pub use sample::{ArmName, CriterionSamples, Reading, RegressionError, Sample};

/// How a candidate's value is compared with a baseline's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// Candidate less baseline, in the SI unit of the measurand.
    Difference,
    /// Natural logarithm of candidate over baseline; both must be above zero.
    LogRatio,
}

/// Which way a measurand becomes worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Worse {
    /// A higher value is worse, as where the limit is an upper one.
    Higher,
    /// A lower value is worse, as where the limit is a lower one.
    Lower,
}

/// One criterion: a measurand of a requirement, and how much worse it may become.
///
/// A criterion of a file is about every place where the measurand is found; [`pair`] makes one of each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Criterion {
    /// Id of the requirement, e.g. `VEL-BW`.
    pub requirement: String,
    /// Measurand of that requirement, e.g. `velocity-bandwidth`.
    pub measurand: String,
    /// Where it is found: procedure, axis and point, e.g. `AZ-VELOCITY-LOOP az, elevation 60 deg`; empty in a criteria file.
    pub place: String,
    /// Kind of quantity of the measurand's values.
    pub kind: QuantityKind,
    /// Margin of equivalence, above zero: in the SI unit of `kind`, or the logarithm of a ratio, by `scale`.
    pub margin: f64,
    /// How values are compared.
    pub scale: Scale,
    /// Which way the measurand becomes worse.
    pub worse: Worse,
    /// Whether a worse candidate is to be stopped; otherwise the criterion is only reported.
    pub blocking: bool,
}

impl Criterion {
    /// What messages call it: `VEL-BW (velocity-bandwidth)`, followed by its place where it has one.
    pub fn name(&self) -> String {
        named(&self.requirement, &self.measurand, &self.place)
    }
}

/// What a criterion of these three is called.
fn named(requirement: &str, measurand: &str, place: &str) -> String {
    let name = format!("{requirement} ({measurand})");
    if place.is_empty() { name } else { format!("{name} of {place}") }
}

/// All criteria of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Criteria {
    /// Numbers of units at which a sequential comparison looks, ascending.
    pub looks: Vec<u32>,
    /// In the order of the file; no measurand of a requirement stands twice.
    pub all: Vec<Criterion>,
}

/// When a comparison is looked at: how wide its intervals are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Look {
    /// Once, with a number of units that was fixed beforehand.
    Single,
    /// One of several looks at a growing number of units.
    Sequential {
        /// Which one, from 1.
        number: usize,
    },
}

/// Two-sided level of the intervals of a single look.
const SINGLE_LEVEL: f64 = 0.90;
/// Two-sided level of the intervals at each of four looks: 0.032 outside at each, 0.10 over all.
const SEQUENTIAL_LEVEL: f64 = 0.968;

impl Look {
    /// Two-sided level of the intervals.
    pub fn level(self) -> f64 {
        match self {
            Self::Single => SINGLE_LEVEL,
            Self::Sequential { .. } => SEQUENTIAL_LEVEL,
        }
    }
}

impl Scale {
    /// Name in criteria files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Difference => "difference",
            Self::LogRatio => "log-ratio",
        }
    }
}

impl Worse {
    /// Name in criteria files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Higher => "higher",
            Self::Lower => "lower",
        }
    }
}

/// Keys of one criterion.
const CRITERION: &[Field] = &[
    Field::required(
        "requirement",
        Shape::Text,
        "Id of a requirement that the campaign measures, e.g. `VEL-BW`.",
    ),
    Field::optional(
        "measurand",
        Shape::Text,
        "Measurand of the requirement; required where the requirement judges several.",
    ),
    Field::required(
        "margin",
        Shape::Text,
        "By how much a candidate may differ and still count as equivalent: in the quantity of the measurand \
         for a difference, e.g. `0.1 Hz`; a percentage for a log-ratio, e.g. `5 %`.",
    ),
    Field::optional(
        "scale",
        Shape::Choice(&["difference", "log-ratio"]),
        "How values are compared; default: log-ratio for measurands that are always above zero (RMS, peaks, \
         times), difference for all others.",
    ),
    Field::optional(
        "worse",
        Shape::Choice(&["higher", "lower"]),
        "Which way the measurand becomes worse; default: higher for an upper limit, lower for a lower limit; by \
         the goal where there is no limit.",
    ),
    Field::default("blocking", Shape::Boolean, "true", "`false`: the criterion is only reported."),
];

/// Keys of a criteria file, `regress.toml`.
pub const FIELDS: &[Field] = &[
    SCHEMA_FIELD,
    Field::default(
        "looks",
        Shape::Integers,
        "5, 10, 20, 40",
        "Numbers of units at which a sequential comparison looks: at most four, ascending, each at most twice \
         the one before.",
    ),
    Field::required("criterion", Shape::Tables(CRITERION), "Every criterion, `[[criterion]]`."),
];
