//! Runs the program and looks at what it says.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What a call came to.
pub(crate) struct Said {
    /// Exit code.
    pub(crate) code: i32,
    /// Result.
    pub(crate) out: String,
    /// Notes and errors.
    pub(crate) err: String,
}

/// Runs the program in `folder` with these arguments.
pub(crate) fn run_in(folder: &Path, arguments: &[&str]) -> Said {
    let output = Command::new(env!("CARGO_BIN_EXE_bench"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .expect("the program under test starts");
    Said {
        code: output.status.code().unwrap_or(-1),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// A folder of its own for one test.
pub(crate) fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Writes a file below a folder, with its parents.
pub(crate) fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().expect("a file has a parent")).expect("a writable folder");
    std::fs::write(&path, text).expect("a writable folder");
    path
}

/// Everything that a log holds but the record that says on which day it was made: topic, time and bytes of each message, then
/// the attachments.
pub(crate) fn content(log: &Path) -> Vec<(String, u64, Vec<u8>)> {
    let bytes = std::fs::read(log).expect("a log");
    let messages = mcap::MessageStream::new(&bytes).expect("an MCAP file").map(|message| {
        let message = message.expect("a message");
        (message.channel.topic.clone(), message.log_time, message.data.into_owned())
    });
    let reader = procedures::log::LogReader::open(log).expect("a log of ours");
    let attachments = reader.attachments().iter().map(|a| (a.name.clone(), 0, a.text.clone().into_bytes()));
    messages.chain(attachments).collect()
}

/// A committed fixture.
pub(crate) fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data").join(name)
}

/// Imports `d.csv` as the measured friction of a motor.
pub(crate) const IMPORT_MAP: &str = r#"schema = 1
procedure = "p.toml"
time = "column"
time-column = "t"
[[channel]]
channel = "position_rad"
column = "angle"
unit = "deg"
[[channel]]
channel = "current_a"
column = "i"
unit = "A"
[[segment]]
file = "d.csv"
point = "map"
branch = "forward"
"#;

/// Imports this table by this map.
pub(crate) fn import_csv(folder: &Path, map: &str, csv: &str) -> Said {
    write(folder, "map.toml", map);
    write(folder, "d.csv", csv);
    let procedure = std::fs::read_to_string(fixture("odrive_cogging/cogging.toml")).expect("a fixture");
    write(folder, "p.toml", &procedure);
    run_in(folder, &["import", "map.toml", "--out", "log"])
}

/// The findings in the `results.json` of a run folder.
fn found(run: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(run.join("results.json")).expect("a run folder with results");
    let mut value: serde_json::Value = serde_json::from_str(&text).expect("results are JSON");
    value["findings"].take()
}

/// The findings in the `results.json` of a run folder, as text.
pub(crate) fn findings(run: &Path) -> String {
    serde_json::to_string_pretty(&found(run)).expect("a value prints")
}

/// What a procedure of a run found: its entry in the findings.
pub(crate) fn procedure(run: &Path, id: &str) -> serde_json::Value {
    let procedures = found(run)["procedures"].as_array().expect("a list of procedures").clone();
    procedures.into_iter().find(|p| p["id"] == id).expect("it was planned")
}

/// What all procedures of a run measured.
pub(crate) fn measurements(run: &Path) -> Vec<serde_json::Value> {
    let procedures = found(run)["procedures"].as_array().expect("a list of procedures").clone();
    procedures.iter().flat_map(|p| p["measurements"].as_array().cloned().unwrap_or_default()).collect()
}

/// What became of each requirement in a run.
pub(crate) fn outcomes(run: &Path) -> Vec<serde_json::Value> {
    found(run)["outcomes"].as_array().expect("a list of outcomes").clone()
}

/// The verdict of a requirement in the results of a run folder, on what was measured: coverage has tests of its own.
pub(crate) fn verdict(run: &Path, requirement: &str) -> String {
    let outcomes = outcomes(run);
    let found = outcomes.iter().find(|o| o["requirement"] == requirement);
    found.map_or("missing".to_owned(), |o| o["before_coverage"].as_str().unwrap_or("?").to_owned())
}
