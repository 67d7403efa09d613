//! Runs that do not end by themselves: Ctrl-C in motion, a disk that fills up.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::bench::{folder, run_in};

/// Starts a long run, does something to it once its procedure has begun moving, gives the exit code and what was said on
/// stderr.
fn disturbed(run: &Path, disturb: impl FnOnce(u32)) -> (i32, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_bench"))
        .args(["run", "fat/az-cogging", "--json", "--out"])
        .arg(run)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program under test starts");
    let lines = BufReader::new(child.stdout.take().expect("piped")).lines();
    let mut lines = lines.map_while(Result::ok);
    // Polarity comes first; the procedure itself is planned for many minutes of motion.
    let begins = |line: &String| line.contains("procedure-started") && line.contains("AZ-COGGING");
    assert!(lines.any(|line| begins(&line)), "the run begins");
    disturb(child.id());
    lines.for_each(drop);
    let output = child.wait_with_output().expect("it ends");
    let code = output.status.code().expect("it ends by itself, not by the signal");
    (code, String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Sends these signals one after the other.
fn interrupted(run: &Path, signals: &[&str]) -> (i32, String) {
    disturbed(run, |process| {
        for signal in signals {
            let sleep = Command::new("sleep").arg("0.5").status();
            assert!(sleep.is_ok_and(|s| s.success()));
            let kill = Command::new("kill").args([*signal, &process.to_string()]).status();
            assert!(kill.is_ok_and(|s| s.success()), "the run was still going on");
        }
    })
}

/// What every stopped run leaves: standstill and the reason in a closed journal, a report, logs that judge again.
fn left_in_order(run: &Path) {
    let journal = std::fs::read_to_string(run.join("journal.jsonl")).expect("a journal");
    assert!(journal.contains("\"aborted\"") && journal.contains("stopped by a signal"), "{journal}");
    let safe = journal.lines().filter(|line| line.contains("\"point-ended\""));
    assert!(safe.clone().all(|line| line.contains("\"safe\":\"standstill: ")), "{journal}");
    assert!(safe.count() > 0, "{journal}");
    assert!(journal.trim_end().lines().last().expect("lines").contains("\"closed\""), "{journal}");
    assert!(run.join("report.html").is_file());
    let again = run_in(run.parent().expect("a parent"), &["rejudge", "run"]);
    assert!(again.out.contains("findings are the same, byte for byte"), "{}{}", again.out, again.err);
}

#[test]
fn each_signal_in_motion_leaves_the_rig_safe_the_log_readable_and_has_its_exit_code() {
    for (signals, code) in [(&["-INT"], 130), (&["-TERM"], 143), (&["-HUP"], 129)] {
        let folder = folder();
        let run = folder.path().join("run");
        assert_eq!(interrupted(&run, signals).0, code, "{signals:?}");
        left_in_order(&run);
    }
}

#[test]
fn ctrl_z_in_motion_is_held_off_and_says_why() {
    let folder = folder();
    let run = folder.path().join("run");
    let (code, said) = interrupted(&run, &["-TSTP", "-INT"]);
    assert_eq!(code, 130, "it went on until Ctrl-C");
    assert!(said.contains("Ctrl-Z is held off while the rig is armed"), "{said}");
    left_in_order(&run);
}

/// A file system of a gigabyte in memory at `at`, or `None` where this user may not mount one.
#[allow(clippy::print_stderr, reason = "who runs the tests is told what was left out")]
fn small_disk(at: &Path) -> Option<()> {
    std::fs::create_dir(at).ok()?;
    let mount =
        Command::new("mount").args(["-t", "tmpfs", "-o", "size=1g", "tmpfs"]).arg(at).output().ok()?;
    if !mount.status.success() {
        eprintln!("skipped: {}", String::from_utf8_lossy(&mount.stderr).trim());
        return None;
    }
    Some(())
}

/// Takes all the space that is left: after the gate has looked, somebody else wrote.
fn fill(disk: &Path) {
    let mut file = std::fs::File::create(disk.join("filler")).expect("a new file");
    while file.write_all(&[0; 1 << 20]).is_ok() {}
}

#[test]
fn a_disk_that_fills_up_stops_the_axis_keeps_the_journal_and_says_4() {
    let folder = folder();
    let disk = folder.path().join("disk");
    if small_disk(&disk).is_none() {
        return; // only root can mount; the same path through a full disk needs one
    }
    let (code, said) = disturbed(&disk.join("run"), |_| fill(&disk));
    let journal = std::fs::read_to_string(disk.join("run/journal.jsonl"));
    let unmounted = Command::new("umount").arg(&disk).status();
    assert!(unmounted.is_ok_and(|s| s.success()));
    assert_eq!(code, 4, "{said}");
    let journal = journal.expect("a journal");
    assert!(journal.contains("\"errored\"") && journal.contains("standstill: "), "{journal}");
    assert!(journal.contains("No space left on device"), "{journal}");
    assert!(journal.contains("free space"), "says what to do: {journal}");
}

#[test]
fn a_run_whose_log_does_not_fit_is_refused_before_anything_moves() {
    let folder = folder();
    let disk = folder.path().join("disk");
    if small_disk(&disk).is_none() {
        return;
    }
    fill(&disk);
    // A little space again, for the run folder itself.
    let filler = std::fs::OpenOptions::new().write(true).open(disk.join("filler"));
    filler.and_then(|file| file.set_len((1 << 30) - (8 << 20))).expect("the filler");
    let said = run_in(&disk, &["run", "quick/az-friction", "--out", "run", "--non-interactive"]);
    let unmounted = Command::new("umount").arg(&disk).status();
    assert!(unmounted.is_ok_and(|s| s.success()));
    assert_eq!(said.code, 6, "{}{}", said.out, said.err);
    assert!(said.err.contains("gate `free-disk`: expected at least"), "{}", said.err);
}
