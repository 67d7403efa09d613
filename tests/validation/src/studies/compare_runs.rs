//! What two runs of one campaign measured, row for row: for a change that must leave every number as it is.
//!
//! `cargo run --release -p validation -- compare_runs BEFORE AFTER`, two run folders. Compares the rows of every log
//! (bytes and log times, per topic), the events, and the findings; hashes and attachments are left out, as the files that
//! they speak of may change by design. Prints one line a difference; ends with 1 where there is one. `tests/compare` builds
//! two commits, runs both and calls this.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

mod findings;
mod rows;

pub(crate) fn study() -> ExitCode {
    let folders: Vec<PathBuf> = crate::arguments().map(PathBuf::from).collect();
    let [before, after] = folders.as_slice() else {
        println!("usage: compare_runs BEFORE AFTER (two run folders)");
        return ExitCode::from(2);
    };
    match compare(before, after) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(reason) => {
            println!("{reason}");
            ExitCode::from(2)
        }
    }
}

/// The number of differences.
fn compare(before: &Path, after: &Path) -> Result<usize, String> {
    let mut names = logs(before)?;
    names.extend(logs(after)?);
    let mut count = 0;
    let mut rows_compared = 0;
    for name in &names {
        let compared = rows::compare(&before.join(name), &after.join(name))?;
        rows_compared += compared.rows;
        count += compared.differences.len();
        compared.differences.iter().for_each(|line| println!("{name}: {line}"));
    }
    let differences = findings::compare(&before.join("results.json"), &after.join("results.json"))?;
    count += differences.len();
    differences.iter().for_each(|line| println!("findings: {line}"));
    println!("{} logs, {rows_compared} rows and the findings compared: {count} differences", names.len());
    Ok(count)
}

/// Names of the logs in a run folder.
fn logs(folder: &Path) -> Result<BTreeSet<String>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    Ok(names.filter(|name| name.ends_with(".mcap")).collect())
}
