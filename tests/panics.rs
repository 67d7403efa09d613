//! Panics in the parts of a run that are not the loop: it must end safe, in order, and readable.

use std::path::{Path, PathBuf};
use std::time::Duration;

use bench::campaign::{self, ProcedureRun, RunError, RunResult, Setup};
use bench::exit;
use bench::files::shipped::{self, Folder};
use bench::judge::{self, JudgeError, JudgedLog, Known};
use bench::people::event::{Listener, RunEvent};
use bench::record::journal;
use bench::record::journal::Entry;
use bench::rig::wires::Wires;
use bench::site::VirtualSite;
use procedures::requirement::Requirements;
use reports::record::Status;
use sim_devices::rig::SimulatedRig;
use validation::intercepted::{Intercepted, Interceptor};

use crate::campaigns::{Silent, nominal, with_setup};

/// Panics while the first point of a procedure is under way, which the journal in this folder tells.
struct PanicsInMotion<'a>(&'a Path);

impl Listener for PanicsInMotion<'_> {
    #[expect(clippy::disallowed_methods, reason = "waits for the thread of the loop")]
    fn hear(&mut self, event: &RunEvent) {
        if !matches!(event, RunEvent::ProcedureStarted { .. }) {
            return;
        }
        let begun = |line: &journal::Line| matches!(line.entry, Entry::PointStarted { .. });
        for _ in 0..2000 {
            let read = journal::read(self.0);
            assert!(
                !read.is_ok_and(|(lines, _)| lines.iter().any(begun)),
                "the listener of this test panics"
            );
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Where a run meets what it does not own: the wires to its devices, and the judge of its logs.
struct Seams {
    wires: fn(&SimulatedRig) -> Wires,
    judge: judge::JudgeFn,
    judge_program: Option<PathBuf>,
}

impl Default for Seams {
    fn default() -> Self {
        Self { wires: Wires::simulated, judge: judge::judge_log, judge_program: None }
    }
}

fn carried_out(names: &[&str], folder: &Path, listener: &mut dyn Listener, seams: Seams) -> RunResult {
    attempted(names, folder, listener, seams).expect("a writable folder")
}

fn attempted(
    names: &[&str],
    folder: &Path,
    listener: &mut dyn Listener,
    seams: Seams,
) -> Result<RunResult, RunError> {
    let unit = nominal();
    let site = VirtualSite::new(&unit, &[]).with_wires(seams.wires);
    with_setup("sim", names, folder, (&unit, &site), |setup| {
        let Seams { judge, judge_program, .. } = seams;
        campaign::run(&Setup { jobs: Some(1), judge, judge_program, ..setup }, listener)
    })
}

/// What the journal says of the points: every one ended at standstill.
fn safe_points(folder: &Path) -> Vec<String> {
    let (lines, _) = journal::read(folder).expect("an intact chain");
    let ended = lines.into_iter().filter_map(|line| match line.entry {
        Entry::PointEnded { status, safe, .. } => {
            assert!(safe.starts_with("standstill: "), "{safe}");
            Some(status)
        }
        _ => None,
    });
    ended.collect()
}

fn of<'a>(result: &'a RunResult, id: &str) -> (&'a ProcedureRun, Option<&'a JudgedLog>) {
    let index = result.page.procedures.iter().position(|p| p.id == id).expect("planned");
    (&result.runs[index], result.judged[index].as_ref())
}

#[test]
fn a_listener_that_panics_in_motion_stops_the_run_under_control_and_says_70() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let seams = Seams { wires: slow_wires, ..Seams::default() };
    let mut panics = PanicsInMotion(folder.path());
    let result = carried_out(&["quick/az-friction"], folder.path(), &mut panics, seams);
    assert_eq!(result.exit_code, exit::INTERNAL);
    assert!(result.listener_lost);
    let stopped = result.runs.iter().find(|run| run.status == Status::Aborted);
    let reason = stopped.and_then(|run| run.reason.clone()).expect("one procedure was stopped");
    assert_eq!(reason, "stopped: internal error: a listener panicked");
    assert!(safe_points(folder.path()).contains(&"aborted".to_owned()));
    let judged = result.judged.iter().flatten().next().expect("its log is readable");
    assert_eq!(judged.damage, None);
}

