//! One run of the program that gets signals in motion, and what must be true of it afterwards.

use std::io::{PipeReader, PipeWriter, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};

use bench::clock::{self, Stopwatch};
use bench::people::signals::{Does, SIGNALS};
use bench::record::journal::{self, Entry, Line};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use procedures::log::LogReader;

/// After the signal that ends it, a run may take this long: standstill, log, judge, report; on a busy machine.
const END_S: f64 = 40.0;
/// A point that was begun at the same instant as a signal came is in the journal after this.
const SETTLED_S: f64 = 0.4;
/// What a pipe of Linux holds.
const PIPE_BYTES: usize = 1 << 16;

/// What is done to a run.
#[derive(Clone, Debug)]
pub struct Attack {
    /// Sent in this order; SIGTERM follows where none of them ends the run.
    pub signals: Vec<Signal>,
    /// From when the program listens to the first signal, s.
    pub after_s: f64,
    /// Nobody reads stdout, stderr: both are pipes that are full from the beginning.
    pub stalled: [bool; 2],
    /// Whether events are asked for on stdout.
    pub json: bool,
}

/// What became of it.
#[derive(Debug, Default)]
pub struct Outcome {
    /// Exit code; `None` where the run had to be killed.
    pub code: Option<i32>,
    /// From the signal that ended it to the end of the process, s.
    pub took_s: f64,
    /// Points that began before the signal that ended it.
    pub points: usize,
    /// What must not be.
    pub breaches: Vec<String>,
}

/// A stream that nobody reads: its reader is alive and its pipe is full.
fn stalled() -> (PipeReader, PipeWriter) {
    let (reader, mut writer) = std::io::pipe().expect("a pipe");
    writer.write_all(&[b'x'; PIPE_BYTES]).expect("it fits");
    (reader, writer)
}

/// Carries an attack out on a long run of this program.
pub fn carry_out(program: &Path, run: &Path, attack: &Attack) -> Outcome {
    let mut command = Command::new(program);
    command.args(["run", "fat/az-cogging", "fat/el-cogging", "--jobs", "2", "--non-interactive", "--out"]);
    command.arg(run).args(attack.json.then_some("--json")).stdin(Stdio::null());
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut readers = Vec::new();
    if attack.stalled[0] {
        let (reader, writer) = stalled();
        readers.push(reader);
        command.stdout(writer);
    }
    if attack.stalled[1] {
        let (reader, writer) = stalled();
        readers.push(reader);
        command.stderr(writer);
    }
    let mut child = command.spawn().expect("the program starts");
    let mut outcome = Outcome::default();
    if !listens(&child) {
        outcome.breaches.push("it never blocked its signals".to_owned());
    }
    rest(attack.after_s);
    let expected = disturb(&mut child, run, &attack.signals, &mut outcome);
    let ended = ends(&mut child, &mut outcome);
    drop(readers);
    outcome.code = ended.and_then(|status| status.code());
    if outcome.code != Some(i32::from(expected)) {
        outcome.breaches.push(format!("ended with {ended:?} instead of {expected}"));
    }
    look(run, expected, &mut outcome);
    outcome
}

/// Sends the signals; gives the exit code that they order. A signal that orders nothing must leave the run as it is.
fn disturb(child: &mut Child, run: &Path, signals: &[Signal], outcome: &mut Outcome) -> u8 {
    let id = Pid::from_raw(i32::try_from(child.id()).expect("a process id"));
    let mut ordered = None;
    for &signal in signals.iter().chain([&Signal::SIGTERM]) {
        if ordered.is_some() && signal == Signal::SIGTERM {
            break;
        }
        let before = started(run);
        let sent = kill(id, signal);
        let does = SIGNALS.iter().find(|row| row.signal == signal).map(|row| row.does);
        rest(SETTLED_S);
        match does {
            Some(Does::Stops(code) | Does::StopsAtOnce(code)) if ordered.is_none() => {
                ordered = Some((code, started(run)));
            }
            _ if ordered.is_some() => {}
            _ if sent.is_err() || state(child) == 'T' => {
                outcome.breaches.push(format!("{signal} ended or stopped it after {before} points"));
            }
            _ => {}
        }
    }
    let (code, points) = ordered.expect("SIGTERM is the last");
    outcome.points = points;
    code
}

