//! Runs that do not end by themselves: signals in motion, readers that stall, a disk that fills up.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};

use nix::sys::signal::Signal;
use validation::signals::{Attack, carry_out};

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
    assert!(again.out.contains("findings are identical byte for byte"), "{}{}", again.out, again.err);
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
    assert!(said.contains("Ctrl-Z is ignored during a run"), "{said}");
    left_in_order(&run);
}

/// Signals to a run some seconds after it began; nothing that must not be is found.
fn attacked(signals: &[Signal], stalled: [bool; 2], json: bool) {
    let folder = folder();
    let attack = Attack { signals: signals.to_vec(), after_s: 1.0, stalled, json };
    let outcome = carry_out(Path::new(env!("CARGO_BIN_EXE_bench")), &folder.path().join("run"), &attack);
    assert!(outcome.breaches.is_empty(), "{attack:?}: {outcome:?}");
}

#[test]
fn a_reader_of_stderr_that_stalls_delays_no_stop_after_ctrl_z() {
    attacked(&[Signal::SIGTSTP, Signal::SIGTERM, Signal::SIGINT, Signal::SIGINT], [false, true], false);
}

#[test]
fn readers_of_both_streams_that_stall_delay_neither_the_stop_nor_the_end() {
    attacked(&[Signal::SIGQUIT], [true, true], true);
}

#[test]
fn no_signal_kills_or_suspends_a_run_whose_axes_may_move() {
    use Signal::{
        SIGALRM, SIGPIPE, SIGPROF, SIGTTIN, SIGTTOU, SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU, SIGXFSZ,
    };
    attacked(
        &[SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF, SIGTTOU, SIGTTIN, SIGPIPE, SIGXFSZ, SIGXCPU],
        [false, false],
        false,
    );
}

#[test]
fn a_run_that_goes_on_is_not_inspected_and_its_journal_stays_whole() {
    let folder = folder();
    let run = folder.path().join("run");
    let (code, _) = disturbed(&run, |process| {
        let look = ["inspect", "run", "--operator", "Ada", "--found", "it moves"];
        let said = run_in(folder.path(), &look);
        assert_eq!(said.code, 6, "{}{}", said.out, said.err);
        assert!(said.err.contains("the run is still in progress"), "{}", said.err);
        let kill = Command::new("kill").args(["-INT", &process.to_string()]).status();
        assert!(kill.is_ok_and(|s| s.success()), "the run was still going on");
    });
    assert_eq!(code, 130);
    left_in_order(&run);
}

/// The program with its stdout at a device that takes nothing.
fn into_dev_full(arguments: &[&str]) -> (Option<i32>, String) {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has one");
    let output = Command::new(env!("CARGO_BIN_EXE_bench")).args(arguments).stdout(full).output();
    let output = output.expect("the program under test starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_result_that_cannot_be_printed_is_a_failure_and_not_a_success() {
    for arguments in [&["list", "kinds"][..], &["schema", "rig"], &["--help"]] {
        let (code, said) = into_dev_full(arguments);
        assert_eq!(code, Some(4), "{arguments:?}: {said}");
        assert!(said.contains("standard output: No space left on device"), "{arguments:?}: {said}");
    }
}

#[test]
fn no_control_character_of_a_name_reaches_the_terminal() {
    let folder = folder();
    for arguments in [&["check", "\u{1b}[2J\u{9b}31m"][..], &["\u{1b}[2J"], &["explain", "\u{1b}]0;x\u{7}"]] {
        let said = run_in(folder.path(), arguments);
        assert_eq!(said.code, 2, "{arguments:?}: {}{}", said.out, said.err);
        let steers = |c: char| c.is_control() && c != '\n' && c != '\t';
        assert!(!said.err.contains(steers) && !said.out.contains(steers), "{arguments:?}: {:?}", said.err);
    }
}

#[test]
fn a_run_folder_that_is_not_utf_8_is_refused_by_name_and_panics_nobody() {
    let folder = folder();
    let output = Command::new(env!("CARGO_BIN_EXE_bench"))
        .args(["run", "quick/az-friction", "--non-interactive", "--out"])
        .arg(OsStr::from_bytes(b"run-\xff"))
        .current_dir(folder.path())
        .output()
        .expect("the program under test starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("the path is not UTF-8"), "{said}");
}

/// This program as a user who may have this many processes; `None` where that cannot be arranged.
#[allow(clippy::print_stderr, reason = "who runs the tests is told what was left out")]
fn with_processes(limit: u32, folder: &Path) -> Option<(Option<i32>, String)> {
    // A number that nobody else has, so that nobody else's processes count.
    let user = format!("--reuid={}", 1_000_000 + std::process::id());
    let mut command = Command::new("setpriv");
    command.args([&user, "--clear-groups", "prlimit", &format!("--nproc={limit}"), "./bench"]);
    command.args(["run", "quick/az-friction", "--non-interactive", "--out", &limit.to_string()]);
    // Whoever asks for a single thread needs fewer processes.
    command.env_remove("RAYON_NUM_THREADS");
    let output = command.current_dir(folder).output().ok()?;
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if said.contains("setpriv:") {
        eprintln!("skipped: {}", said.trim());
        return None;
    }
    Some((output.status.code(), said))
}

#[test]
fn where_no_threads_can_be_had_no_run_begins_and_nothing_panics() {
    let folder = folder();
    let open = std::fs::Permissions::from_mode(0o777);
    std::fs::set_permissions(folder.path(), open).expect("its own folder");
    // Not everybody may look into the folder in which the program was built.
    std::fs::copy(env!("CARGO_BIN_EXE_bench"), folder.path().join("bench")).expect("writable");
    for limit in 1..=6 {
        let Some((code, said)) = with_processes(limit, folder.path()) else { return };
        assert_eq!(code, Some(4), "{limit} processes: {said}");
        assert!(said.contains("ulimit -u") && !said.contains("panicked"), "{limit} processes: {said}");
        let log = folder.path().join(limit.to_string()).join("POLARITY.mcap");
        assert!(!log.exists(), "{limit} processes: nothing has moved");
    }
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
