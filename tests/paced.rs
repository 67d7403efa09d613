//! Rehearsals at the speed of the day: one session, opened once, ticked from arming to teardown.
//!
//! These tests take real time and want the machine for themselves: a tick that comes late by more than 5 ms trips, as it
//! must. CONTRIBUTING.md has the command.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use bench::campaign::{self, ProcedureRun, RunResult, Setup};
use bench::clock::rest;
use bench::people::Answers;
use bench::record::journal::{self, Entry};
use bench::rig::wires::Wires;
use bench::site::PacedSite;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use procedures::log::{LogReader, Window};
use reports::record::Status;
use sim_devices::rig::{Fault, SimulatedRig};
use validation::intercepted::{Intercepted, Interceptor};

use crate::bench::{findings, folder, run_in};
use crate::campaigns::{Silent, nominal, with_setup};

const PERIOD_S: f64 = 1e-3;

/// Runs `smoke` on the paced rig over these wires, every prompt answered with yes.
fn rehearsed(folder: &Path, wires: fn(&SimulatedRig) -> Wires) -> RunResult {
    let unit = nominal();
    let site = PacedSite::new(&unit, &[]).with_wires(wires);
    let answers = Answers { yes: true, ..Answers::default() };
    with_setup("paced", &["smoke"], folder, (&unit, &site), |setup| {
        campaign::run(&Setup { answers, ..setup }, &mut Silent).expect("a writable folder")
    })
}

fn of<'a>(result: &'a RunResult, id: &str) -> &'a ProcedureRun {
    let index = result.page.procedures.iter().position(|p| p.id == id).expect("planned");
    &result.runs[index]
}

fn entries(folder: &Path) -> Vec<Entry> {
    let (lines, _) = journal::read(folder).expect("an intact chain");
    lines.into_iter().map(|line| line.entry).collect()
}

fn windows(log: &Path) -> Vec<Window> {
    let mut reader = LogReader::open(log).expect("a readable log");
    std::iter::from_fn(|| reader.next_window()).collect()
}

/// A row of the loop: when, after how many missed periods, and how far apart rows of its log are.
struct Tick {
    at_s: f64,
    missed: f64,
    spacing_s: f64,
}

/// The tick record of a whole run, all logs together in order of time.
fn tick_record(folder: &Path) -> Vec<Tick> {
    let logs = std::fs::read_dir(folder).expect("a run folder").flatten().map(|entry| entry.path());
    let mut all = Vec::new();
    for log in logs.filter(|path| path.extension().is_some_and(|e| e == "mcap")) {
        let spacing_s = 1.0 / LogReader::open(&log).expect("a readable log").plan().log_rate_hz;
        for window in windows(&log) {
            let rows = window.rows("/bench").expect("the loop's own rows");
            let missed = rows.column("missed_periods").expect("a channel of the loop");
            let own = rows.time_s.iter().zip(missed);
            all.extend(own.map(|(at_s, missed)| Tick { at_s: *at_s, missed: *missed, spacing_s }));
        }
    }
    all.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    all
}

/// Gaps in the tick record that no recorded miss explains, as time and length.
fn unexplained_gaps(ticks: &[Tick]) -> Vec<(f64, f64)> {
    /// A gap of so many periods beyond the spacing of rows must be on record.
    const TOLERATED: f64 = 10.0;
    /// Rows of the loop are as seldom as those of devices where a log is thinned.
    const ROWS: f64 = 10.0;
    let gap = |pair: &[Tick]| {
        let spacing_s = pair[0].spacing_s.max(pair[1].spacing_s);
        let explained_s = ROWS * spacing_s + (TOLERATED + pair[1].missed) * PERIOD_S;
        let gap_s = pair[1].at_s - pair[0].at_s;
        (gap_s > explained_s).then_some((pair[0].at_s, gap_s))
    };
    ticks.windows(2).filter_map(gap).collect()
}

/// Cool-down before the mirror is moved, and frames that are lost while azimuth moves.
fn a_hot_drive_and_lost_frames(rig: &SimulatedRig) -> Wires {
    rig.schedule(Duration::from_secs(66), Fault::FramesLost { count: 4 });
    rig.schedule(Duration::from_secs(67), Fault::HeatSink { drive: 0, degc: 60.2 });
    Wires::simulated(rig)
}

