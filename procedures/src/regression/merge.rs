//! Shards of an arm to the whole.

use std::collections::BTreeMap;

use super::arm::{ArmRecord, Shard};

/// A shard, and where it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct ShardFile {
    /// Folder or file, for messages.
    pub name: String,
    /// What is in it.
    pub record: ArmRecord,
}

/// Why shards do not make a whole.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// There is nothing to merge.
    #[error("no shard is given; name the folders that `regress --shard` wrote")]
    Nothing,
    /// Two shards of different comparisons.
    #[error("{other}: {what} differs from that of {first}; merge shards of one comparison only")]
    Differs {
        /// The first one.
        first: String,
        /// The other one.
        other: String,
        /// What differs.
        what: &'static str,
    },
    /// Two programs or processors, whose numbers may differ in their last digits.
    #[error(
        "{other}: run by {found}, and {first} by {expected}; run the shard again with the same program on such a processor, or \
         accept differences in last digits with --tolerant"
    )]
    OtherProgram {
        /// The first one.
        first: String,
        /// Its program.
        expected: String,
        /// The other one.
        other: String,
        /// Its program.
        found: String,
    },
    /// One shard twice.
    #[error("{other}: shard {number} of {parts} is in {first}, too; name each shard once")]
    Twice {
        /// The first one.
        first: String,
        /// The other one.
        other: String,
        /// Number of the shard.
        number: u32,
        /// How many there are.
        parts: u32,
    },
    /// Records of a sequential comparison, whose intervals are made for its looks.
    #[error("{name}: comes from a sequential comparison, which is decided already; merge shards only")]
    Sequential {
        /// Folder.
        name: String,
    },
    /// Shards that are not there.
    #[error(
        "shards {missing} of {parts} are missing; run each again alone, e.g. `bench regress … --shard {first}/{parts}`"
    )]
    Missing {
        /// Their numbers.
        missing: String,
        /// The first of them.
        first: u32,
        /// How many there are.
        parts: u32,
    },
    /// A shard without some of its runs.
    #[error("{name}: has {found} runs, its part of the units has {expected}; run the shard again")]
    Incomplete {
        /// The shard.
        name: String,
        /// Runs in it.
        found: usize,
        /// Runs that it should have.
        expected: usize,
    },
}

/// One record of all shards of an arm: the bytes that the undivided comparison writes. With `tolerant`, programs and processors may
/// differ; the first one is then named.
///
/// # Errors
/// All that keeps them from being a whole, at once.
pub fn merge(shards: &[ShardFile], tolerant: bool) -> Result<ArmRecord, Vec<MergeError>> {
    let Some(first) = shards.first() else { return Err(vec![MergeError::Nothing]) };
    let mut errors: Vec<MergeError> =
        shards[1..].iter().filter_map(|other| difference(first, other, tolerant)).collect();
    let mut by_number: BTreeMap<u32, &ShardFile> = BTreeMap::new();
    let parts = first.record.shard.parts;
    for shard in shards {
        let number = shard.record.shard.number;
        if let Some(before) = by_number.insert(number, shard) {
            let [first, other] = [before, shard].map(|shard| shard.name.clone());
            errors.push(MergeError::Twice { first, other, number, parts });
        }
    }
    let sequential = shards.iter().filter(|shard| shard.record.look.is_some());
    errors.extend(sequential.map(|shard| MergeError::Sequential { name: shard.name.clone() }));
    errors.extend(missing(&by_number, parts));
    errors.extend(shards.iter().filter_map(incomplete));
    if !errors.is_empty() {
        return Err(errors);
    }
    let mut whole = ArmRecord { shard: Shard::WHOLE, replicates: Vec::new(), ..first.record.clone() };
    whole.replicates = by_number.into_values().flat_map(|shard| shard.record.replicates.clone()).collect();
    whole.replicates.sort_by_key(|replicate| (replicate.unit, replicate.seed));
    Ok(whole)
}

/// The shards that are not there, if any; many are told by their first ones.
fn missing(by_number: &BTreeMap<u32, &ShardFile>, parts: u32) -> Option<MergeError> {
    const MOST_NAMED: usize = 20;
    let mut numbers = (1..=parts).filter(|number| !by_number.contains_key(number));
    let first = numbers.next()?;
    let mut named = vec![first.to_string()];
    named.extend(numbers.by_ref().take(MOST_NAMED - 1).map(|number| number.to_string()));
    let more = if numbers.next().is_some() { ", …" } else { "" };
    Some(MergeError::Missing { missing: named.join(", ") + more, first, parts })
}

/// Why two shards are not of one comparison.
fn difference(first: &ShardFile, other: &ShardFile, tolerant: bool) -> Option<MergeError> {
    let [a, b] = [&first.record, &other.record];
    let what = if a.shard.parts != b.shard.parts {
        Some("the number of shards")
    } else if a.controller != b.controller {
        Some("the controller")
    } else if a.scenario != b.scenario {
        Some("the scenario (campaign, rig, units, seeds)")
    } else {
        None
    };
    let names = || (first.name.clone(), other.name.clone());
    if let Some(what) = what {
        let (first, other) = names();
        return Some(MergeError::Differs { first, other, what });
    }
    let program = |record: &ArmRecord| {
        let digest = record.program.sha256.get(..12).unwrap_or(&record.program.sha256).to_owned();
        format!("bench {} ({digest}) on {}", record.program.version, record.program.processor)
    };
    (a.program != b.program && !tolerant).then(|| {
        let (first, other) = names();
        MergeError::OtherProgram { first, expected: program(a), other, found: program(b) }
    })
}

fn incomplete(shard: &ShardFile) -> Option<MergeError> {
    let scenario = &shard.record.scenario;
    let units = (1..=scenario.population.units).filter(|unit| shard.record.shard.holds(*unit)).count();
    let expected = units * scenario.seeds_per_unit as usize;
    let found = shard.record.replicates.len();
    (found != expected).then(|| MergeError::Incomplete { name: shard.name.clone(), found, expected })
}
