//! The points of a run of the program, judged again from its log.

use std::path::Path;
use std::process::Command;

use procedures::diagnostic::SourceFile;
use procedures::log::LogReader;
use procedures::measurement::PointResult;
use procedures::procedure::Procedure;

/// Runs a procedure file on a simulated unit and judges its log; `study` and `axis` name the temporary folder, `id` is the
/// procedure's.
///
/// # Panics
/// When the procedure does not run, or leaves no log that can be read.
pub fn run(study: &str, unit: &str, axis: &str, file: &str, id: &str, seed: u64) -> Vec<PointResult> {
    let folder = std::env::temp_dir().join(format!("{study}-{}-{axis}-{seed}", std::process::id()));
    let status = Command::new("cargo")
        .args(["run", "--quiet", "--release", "--", "run", file, "--non-interactive", "--unit", unit])
        .args(["--seed", &seed.to_string(), "--out"])
        .arg(&folder)
        .status();
    assert!(status.is_ok_and(|s| matches!(s.code(), Some(0 | 1 | 3))), "the procedure runs");
    let points = judge(&folder.join(format!("{id}.mcap")));
    let _ = std::fs::remove_dir_all(&folder);
    points
}

fn judge(log: &Path) -> Vec<PointResult> {
    let mut reader = LogReader::open(log).expect("a log of this program");
    let plan = reader.plan().clone();
    let attached = reader.attachments().iter().find(|a| a.name == "procedure.toml").expect("it is attached");
    let source = SourceFile { name: attached.name.clone(), text: attached.text.clone() };
    let procedure = Procedure::parse(source).expect("it was parsed before");
    let mut points = Vec::new();
    while let Some(window) = reader.next_window() {
        points.push(procedure.analyse(&plan.cases[window.point], &window, &plan.axes, plan.loop_rate_hz));
    }
    points
}
