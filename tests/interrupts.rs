//! Runs that do not end by themselves: Ctrl-C in motion, a disk that fills up.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::bench::folder;

/// Starts a long run, sends `signal` once a point has begun moving, gives the exit code.
fn interrupted(run: &std::path::Path, signal: &str) -> i32 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_bench"))
        .args(["run", "fat/az-cogging", "--json", "--out"])
        .arg(run)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program under test starts");
    let lines = BufReader::new(child.stdout.take().expect("piped")).lines();
    let mut lines = lines.map_while(Result::ok);
    assert!(lines.any(|line| line.contains("procedure-started")), "the run begins");
    // The procedure is planned for many minutes of motion: half a second later the axis is on its way.
    let sleep = Command::new("sleep").arg("0.5").status();
    assert!(sleep.is_ok_and(|s| s.success()));
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(kill.is_ok_and(|s| s.success()), "the run was still going on");
    lines.for_each(drop);
    child.wait().expect("it ends").code().expect("it ends by itself, not by the signal")
}

#[test]
fn ctrl_c_in_motion_leaves_the_rig_safe_the_journal_whole_and_says_130() {
    let folder = folder();
    let run = folder.path().join("run");
    assert_eq!(interrupted(&run, "-INT"), 130);
    let journal = std::fs::read_to_string(run.join("journal.jsonl")).expect("a journal");
    assert!(journal.contains("\"aborted\"") && journal.contains("stopped by a signal"), "{journal}");
    assert!(journal.contains("\"safe\":\"standstill: "), "{journal}");
    assert!(journal.trim_end().lines().last().expect("lines").contains("\"closed\""), "{journal}");
    assert!(run.join("report.html").is_file());
}

#[test]
fn sigterm_in_motion_says_143() {
    let folder = folder();
    assert_eq!(interrupted(&folder.path().join("run"), "-TERM"), 143);
}

/// A tiny file system at `at`, or `None` where this user may not mount one.
fn tiny_disk(at: &std::path::Path) -> Option<()> {
    std::fs::create_dir(at).ok()?;
    let mount =
        Command::new("mount").args(["-t", "tmpfs", "-o", "size=6m", "tmpfs"]).arg(at).output().ok()?;
    mount.status.success().then_some(())
}

#[test]
fn a_disk_that_fills_up_stops_the_axis_keeps_the_journal_and_says_4() {
    let folder = folder();
    let disk = folder.path().join("disk");
    if tiny_disk(&disk).is_none() {
        return; // only root can mount; the same path through a full disk needs one
    }
    let said =
        crate::bench::run_in(&disk, &["run", "quick/az-friction", "--out", "run", "--non-interactive"]);
    let journal = std::fs::read_to_string(disk.join("run/journal.jsonl"));
    let unmounted = Command::new("umount").arg(&disk).status();
    assert!(unmounted.is_ok_and(|s| s.success()));
    assert_eq!(said.code, 4, "{}\n{}", said.out, said.err);
    assert!(said.err.contains("No space left on device"), "{}", said.err);
    assert!(said.err.contains("free space"), "says what to do: {}", said.err);
    let journal = journal.expect("a journal");
    assert!(journal.contains("\"errored\"") && journal.contains("standstill: "), "{journal}");
}
