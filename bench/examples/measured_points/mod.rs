//! The points of a run of this program, judged again from its log; shared by the examples that hold them against a model.

use std::path::Path;
use std::process::Command;

use procedures::diagnostic::SourceFile;
use procedures::log::LogReader;
use procedures::measurement::PointResult;
use procedures::procedure::Procedure;

/// Runs a procedure file on a simulated unit and judges its log; `example` and `axis` name the temporary folder, `id` is the
/// procedure's.
pub(crate) fn run(
    example: &str,
    unit: &str,
    axis: &str,
    (file, id): (&str, &str),
    seed: u64,
) -> Vec<PointResult> {
    let folder = std::env::temp_dir().join(format!("{example}-{}-{axis}-{seed}", std::process::id()));
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
