//! Two arms to pairs: what each measured on the same unit with the same seed.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::arm::{ArmRecord, End, Replicate, ReplicateValue};
use super::sample::{ArmName, CriterionSamples, Reading, Sample};
use super::{Criteria, Criterion};

/// Samples of two arms for [`super::decide`].
#[derive(Clone, Debug, PartialEq)]
pub struct Pairing {
    /// The criteria of the file, each once for every place where its measurand is found.
    pub criteria: Criteria,
    /// Samples of each of these, in their order.
    pub samples: Vec<CriterionSamples>,
    /// Runs that did not end as planned, by unit and seed. What they measured before counts.
    pub ends: Vec<UnitEnd>,
}

/// A unit and seed whose run was not completed in one arm or both.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UnitEnd {
    /// Number of the unit.
    pub unit: u32,
    /// Seed of the run.
    pub seed: u64,
    /// Why the run of the baseline ended early; `None` where it was completed.
    pub baseline: Option<String>,
    /// Likewise of the candidate.
    pub candidate: Option<String>,
    /// Whether the candidate ended in an earlier procedure than the baseline, or alone.
    pub candidate_first: bool,
}

/// Why two arms cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PairingError {
    /// The arms were not run through the same.
    #[error("{what}: the baseline has {baseline}, the candidate has {candidate}; run both arms alike")]
    Scenario {
        /// What differs.
        what: &'static str,
        /// Of the baseline.
        baseline: String,
        /// Of the candidate.
        candidate: String,
    },
    /// A unit and seed in one arm only.
    #[error(
        "unit {unit} with seed {seed} is in the {arm} only; both arms need the same units and seeds: run it in the other one"
    )]
    Alone {
        /// Number of the unit.
        unit: u32,
        /// Seed of the run.
        seed: u64,
        /// The arm that has it.
        arm: ArmName,
    },
    /// A unit and seed more than once in an arm.
    #[error(
        "unit {unit} with seed {seed} is in the {arm} {count} times; expected once: check that no shard was merged twice"
    )]
    Repeated {
        /// Number of the unit.
        unit: u32,
        /// Seed of the run.
        seed: u64,
        /// The arm.
        arm: ArmName,
        /// How often.
        count: usize,
    },
    /// A unit of this number that is not the same unit in both arms.
    #[error(
        "unit {unit}: the baseline ran `{baseline}`, the candidate `{candidate}`, whose files differ; run both arms with the same unit files"
    )]
    Unit {
        /// Number of the unit.
        unit: u32,
        /// Name of the baseline's.
        baseline: String,
        /// Name of the candidate's.
        candidate: String,
    },
    /// A finding that one arm never looked for.
    #[error(
        "criterion {criterion}: measured with the {arm} only; run the same campaign with both controllers"
    )]
    OneSided {
        /// Name of the criterion.
        criterion: String,
        /// The arm that measured it.
        arm: ArmName,
    },
    /// A criterion that neither arm measured.
    #[error(
        "criterion {criterion}: no completed run measured it; add a procedure that measures it to the campaign, or remove the criterion"
    )]
    Unmeasured {
        /// Name of the criterion.
        criterion: String,
    },
}

/// Pairs of both arms, with each criterion at each place where its measurand is found.
///
/// # Errors
/// All that keeps the arms from being compared, at once.
pub fn pair(
    criteria: &Criteria,
    baseline: &ArmRecord,
    candidate: &ArmRecord,
) -> Result<Pairing, Vec<PairingError>> {
    let mut errors = scenario(baseline, candidate);
    let [before, after] = [(baseline, ArmName::Baseline), (candidate, ArmName::Candidate)]
        .map(|(arm, name)| by_unit(arm, name, &mut errors));
    errors.extend(alone(&before, &after, ArmName::Baseline));
    errors.extend(alone(&after, &before, ArmName::Candidate));
    let both: Vec<Both<'_>> = before
        .iter()
        .filter_map(|(key, baseline)| Some(Both { baseline, candidate: after.get(key).copied()? }))
        .collect();
    errors.extend(both.iter().filter_map(Both::other_unit));
    if !errors.is_empty() {
        return Err(errors);
    }
    let ends = both.iter().filter_map(Both::end).collect();
    let mut pairing =
        Pairing { criteria: Criteria { all: Vec::new(), ..criteria.clone() }, samples: Vec::new(), ends };
    for criterion in &criteria.all {
        let places = places(criterion, &both);
        if places.is_empty() && both.iter().any(|both| both.end().is_none()) {
            errors.push(PairingError::Unmeasured { criterion: criterion.name() });
        }
        for place in places {
            let own = Criterion { place, ..criterion.clone() };
            match samples(&own, &both) {
                Ok(samples) => {
                    pairing.criteria.all.push(own);
                    pairing.samples.push(samples);
                }
                Err(arm) => errors.push(PairingError::OneSided { criterion: own.name(), arm }),
            }
        }
    }
    if errors.is_empty() { Ok(pairing) } else { Err(errors) }
}

/// A unit with a seed.
type Key = (u32, u64);

/// Both runs of a unit with a seed.
struct Both<'a> {
    baseline: &'a Replicate,
    candidate: &'a Replicate,
}