fn panics_at_azimuth(
    path: &Path,
    file: &str,
    by: &Requirements,
    known: &Known,
) -> Result<JudgedLog, JudgeError> {
    assert!(!file.starts_with("AZ-"), "the judge of this test panics");
    judge::judge_log(path, file, by, known)
}

#[test]
fn a_judge_that_panics_costs_its_procedure_alone_and_says_70() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let seams = Seams { judge: panics_at_azimuth, ..Seams::default() };
    let mut silent = Silent;
    let result = carried_out(&["quick/az-friction", "quick/el-friction"], folder.path(), &mut silent, seams);
    assert_eq!(result.exit_code, exit::INTERNAL);
    let id = |axis: &str| {
        let planned = result.page.procedures.iter().find(|p| p.kind == "hysteresis" && p.axis == axis);
        planned.expect("planned").id.clone()
    };
    let (az, judged) = of(&result, &id("az"));
    assert_eq!(az.status, Status::Errored);
    assert_eq!(az.reason.as_deref(), Some("internal error: the judge panicked"));
    let findings = &judged.expect("a place in the findings").findings;
    assert_eq!((findings.status, findings.measurements.len()), (Status::Errored, 0));
    let (el, judged) = of(&result, &id("el"));
    assert_eq!(el.status, Status::Completed);
    assert!(!judged.expect("judged").findings.measurements.is_empty());
    assert!(safe_points(folder.path()).iter().all(|status| status == "completed"));
    let log = of(&result, &id("az")).1.and_then(|j| j.findings.log.clone()).expect("the log stands");
    let by =
        &Requirements::parse(&shipped::find(Folder::Requirements, "requirements", None).expect("shipped"))
            .expect("shipped");
    let later = judge::judge_log(&folder.path().join(&log), &log, by, &Known::default());
    assert_eq!(later.expect("judged later").damage, None);
}

#[test]
fn a_judge_in_a_process_of_its_own_finds_the_same_to_the_last_bit() {
    let judged = |judge_program: Option<PathBuf>| {
        let folder = tempfile::tempdir().expect("temporary folder");
        let seams = Seams { judge_program, ..Seams::default() };
        let result = carried_out(&["quick/az-friction"], folder.path(), &mut Silent, seams);
        assert_eq!(result.exit_code, exit::PASS);
        result.judged
    };
    let here = judged(None);
    assert!(here.iter().flatten().any(|log| !log.findings.plots.is_empty()));
    assert_eq!(judged(Some(env!("CARGO_BIN_EXE_bench").into())), here);
}

#[test]
fn a_judge_whose_process_dies_opens_no_gate_and_the_log_can_be_judged_later() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let seams = Seams { judge_program: Some("/bin/false".into()), ..Seams::default() };
    let result = carried_out(&["quick/az-friction"], folder.path(), &mut Silent, seams);
    assert_eq!(result.exit_code, exit::INTERNAL);
    let (run, judged) = of(&result, "POLARITY");
    let reason = "the process that judges ended with exit code 1; `bench rejudge` judges the log again";
    assert_eq!((run.status, run.reason.as_deref()), (Status::Errored, Some(reason)));
    let (next, _) = of(&result, "AZ-FRICTION");
    let gate = "polarity: not proven: POLARITY errored";
    assert_eq!((next.status, next.reason.as_deref()), (Status::Skipped, Some(gate)));
    let by = &Requirements::parse(&result.page.requirements.source()).expect("shipped");
    let log = judged.and_then(|log| log.findings.log.clone()).expect("the log stands");
    let later = judge::judge_log(&folder.path().join(&log), &log, by, &Known::default());
    assert_eq!(later.expect("judged later").damage, None);
}

/// Exchanges before a bus of these tests panics, once.
const UNTIL_PANIC: u64 = 20_000;