#[test]
#[ignore = "a minute and a half of real time"]
#[allow(clippy::print_stdout, reason = "how many periods were missed tells how quiet the machine was")]
fn smoke_opens_every_device_once_survives_a_trip_and_records_every_gap() {
    let folder = folder();
    let result = rehearsed(folder.path(), a_hot_drive_and_lost_frames);
    let status = |id: &str| of(&result, id).status;
    let ended = ["POLARITY", "SMOKE-LOOK", "SMOKE-STEP", "SMOKE-MIRROR"].map(|id| (id, status(id)));
    let reason = of(&result, "SMOKE-STEP").reason.clone().unwrap_or_default();
    let expected = [Status::Completed, Status::Completed, Status::Aborted, Status::Completed];
    assert_eq!(ended.map(|(_, status)| status), expected, "{ended:?} {reason}");
    assert!(reason.contains("tripped: ") && reason.contains("bus"), "{reason}");
    let entries = entries(folder.path());
    let opened: Vec<&Vec<String>> = entries
        .iter()
        .filter_map(|e| match e {
            Entry::SessionOpened { devices, .. } => Some(devices),
            _ => None,
        })
        .collect();
    assert_eq!(opened.len(), 1, "one session");
    for device in ["az-drive", "el-drive", "imu", "fsm", "analyser", "scope"] {
        let named = opened[0].iter().filter(|line| line.starts_with(&format!("{device}: "))).count();
        assert_eq!(named, 1, "{device} in {:?}", opened[0]);
    }
    let asked: Vec<&str> = entries
        .iter()
        .filter_map(|e| match e {
            Entry::Answered { prompt, .. } => Some(prompt.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!(asked, ["axes-at-pose", "axes-free", "looked-at"]);
    let mirror = windows(&folder.path().join("SMOKE-MIRROR.mcap")).swap_remove(0);
    let waited_s = mirror.segments[0].start_s - mirror.rows("/az").expect("azimuth").time_s[0];
    assert!(waited_s > 2.0, "the gate `heat-sink` kept it for {waited_s} s");
    let ticks = tick_record(folder.path());
    assert_eq!(unexplained_gaps(&ticks), []);
    let missed: f64 = ticks.iter().map(|tick| tick.missed).sum();
    println!("{missed} of {:.0} periods missed", ticks.last().expect("ticks").at_s / PERIOD_S);
}

/// Lets one exchange of a bus take half a second, while azimuth is on its way.
struct Stalling {
    exchanges: u64,
}

/// In the way of azimuth to where the step begins.
const STALLS_AT: u64 = 61_500;

impl Interceptor for Stalling {
    fn before_exchange(&mut self, now: Duration) -> Duration {
        self.exchanges += 1;
        if self.exchanges == STALLS_AT {
            rest(Duration::from_millis(500));
        }
        now
    }
}

fn stalling(rig: &SimulatedRig) -> Wires {
    let Wires { bus, ports } = Wires::simulated(rig);
    Wires { bus: Intercepted::boxed(bus, Stalling { exchanges: 0 }), ports }
}

#[test]
#[ignore = "a minute and a half of real time"]
fn a_tick_that_stalls_for_half_a_second_in_motion_is_stopped_by_the_drives_and_meets_no_end_stop() {
    let folder = folder();
    let result = rehearsed(folder.path(), stalling);
    assert_eq!(result.must_look, Vec::<String>::new(), "no end stop is met, every axis stands");
    let step = of(&result, "SMOKE-STEP");
    let mirror = of(&result, "SMOKE-MIRROR");
    let reason = step.reason.clone().unwrap_or_default();
    assert_eq!(step.status, Status::Aborted, "{reason}");
    assert!(reason.contains("missed cycles") || reason.contains("drive state"), "{reason}");
    assert_eq!(mirror.status, Status::Completed, "{:?}", mirror.reason);
    let logs = ["POLARITY", "SMOKE-LOOK", "SMOKE-STEP", "SMOKE-MIRROR", "session"];
    let all: Vec<Window> =
        logs.iter().flat_map(|log| windows(&folder.path().join(format!("{log}.mcap")))).collect();
    assert!(all.iter().all(|window| window.lateness.is_some()), "every point tells its lateness");
    let stalls = all.iter().flat_map(|window| &window.stalls);
    let forced: Vec<f64> = stalls.map(|stall| stall.length_s).filter(|length_s| *length_s > 0.4).collect();
    assert!(forced.len() == 1 && forced[0] >= 0.5 - 2.0 * PERIOD_S, "one event for one stall: {forced:?} s");
}

/// Starts a rehearsal and waits until it moves.
fn begun(run: &Path) -> Child {
    let mut child = Command::new(env!("CARGO_BIN_EXE_bench"))
        .args(["run", "smoke", "--rig", "paced", "--yes", "--json", "--out"])
        .arg(run)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program under test starts");
    let mut lines = BufReader::new(child.stdout.take().expect("piped")).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.contains("procedure-started")), "the run begins");
    // Whoever reads stays: a reader that is gone would be noticed.
    std::thread::spawn(move || lines.for_each(drop));
    rest(Duration::from_secs(4));
    child
}

#[test]
#[ignore = "real time"]
fn a_signal_leaves_the_rig_safe_closes_the_session_and_has_its_exit_code() {
    for (signal, code) in [(Signal::SIGINT, 130), (Signal::SIGTERM, 143)] {
        let folder = folder();
        let run = folder.path().join("run");
        let mut child = begun(&run);
        kill(Pid::from_raw(child.id() as i32), signal).expect("it still runs");
        assert_eq!(child.wait().expect("it ends").code(), Some(code), "{signal}");
        let entries = entries(&run);
        let closed = entries.iter().find_map(|e| match e {
            Entry::SessionClosed { safe, .. } => Some(safe.clone()),
            _ => None,
        });
        assert!(closed.is_some_and(|safe| safe.starts_with("standstill: ")), "{signal}");
        assert!(
            matches!(entries.last(), Some(Entry::Closed { exit_code, .. }) if i32::from(*exit_code) == code)
        );
        let again = run_in(folder.path(), &["rejudge", "run"]);
        assert!(again.out.contains("findings are identical byte for byte"), "{}{}", again.out, again.err);
    }
}

#[test]
#[ignore = "real time"]
fn a_run_that_is_killed_leaves_readable_logs_and_is_lost() {
    let folder = folder();
    let run = folder.path().join("run");
    let mut child = begun(&run);
    child.kill().expect("it still runs");
    child.wait().expect("it is gone");
    assert!(!entries(&run).iter().any(|e| matches!(e, Entry::Closed { .. })), "nobody closed it");
    for log in ["POLARITY.mcap", "session.mcap"] {
        let reader = LogReader::open(&run.join(log)).expect("readable as far as it was written");
        assert_eq!(reader.plan().loop_rate_hz, 1000.0, "{log}");
    }
}

/// Types answers at a terminal, each some seconds after its question.
#[test]
#[ignore = "real time"]
fn a_prompt_that_somebody_thinks_about_is_answered_while_the_session_ticks() {
    let folder = folder();
    let pty = nix::pty::openpty(None, None).expect("a terminal");
    let slave = || Stdio::from(pty.slave.try_clone().expect("another handle"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_bench"))
        .args(["run", "smoke", "--rig", "paced", "--out", "run"])
        .current_dir(folder.path())
        .env("NO_COLOR", "1")
        .stdin(slave())
        .stdout(Stdio::null())
        .stderr(slave())
        .spawn()
        .expect("the program under test starts");
    let mut terminal = std::fs::File::from(pty.master);
    let mut writer = terminal.try_clone().expect("another handle");
    let mut said = String::new();
    let mut bytes = [0; 4096];
    while !said.contains("Can azimuth move") {
        let count = terminal.read(&mut bytes).expect("the program speaks");
        said.push_str(&String::from_utf8_lossy(&bytes[..count]));
    }
    rest(Duration::from_secs(3));
    writer.write_all(b"yes\n").expect("a terminal");
    std::thread::spawn(move || while terminal.read(&mut bytes).is_ok_and(|count| count > 0) {});
    let code = child.wait().expect("it ends").code();
    let run = folder.path().join("run");
    assert_eq!(code, Some(0), "{said}");
    let how = entries(&run).into_iter().find_map(|e| match e {
        Entry::Answered { prompt, how, .. } if prompt == "axes-free" => Some(how),
        _ => None,
    });
    assert_eq!(how.as_deref(), Some("terminal"));
    assert_eq!(unexplained_gaps(&tick_record(&run)), []);
}

#[test]
#[ignore = "a minute and a half of real time"]
fn verdicts_at_the_speed_of_the_day_are_those_of_virtual_time() {
    let folder = folder();
    let run = |rig: &str, out: &str| {
        let said = run_in(folder.path(), &["run", "smoke", "--rig", rig, "--yes", "--out", out]);
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        let text = findings(&folder.path().join(out));
        let found: serde_json::Value = serde_json::from_str(&text).expect("findings are JSON");
        let outcomes = found["outcomes"].as_array().expect("a list").clone();
        outcomes.into_iter().map(|o| (o["requirement"].clone(), o["verdict"].clone())).collect::<Vec<_>>()
    };
    assert_eq!(run("paced", "paced"), run("sim", "virtual"));
}