impl Both<'_> {
    fn end(&self) -> Option<UnitEnd> {
        let early = |replicate: &Replicate| match &replicate.end {
            End::Completed => None,
            End::Aborted { procedure, why } => Some((*procedure, why.clone())),
        };
        let [baseline, candidate] = [self.baseline, self.candidate].map(early);
        let is_early = baseline.is_some() || candidate.is_some();
        let candidate_first = match (&baseline, &candidate) {
            (_, None) => false,
            (None, Some(_)) => true,
            (Some((before, _)), Some((own, _))) => own < before,
        };
        is_early.then_some(UnitEnd {
            unit: self.baseline.unit,
            seed: self.baseline.seed,
            baseline: baseline.map(|(_, why)| why),
            candidate: candidate.map(|(_, why)| why),
            candidate_first,
        })
    }

    fn other_unit(&self) -> Option<PairingError> {
        (self.baseline.unit_sha256 != self.candidate.unit_sha256).then(|| PairingError::Unit {
            unit: self.baseline.unit,
            baseline: self.baseline.unit_id.clone(),
            candidate: self.candidate.unit_id.clone(),
        })
    }
}

/// Everything in which the arms were not run alike.
fn scenario(baseline: &ArmRecord, candidate: &ArmRecord) -> Vec<PairingError> {
    let [a, b] = [&baseline.scenario, &candidate.scenario];
    let digest = |sha256: &str| format!("files {}", sha256.get(..12).unwrap_or(sha256));
    let rows = [
        ("campaign", a.campaign.clone(), b.campaign.clone()),
        ("campaign files", digest(&a.campaign_sha256), digest(&b.campaign_sha256)),
        ("rig", a.rig.clone(), b.rig.clone()),
        ("rig file", digest(&a.rig_sha256), digest(&b.rig_sha256)),
        ("units", a.population.name.clone(), b.population.name.clone()),
        ("unit files", digest(&a.population.sha256), digest(&b.population.sha256)),
        ("number of units", a.population.units.to_string(), b.population.units.to_string()),
        ("seed", a.seed.to_string(), b.seed.to_string()),
        ("seeds of each unit", a.seeds_per_unit.to_string(), b.seeds_per_unit.to_string()),
        ("shard", shard(baseline), shard(candidate)),
    ];
    rows.into_iter()
        .filter(|(_, baseline, candidate)| baseline != candidate)
        .map(|(what, baseline, candidate)| PairingError::Scenario { what, baseline, candidate })
        .collect()
}

fn shard(arm: &ArmRecord) -> String {
    format!("{}/{}", arm.shard.number, arm.shard.parts)
}

fn by_unit<'a>(
    arm: &'a ArmRecord,
    name: ArmName,
    errors: &mut Vec<PairingError>,
) -> BTreeMap<Key, &'a Replicate> {
    let mut all = BTreeMap::new();
    let mut counts: BTreeMap<Key, usize> = BTreeMap::new();
    for replicate in &arm.replicates {
        let key = (replicate.unit, replicate.seed);
        all.insert(key, replicate);
        *counts.entry(key).or_default() += 1;
    }
    let repeated = counts.into_iter().filter(|(_, count)| *count > 1);
    errors.extend(repeated.map(|((unit, seed), count)| PairingError::Repeated {
        unit,
        seed,
        arm: name,
        count,
    }));
    all
}

fn alone(
    own: &BTreeMap<Key, &Replicate>,
    other: &BTreeMap<Key, &Replicate>,
    arm: ArmName,
) -> Vec<PairingError> {
    let only_here = own.keys().filter(|key| !other.contains_key(key));
    only_here.map(|&(unit, seed)| PairingError::Alone { unit, seed, arm }).collect()
}

/// Places where a criterion's measurand is found in either arm, in the order of the findings.
fn places(criterion: &Criterion, both: &[Both<'_>]) -> Vec<String> {
    let mut known = BTreeSet::new();
    let mut places = Vec::new();
    for value in both.iter().flat_map(|both| both.baseline.values.iter().chain(&both.candidate.values)) {
        if is_of(value, criterion) && known.insert(&value.place) {
            places.push(value.place.clone());
        }
    }
    places
}

fn is_of(value: &ReplicateValue, criterion: &Criterion) -> bool {
    value.requirement == criterion.requirement && value.measurand == criterion.measurand
}

/// Samples of a criterion at its place; the arm that alone measured it, where the other one never looked for it.
fn samples(criterion: &Criterion, both: &[Both<'_>]) -> Result<CriterionSamples, ArmName> {
    let reading =
        |replicate: &Replicate| {
            let mut found = replicate.values.iter();
            found
                .find(|value| is_of(value, criterion) && value.place == criterion.place)
                .map(|value| Reading { value: value.value, u: value.u, passes: value.passes })
        };
    let has = |replicate: &Replicate| reading(replicate).is_some();
    // An arm that always ended before it could measure this says nothing of the campaign.
    let never = |runs: Vec<&Replicate>| {
        runs.iter().any(|run| run.end == End::Completed) && !runs.iter().any(|run| has(run))
    };
    if never(both.iter().map(|both| both.baseline).collect()) {
        return Err(ArmName::Candidate);
    }
    if never(both.iter().map(|both| both.candidate).collect()) {
        return Err(ArmName::Baseline);
    }
    let none = Reading { value: None, u: 0.0, passes: false };
    let sample = |both: &Both<'_>| Sample {
        unit: both.baseline.unit,
        seed: both.baseline.seed,
        baseline: reading(both.baseline).unwrap_or(none),
        candidate: reading(both.candidate).unwrap_or(none),
    };
    Ok(CriterionSamples {
        requirement: criterion.requirement.clone(),
        measurand: criterion.measurand.clone(),
        place: criterion.place.clone(),
        samples: both.iter().map(sample).collect(),
    })
}
