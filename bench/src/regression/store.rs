//! The files of a regression: `baseline.json`, `candidate.json` and `criteria.json` hold what was measured and asked,
//! `regression.json`, `regression.md` and `junit.xml` what it comes to.

use std::path::{Path, PathBuf};

use procedures::regression::{ARM_SCHEMA, ArmRecord, Criteria, Shard};
use reports::regression::{self, Regression};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::Records;
use crate::record::bounded;
use crate::record::durable::{self, OUTPUT_HELP};

/// The baseline's record.
pub const BASELINE: &str = "baseline.json";
/// The candidate's record.
pub const CANDIDATE: &str = "candidate.json";
/// The criteria as they were read.
pub const CRITERIA: &str = "criteria.json";

/// Most bytes of an arm file: ten thousand units with a hundred findings each.
const MOST_BYTES: u64 = 1 << 30;

/// Writes what was measured, and the criteria.
///
/// # Errors
/// As text with the file's name.
pub fn write_records(folder: &Path, records: &Records, criteria: &Criteria) -> Result<(), String> {
    write(folder, BASELINE, &json(&records.baseline))?;
    write(folder, CANDIDATE, &json(&records.candidate))?;
    write(folder, CRITERIA, &json(criteria))
}

/// Writes what a comparison comes to.
///
/// # Errors
/// As text with the file's name.
pub fn write_decision(folder: &Path, found: &Regression) -> Result<(), String> {
    write(folder, "regression.json", &regression::json(found))?;
    write(folder, "regression.md", &regression::markdown(found))?;
    write(folder, "junit.xml", &regression::junit(found))
}

/// Reads a whole arm.
///
/// # Errors
/// As text: no such file, another schema, or a shard.
pub fn read_arm(path: &Path) -> Result<ArmRecord, String> {
    let record = read_any_arm(path)?;
    if record.shard != Shard::WHOLE {
        let Shard { number, parts } = record.shard;
        return Err(format!(
            "{}: holds shard {number} of {parts} only; merge all shards first: `bench merge FOLDER… --out DIR`",
            path.display()
        ));
    }
    Ok(record)
}

/// Reads an arm or a shard of one.
///
/// # Errors
/// As text: no such file, or another schema.
pub fn read_any_arm(path: &Path) -> Result<ArmRecord, String> {
    let value: serde_json::Value = read(path)?;
    let found = value.get("schema").and_then(serde_json::Value::as_str).unwrap_or("none").to_owned();
    if found != ARM_SCHEMA {
        return Err(format!(
            "{}: schema `{found}`, expected `{ARM_SCHEMA}`; run the arm again with this program",
            path.display()
        ));
    }
    let record: ArmRecord = serde_json::from_value(value)
        .map_err(|error| format!("{}: not a record of an arm: {error}", path.display()))?;
    let Shard { number, parts } = record.shard;
    if number == 0 || number > parts || parts > record.scenario.population.units.max(1) {
        return Err(format!("{}: shard {number} of {parts} does not exist", path.display()));
    }
    Ok(record)
}

/// Reads the criteria of a folder.
///
/// # Errors
/// As text with the file's name.
pub fn read_criteria(folder: &Path) -> Result<Criteria, String> {
    read(&folder.join(CRITERIA))
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<T, String> {
    let text = bounded::read_to_string(path, MOST_BYTES)
        .map_err(|error| format!("{}: cannot be read: {error}", path.display()))?;
    serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
}

fn json(value: &impl Serialize) -> String {
    let mut text =
        serde_json::to_string_pretty(value).expect("the structures have string keys and finite numbers");
    text.push('\n');
    text
}

fn write(folder: &Path, name: &str, text: &str) -> Result<(), String> {
    let path: PathBuf = folder.join(name);
    durable::write(&path, text.as_bytes())
        .map_err(|error| format!("{}: {error}; {OUTPUT_HELP}", path.display()))
}