/// Waits for the end of the process, as long as it may take.
fn ends(child: &mut Child, outcome: &mut Outcome) -> Option<ExitStatus> {
    let watch = Stopwatch::start();
    loop {
        if let Ok(Some(status)) = child.try_wait() {
            outcome.took_s = watch.elapsed_s() + SETTLED_S;
            return Some(status);
        }
        if watch.elapsed_s() > END_S {
            outcome.breaches.push(format!("it did not end within {END_S} s"));
            let _ = child.kill().and_then(|()| child.wait());
            return None;
        }
        rest(0.01);
    }
}

/// What the run left: a closed chain, an end at standstill for every point that began, logs that are whole.
fn look(run: &Path, code: u8, outcome: &mut Outcome) {
    if !run.join(journal::FILE).exists() {
        return; // the signal came before anything could move
    }
    let mut breach = |what: String| outcome.breaches.push(what);
    match journal::read(run) {
        Err(error) => breach(error),
        Ok((lines, closed)) => {
            if !closed {
                breach("the journal is not closed".to_owned());
            }
            let says =
                |line: &Line| matches!(line.entry, Entry::Closed { exit_code, .. } if exit_code == code);
            if !lines.last().is_some_and(says) {
                breach(format!("the journal does not end with exit code {code}"));
            }
            let of = |wanted: fn(&Entry) -> bool| lines.iter().filter(|line| wanted(&line.entry)).count();
            let begun = of(|entry| matches!(entry, Entry::PointStarted { .. }));
            let safe =
                of(|e| matches!(e, Entry::PointEnded { safe, .. } if safe.starts_with("standstill: ")));
            if begun != safe {
                breach(format!("{begun} points began, {safe} ended at standstill"));
            }
            if begun > outcome.points {
                breach(format!("{begun} points began, {} before the signal", outcome.points));
            }
            let in_logs = windows(run, &mut breach);
            if begun != in_logs {
                breach(format!(
                    "{begun} points in the journal, {in_logs} in the logs with their final state"
                ));
            }
        }
    }
}

/// Points in the logs of a run that end with the final state of both axes.
fn windows(run: &Path, breach: &mut dyn FnMut(String)) -> usize {
    let inside = std::fs::read_dir(run).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut count = 0;
    for log in inside.filter(|path| path.extension().is_some_and(|e| e == "mcap")) {
        match LogReader::open(&log) {
            Err(error) => breach(error.to_string()),
            Ok(mut reader) => {
                while let Some(window) = reader.next_window() {
                    count += usize::from(window.left.len() == 2);
                }
                if let Some(damage) = reader.damage() {
                    breach(damage.to_string());
                }
            }
        }
    }
    count
}

/// Points that the journal says have begun.
fn started(run: &Path) -> usize {
    let text = std::fs::read_to_string(run.join(journal::FILE)).unwrap_or_default();
    text.matches("\"point-started\"").count()
}

/// Waits until the program blocks SIGTERM in its first thread.
fn listens(child: &Child) -> bool {
    let watch = Stopwatch::start();
    while watch.elapsed_s() < END_S {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigBlk:"));
        let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
        if mask & (1 << (Signal::SIGTERM as u64 - 1)) != 0 {
            return true;
        }
        rest(0.01);
    }
    false
}

/// The state letter of a process: `T` is stopped.
fn state(child: &Child) -> char {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap_or_default();
    stat.rsplit_once(") ").and_then(|(_, rest)| rest.chars().next()).unwrap_or('?')
}

fn rest(seconds: f64) {
    let watch = Stopwatch::start();
    while watch.elapsed_s() < seconds {
        clock::nap();
    }
}
