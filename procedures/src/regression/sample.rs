//! What a comparison is told: both arms' values of each criterion on each unit, and what may be wrong with them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Criteria, Criterion, Look, named};

/// One of the two controllers of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "kebab-case")]
pub enum ArmName {
    /// The one that is compared with.
    #[error("baseline")]
    Baseline,
    /// The one that is compared.
    #[error("candidate")]
    Candidate,
}

/// What one arm measured on one unit with one seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Value in the SI unit of the measurand; `None` where the measurement is inconclusive.
    pub value: Option<f64>,
    /// Standard uncertainty of the value, same unit.
    pub u: f64,
    /// Whether the requirement passes, with or without condition.
    pub passes: bool,
}

/// Both arms on one unit with one seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Number of the unit.
    pub unit: u32,
    /// Seed of the run, the same in both arms.
    pub seed: u64,
    /// Reading with the baseline.
    pub baseline: Reading,
    /// Reading with the candidate.
    pub candidate: Reading,
}

/// All samples of one criterion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CriterionSamples {
    /// Id of the requirement, as in the criterion.
    pub requirement: String,
    /// Measurand, as in the criterion.
    pub measurand: String,
    /// Place, as in the criterion.
    pub place: String,
    /// In any order; each pair of unit and seed once.
    pub samples: Vec<Sample>,
}

/// Why a comparison cannot be decided at all: its input is wrong.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RegressionError {
    /// A criterion of the file that nothing was measured for.
    #[error(
        "criterion {criterion}: no sample of it was given; expected one for each unit: measure \
         the requirement in the campaign or remove the criterion"
    )]
    NoSamples {
        /// Name of the criterion.
        criterion: String,
    },
    /// Samples that no criterion asks for, or that are given twice.
    #[error(
        "samples of {criterion}: given {given} time(s) for {asked} criteria of this name; expected \
         them once for each criterion of the file"
    )]
    Unmatched {
        /// Name of the criterion.
        criterion: String,
        /// Lists of samples of this name.
        given: usize,
        /// Criteria of this name.
        asked: usize,
    },
    /// One unit and seed more than once.
    #[error(
        "criterion {criterion}: unit {unit} with seed {seed} is given {count} times; expected once: \
         check that no shard was merged twice"
    )]
    Repeated {
        /// Name of the criterion.
        criterion: String,
        /// Number of the unit.
        unit: u32,
        /// Seed of the run.
        seed: u64,
        /// How often it is given.
        count: usize,
    },
    /// A value or an uncertainty that is no number, or one beyond every quantity.
    #[error(
        "criterion {criterion}, unit {unit}, seed {seed}: the {arm} has value {value} and standard \
         uncertainty {u}; expected numbers below 1e100, the uncertainty not negative: measure this arm again"
    )]
    NoNumber {
        /// Name of the criterion.
        criterion: String,
        /// Number of the unit.
        unit: u32,
        /// Seed of the run.
        seed: u64,
        /// The arm.
        arm: ArmName,
        /// Its value, SI.
        value: f64,
        /// Its standard uncertainty, SI.
        u: f64,
    },
    /// A look that the criteria file does not plan.
    #[error("look {number} is asked for; expected 1 to {looks}, as `looks` of the criteria file plans them")]
    NoSuchLook {
        /// The look that is asked for.
        number: usize,
        /// Number of looks that are planned.
        looks: usize,
    },
}

/// Beyond this no value is a quantity, and sums of squares leave the range of a double.
const LARGEST: f64 = 1e100;

impl Sample {
    /// What is wrong with both readings.
    fn check(&self, of: &CriterionSamples) -> Vec<RegressionError> {
        let mut errors = Vec::new();
        for (arm, reading) in [(ArmName::Baseline, self.baseline), (ArmName::Candidate, self.candidate)] {
            let Reading { value: Some(value), u, .. } = reading else { continue };
            // Written so that what is no number is refused.
            let is_number = value.abs() < LARGEST && (0.0..LARGEST).contains(&u);
            if !is_number {
                errors.push(RegressionError::NoNumber {
                    criterion: of.name(),
                    unit: self.unit,
                    seed: self.seed,
                    arm,
                    value,
                    u,
                });
            }
        }
        errors
    }
}

impl CriterionSamples {
    /// What messages call them.
    fn name(&self) -> String {
        named(&self.requirement, &self.measurand, &self.place)
    }

    /// Whether these are samples of this criterion.
    pub(super) fn is_of(&self, criterion: &Criterion) -> bool {
        self.requirement == criterion.requirement
            && self.measurand == criterion.measurand
            && self.place == criterion.place
    }

    /// What is wrong with them, by unit and seed.
    fn check(&self) -> Vec<RegressionError> {
        let mut counts: BTreeMap<(u32, u64), usize> = BTreeMap::new();
        for sample in &self.samples {
            *counts.entry((sample.unit, sample.seed)).or_default() += 1;
        }
        let repeated = counts.into_iter().filter(|(_, count)| *count > 1);
        let repeated = repeated.map(|((unit, seed), count)| RegressionError::Repeated {
            criterion: self.name(),
            unit,
            seed,
            count,
        });
        let mut ordered: Vec<&Sample> = self.samples.iter().collect();
        ordered.sort_by_key(|sample| (sample.unit, sample.seed));
        repeated.chain(ordered.iter().flat_map(|sample| sample.check(self))).collect()
    }
}

/// All that is wrong with the samples of a comparison.
pub(super) fn check(criteria: &Criteria, samples: &[CriterionSamples], look: Look) -> Vec<RegressionError> {
    let mut errors = Vec::new();
    let looks = criteria.looks.len();
    if let Look::Sequential { number } = look
        && !(1..=looks).contains(&number)
    {
        errors.push(RegressionError::NoSuchLook { number, looks });
    }
    for criterion in &criteria.all {
        let is_measured = samples.iter().any(|own| own.is_of(criterion) && !own.samples.is_empty());
        if !is_measured {
            errors.push(RegressionError::NoSamples { criterion: criterion.name() });
        }
    }
    for own in samples {
        let asked = criteria.all.iter().filter(|criterion| own.is_of(criterion)).count();
        let given = samples.iter().filter(|other| other.name() == own.name()).count();
        if given != 1 || asked != 1 {
            errors.push(RegressionError::Unmatched { criterion: own.name(), given, asked });
        }
        errors.extend(own.check());
    }
    errors
}