/// Does something of its own `before` each exchange of a bus, which it is told the number of.
struct Disturbance {
    exchanges: u64,
    before: fn(u64),
}

impl Interceptor for Disturbance {
    fn before_exchange(&mut self, now: Duration) -> Duration {
        self.exchanges += 1;
        (self.before)(self.exchanges);
        now
    }
}

fn disturbed_wires(rig: &SimulatedRig, before: fn(u64)) -> Wires {
    let Wires { bus, ports } = Wires::simulated(rig);
    Wires { bus: Intercepted::boxed(bus, Disturbance { exchanges: 0, before }), ports }
}

/// A defect in the driver of the bus: one exchange in motion panics.
fn panicking_wires(rig: &SimulatedRig) -> Wires {
    disturbed_wires(rig, |exchange| assert!(exchange != UNTIL_PANIC, "the bus of this test panics"))
}

/// Points last seconds, so that what happens beside them happens in motion.
#[expect(clippy::disallowed_methods, reason = "takes time of the machine, not of the loop")]
fn slow_wires(rig: &SimulatedRig) -> Wires {
    disturbed_wires(rig, |_| std::thread::sleep(Duration::from_micros(100)))
}

#[test]
fn a_loop_that_panics_in_motion_leaves_the_rig_safe_the_log_whole_and_says_70() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let seams = Seams { wires: panicking_wires, ..Seams::default() };
    let mut silent = Silent;
    let result = carried_out(&["quick/az-friction"], folder.path(), &mut silent, seams);
    assert_eq!(result.exit_code, exit::INTERNAL);
    let errored = result.runs.iter().find(|run| run.status == Status::Errored).expect("one errored");
    assert!(errored.reason.as_deref().expect("why").starts_with("internal error: the control loop panicked"));
    assert!(safe_points(folder.path()).contains(&"errored".to_owned()));
    assert!(result.judged.iter().flatten().all(|log| log.damage.is_none()));
}

#[test]
fn a_folder_that_another_run_has_taken_is_left_alone() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let page = folder.path().join("run.json");
    let journal = folder.path().join(journal::FILE);
    for file in [&page, &journal] {
        std::fs::write(file, "of the run that came first").expect("writable");
    }
    let mut silent = Silent;
    let refused = attempted(&["quick/az-friction"], folder.path(), &mut silent, Seams::default());
    assert!(matches!(refused, Err(RunError::Taken(_))));
    for file in [&page, &journal] {
        assert_eq!(std::fs::read_to_string(file).expect("readable"), "of the run that came first");
    }
}

/// Removes a file as soon as a point of a procedure has ended.
struct Removes<'a>(&'a str, PathBuf);

impl Listener for Removes<'_> {
    fn hear(&mut self, event: &RunEvent) {
        if matches!(event, RunEvent::PointEnded { procedure, .. } if procedure == self.0) {
            let _ = std::fs::remove_file(&self.1);
        }
    }
}

#[test]
fn a_log_that_somebody_removes_in_mid_run_is_errored_and_says_4() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let log = folder.path().join("AZ-FRICTION.mcap");
    let mut removes = Removes("AZ-FRICTION", log.clone());
    let result = carried_out(&["quick/az-friction"], folder.path(), &mut removes, Seams::default());
    assert!(!log.exists());
    assert_eq!(result.exit_code, exit::BENCH);
    let (run, judged) = of(&result, "AZ-FRICTION");
    assert_eq!(run.status, Status::Errored, "{run:?}");
    assert!(run.reason.as_deref().is_some_and(|reason| reason.contains("removed or replaced")), "{run:?}");
    let findings = &judged.expect("a place in the findings").findings;
    assert_eq!((findings.status, findings.measurements.len()), (Status::Errored, 0));
    let (lines, _) = journal::read(folder.path()).expect("an intact chain");
    let missing = |line: &journal::Line| matches!(&line.entry, Entry::Missing { file, .. } if file == "AZ-FRICTION.mcap");
    assert!(lines.iter().any(missing), "{lines:?}");
}
