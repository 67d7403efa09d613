//! The same bytes in give the same findings out: jobs, seeds, re-judging, changed samples and limits.

use std::path::Path;

use crate::bench::{findings, folder, run_in};

const SHORT: [&str; 4] = ["run", "quick/el-breakaway", "quick/az-breakaway", "--non-interactive"];

fn run(folder: &Path, out: &str, more: &[&str]) -> (String, Vec<u8>) {
    let arguments: Vec<&str> = SHORT.iter().chain(["--out", out].iter()).chain(more).copied().collect();
    let said = run_in(folder, &arguments);
    assert!(matches!(said.code, 0 | 1 | 3), "{}\n{}", said.out, said.err);
    let run = folder.join(out);
    let log = std::fs::read(run.join("AZ-BREAKAWAY.mcap")).expect("a log");
    (findings(&run), log)
}

#[test]
fn same_seed_gives_the_same_bytes_with_one_job_and_with_two() {
    let folder = folder();
    let one = run(folder.path(), "one", &["--jobs", "1"]);
    let two = run(folder.path(), "two", &["--jobs", "2"]);
    assert!(one.1 == two.1, "logs differ");
    assert_eq!(one.0, two.0);
    let other = run(folder.path(), "other", &["--seed", "2"]);
    assert!(one.1 != other.1, "another seed gives another log");
    assert_ne!(one.0, other.0);
}

#[test]
fn rejudging_gives_the_same_findings_and_a_changed_limit_changes_them() {
    let folder = folder();
    run(folder.path(), "run", &[]);
    let said = run_in(folder.path(), &["rejudge", "run"]);
    assert!(said.out.contains("the same, byte for byte"), "{}\n{}", said.out, said.err);
    let shipped = include_str!("../procedures/requirements.toml");
    let tighter = shipped.replacen("<= 260 N*m", "<= 150 N*m", 1);
    assert_ne!(shipped, tighter, "FRC-AZ has a limit of 260 N*m");
    std::fs::write(folder.path().join("tighter.toml"), tighter).expect("a writable folder");
    let said = run_in(folder.path(), &["rejudge", "run", "--requirements", "tighter.toml"]);
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    assert!(said.out.contains("findings differ"), "{}", said.out);
    let said = run_in(folder.path(), &["rejudge", "run/AZ-BREAKAWAY.mcap", "--out", "again"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    assert!(folder.path().join("again/report.html").is_file());
}

#[test]
fn rejudge_without_out_writes_nothing() {
    let folder = folder();
    run(folder.path(), "run", &[]);
    let list = || {
        let mut names: Vec<_> = std::fs::read_dir(folder.path().join("run"))
            .expect("a run folder")
            .map(|e| e.expect("readable").path())
            .collect();
        names.sort();
        names
    };
    let before = list();
    run_in(folder.path(), &["rejudge", "run"]);
    assert_eq!(before, list());
}
