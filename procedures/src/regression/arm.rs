//! What one arm of a comparison measured, as it is kept in a file: on which units, with which seeds, by which program.

use serde::{Deserialize, Serialize};

/// Name and version of the structure of an arm file.
pub const ARM_SCHEMA: &str = "regression-arm/1";

/// One controller on all units, or on those of a shard.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmRecord {
    /// Always [`ARM_SCHEMA`].
    pub schema: String,
    /// The program that ran it.
    pub program: Program,
    /// The controller.
    pub controller: Controller,
    /// What it was run through; the same for both arms of a comparison.
    pub scenario: Scenario,
    /// Which part of the units this is.
    pub shard: Shard,
    /// Number of the look of a sequential comparison; `None` for one with a number of units that was fixed beforehand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look: Option<usize>,
    /// By unit, then by seed.
    pub replicates: Vec<Replicate>,
}

/// The program that ran an arm. Two runs give the same bytes only where all of it is the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Version.
    pub version: String,
    /// SHA-256 of the executable file.
    pub sha256: String,
    /// Architecture and the features of the processor on which arithmetic depends.
    pub processor: String,
}

/// The controller of an arm.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Controller {
    /// Parameters as they were asked for: a shipped name or a path.
    pub parameters: String,
    /// Digest of every gain and law in use.
    pub sha256: String,
    /// Changes of the director that belong to this arm alone: file names of states laid over each unit, with their SHA-256.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<String>,
    /// External velocity laws: axis, name and version, SHA-256 of the library.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub laws: Vec<String>,
}

/// What both arms are run through.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Scenario {
    /// Id of the campaign.
    pub campaign: String,
    /// Digest of the campaign, of its procedures and of its requirements.
    pub campaign_sha256: String,
    /// Id of the rig.
    pub rig: String,
    /// Digest of the rig file.
    pub rig_sha256: String,
    /// The units.
    pub population: Population,
    /// Seed of the first unit's first run; every further run has the next one.
    pub seed: u64,
    /// Runs of each unit.
    pub seeds_per_unit: u32,
}

/// The units of a comparison.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Population {
    /// A family with its seed, or the word `files`.
    pub name: String,
    /// Digest of the family file, or of all unit files.
    pub sha256: String,
    /// Number of units in all shards.
    pub units: u32,
}

/// A part of the units: those whose number is `number` modulo `parts`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Shard {
    /// From 1.
    pub number: u32,
    /// How many there are; 1 for a comparison that is not divided.
    pub parts: u32,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Replicate {
    /// Number of the unit, from 1.
    pub unit: u32,
    /// Name of the unit.
    pub unit_id: String,
    /// Digest of its files.
    pub unit_sha256: String,
    /// Seed of the run.
    pub seed: u64,
    /// How the run ended.
    pub end: End,
    /// What was judged, in the order of the run's findings.
    pub values: Vec<ReplicateValue>,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum End {
    /// Every procedure was run to its end.
    Completed,
    /// A procedure tripped, failed or was not run.
    Aborted {
        /// Place of the first one in the campaign, from 0.
        procedure: usize,
        /// The first one and its reason.
        why: String,
    },
}

/// A finding that a requirement judges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReplicateValue {
    /// Id of the requirement.
    pub requirement: String,
    /// Measurand.
    pub measurand: String,
    /// Procedure, axis and point.
    pub place: String,
    /// Value in the SI unit of the measurand; `None` where the measurement is inconclusive.
    pub value: Option<f64>,
    /// Standard uncertainty, same unit.
    pub u: f64,
    /// Whether the requirement passes by this finding, with or without condition; true where it only reports.
    pub passes: bool,
}

impl Shard {
    /// A comparison that is not divided.
    pub const WHOLE: Self = Self { number: 1, parts: 1 };

    /// Whether a unit of this number, from 1, belongs to it.
    pub fn holds(self, unit: u32) -> bool {
        unit % self.parts == self.number % self.parts
    }
}
