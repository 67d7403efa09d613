//! One procedure: its points through the loop into one log, then to the judge.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::mpsc::Sender;
use std::sync::{Mutex, PoisonError};

use drivers::device::DeviceError;
use procedures::axis::ticks_per_row;
use procedures::case::Case;
use procedures::log::{Attachment, LogError, Plan, PointStatus};
use procedures::procedure::Prompt;
use reports::record::{DeviceRecord, Status};
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};

use super::{Setup, Shared};
use crate::axis_loop::AxisLoop;
use crate::channels;
use crate::clock::Clock;
use crate::dither::Dither;
use crate::event::RunEvent;
use crate::exit;
use crate::gate;
use crate::journal::{AxisAngle, Entry, Journal};
use crate::judge::{self, JudgedLog};
use crate::page::Page;
use crate::payload;
use crate::people::Denied;
use crate::prompt::{Answer, Question};
use crate::recorder::Recorder;
use crate::rig::{OpenRig, limited};
use crate::run::{Conditions, PointOutcome, run_point};
use crate::signals;

/// Log time of a run's first point: one second after the epoch, because zero means "no time" to some readers.
const LOG_EPOCH_NS: u64 = 1_000_000_000;
/// Room on the log's time axis for power-up, arrests and the safe state of each point.
const POINT_ROOM_S: f64 = 60.0;
/// Devices on the gimbal are logged at this rate at the most while no procedure is about them.
const PAYLOAD_LOG_HZ: f64 = 500.0;
/// The same as a share of the log's own rate: who asks for few rows does so of all devices.
const PAYLOAD_SHARE: f64 = 0.25;

/// How a procedure ended.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcedureRun {
    /// Status.
    pub status: Status,
    /// Why it did not complete.
    pub reason: Option<String>,
    /// Loop time of its points.
    pub loop_s: f64,
    /// What it means for the program's exit.
    pub exit_code: u8,
}

impl ProcedureRun {
    /// A worker that vanished.
    pub(super) fn crashed() -> Self {
        let reason = Some("internal error: the worker of this procedure panicked".to_owned());
        Self { status: Status::Errored, reason, loop_s: 0.0, exit_code: exit::INTERNAL }
    }

    /// Not begun, because a signal came first.
    pub(super) fn not_run(code: u8) -> Self {
        let reason = Some("stopped before it began".to_owned());
        Self { status: Status::NotRun, reason, loop_s: 0.0, exit_code: code }
    }

    /// Not begun, because a gate of the run is closed.
    pub(super) fn held_back(reason: String) -> Self {
        Self { status: Status::Skipped, reason: Some(reason), loop_s: 0.0, exit_code: exit::INCONCLUSIVE }
    }

    fn stopped(&mut self, code: u8) {
        self.status = Status::Aborted;
        self.reason = Some(signals::cause(code).to_owned());
        self.exit_code = exit::worse(self.exit_code, code);
    }

    /// Not begun, because a prompt was not answered with yes.
    fn denied(denied: Denied) -> Self {
        match denied {
            Denied::Stopped(code) => Self::not_run(code),
            Denied::Refused(reason) => {
                Self { status: Status::Skipped, reason: Some(reason), loop_s: 0.0, exit_code: exit::REFUSED }
            }
        }
    }

    /// The same after some of its points.
    fn denied_in_between(&mut self, denied: Denied) {
        match denied {
            Denied::Stopped(code) => self.stopped(code),
            Denied::Refused(reason) => {
                self.status = Status::Aborted;
                self.reason = Some(reason);
                self.exit_code = exit::worse(self.exit_code, exit::REFUSED);
            }
        }
    }

    fn errored(reason: String, exit_code: u8) -> Self {
        Self { status: Status::Errored, reason: Some(reason), loop_s: 0.0, exit_code }
    }
}

/// Runs procedure `index` of the plan and judges its log.
pub(super) fn run_and_judge(
    shared: &Shared<'_>,
    index: usize,
    events: &Sender<RunEvent>,
) -> (ProcedureRun, Option<JudgedLog>) {
    let Shared { setup, journal, .. } = shared;
    let planned = &setup.plan.procedures[index];
    let id = planned.procedure.id.clone();
    let log = format!("{id}.mcap");
    let signal = signals::exit_code(&setup.stop);
    if signal != 0 {
        return (ProcedureRun::not_run(signal), None);
    }
    if shared.halted.load(std::sync::atomic::Ordering::Relaxed) {
        let reason = "an earlier procedure tripped or failed on a real axis, and nobody has looked yet";
        let mut run = ProcedureRun::held_back(reason.to_owned());
        note_end(setup, index, journal, &mut run, None);
        return (run, None);
    }
    let points = planned.cases.len();
    let _ = events.send(RunEvent::ProcedureStarted { procedure: id.clone(), points });
    let path = setup.folder.join(&log);
    let mut run = match ask(shared, index, events) {
        Err(denied) => ProcedureRun::denied(denied),
        Ok(()) => record(shared, index, &path, events)
            .unwrap_or_else(|error| ProcedureRun::errored(error.to_string(), exit::BENCH)),
    };
    let judged = judge_it(setup, index, &path, &mut run);
    note_end(setup, index, journal, &mut run, judged.is_some().then_some(log));
    let status = run.reason.clone().unwrap_or_else(|| run.status.word().to_owned());
    let _ = events.send(RunEvent::ProcedureEnded { procedure: id, status });
    (run, judged)
}

/// Writes the end of a procedure into the journal.
pub(super) fn note_end(
    setup: &Setup<'_>,
    index: usize,
    journal: &Mutex<Journal>,
    run: &mut ProcedureRun,
    log: Option<String>,
) {
    let procedure = setup.plan.procedures[index].procedure.id.clone();
    let (status, reason) = (run.status.word().to_owned(), run.reason.clone());
    keep(journal, Entry::ProcedureEnded { procedure, status, log, reason }, run);
}

fn judge_it(setup: &Setup<'_>, index: usize, path: &Path, run: &mut ProcedureRun) -> Option<JudgedLog> {
    if !path.exists() {
        return None;
    }
    let planned = Page::logs(setup.plan).swap_remove(index);
    let judge = || (setup.seams.judge)(path, &planned.log, &setup.plan.requirements);
    match catch_unwind(AssertUnwindSafe(judge)) {
        Ok(Ok(judged)) => {
            if judged.damage.is_some() {
                run.exit_code = exit::worse(run.exit_code, exit::DAMAGED);
            }
            Some(judged)
        }
        Ok(Err(error)) => {
            run.reason.get_or_insert_with(|| error.to_string());
            run.exit_code = exit::worse(run.exit_code, exit::BENCH);
            None
        }
        // The log is whole: `rejudge` can still say what it holds.
        Err(_) => {
            let reason = "internal error: the judge panicked".to_owned();
            run.status = Status::Errored;
            run.reason = Some(reason.clone());
            run.exit_code = exit::worse(run.exit_code, exit::INTERNAL);
            Some(judge::unjudged(&planned, setup.seed, reason))
        }
    }
}

/// A journal that cannot be written any more makes the run a bench failure, but stops nothing that is in motion.
fn keep(journal: &Mutex<Journal>, entry: Entry, run: &mut ProcedureRun) {
    let written = journal.lock().map(|mut j| j.write(entry));
    if !matches!(written, Ok(Ok(()))) {
        run.exit_code = exit::worse(run.exit_code, exit::BENCH);
        run.reason.get_or_insert_with(|| "the journal cannot be written any more".to_owned());
    }
}

/// Has the prompts of a procedure answered; called before each point, because an answer may have become too old.
fn ask(shared: &Shared<'_>, index: usize, events: &Sender<RunEvent>) -> Result<(), Denied> {
    let procedure = &shared.setup.plan.procedures[index].procedure;
    if procedure.prompts.is_empty() {
        return Ok(());
    }
    let mut desk = shared.desk.lock().unwrap_or_else(PoisonError::into_inner);
    let mut kept = true;
    let said = desk.clear(
        &procedure.id,
        &procedure.prompts,
        &shared.setup.stop,
        &mut |text| {
            let _ = events.send(RunEvent::Notice { text: format!("{}: {text}", procedure.id) });
        },
        &mut |entry| kept &= matches!(shared.journal.lock().map(|mut j| j.write(entry)), Ok(Ok(()))),
    );
    // Nobody may rely on an answer that is not on record.
    if kept { said } else { Err(Denied::Refused("an answer cannot be written into the journal".to_owned())) }
}

fn record(
    shared: &Shared<'_>,
    index: usize,
    path: &Path,
    events: &Sender<RunEvent>,
) -> Result<ProcedureRun, LogError> {
    let Shared { setup, journal, .. } = shared;
    let planned = &setup.plan.procedures[index];
    let (procedure, cases) = (&planned.procedure, &planned.cases);
    let plan = log_plan(setup, index);
    let axes = setup.rig.axis_names();
    let topics = channels::topics(&axes, &payload::groups(&setup.rig.payload));
    if let Some(reason) = gate::free_disk(&setup.folder, gate::planned_log_bytes(&plan, &topics)) {
        return Ok(ProcedureRun::errored(format!("refused before motion: {reason}"), exit::REFUSED));
    }
    let mut recorder = Recorder::start(path, &plan, topics, &attachments(setup, index), axes, true)?;
    let mut run =
        ProcedureRun { status: Status::Completed, reason: None, loop_s: 0.0, exit_code: exit::PASS };
    let mut log_start_ns = LOG_EPOCH_NS;
    for (point, case) in cases.iter().enumerate() {
        let signal = signals::exit_code(&setup.stop);
        if signal != 0 {
            run.stopped(signal);
            break;
        }
        if let Err(denied) = ask(shared, index, events) {
            run.denied_in_between(denied);
            break;
        }
        let begun = Entry::PointStarted { procedure: procedure.id.clone(), point: case.point.clone() };
        keep(journal, begun, &mut run);
        let ended = one_point(setup, index, &plan, (point, log_start_ns), &mut recorder);
        log_start_ns += ((case.planned_s() + POINT_ROOM_S).ceil() * 1e9) as u64;
        point_ended(shared, index, case, (&ended, &mut run), events);
        if run.status != Status::Completed {
            break;
        }
    }
    if let Err(error) = recorder.finish() {
        run.status = Status::Errored;
        run.reason = Some(format!("{error}; {}", super::OUTPUT_HELP));
        run.exit_code = exit::worse(run.exit_code, exit::BENCH);
    }
    Ok(run)
}

/// What a point came to: for the run, the journal and whoever listens.
fn point_ended(
    shared: &Shared<'_>,
    index: usize,
    case: &Case,
    (ended, run): (&Result<PointOutcome, DeviceError>, &mut ProcedureRun),
    events: &Sender<RunEvent>,
) {
    let Shared { setup, journal, .. } = shared;
    let procedure = setup.plan.procedures[index].procedure.id.clone();
    if run_badly(ended) {
        shared.ended_badly(ended.as_ref().is_ok_and(|o| o.safe.standstill));
    }
    let axes = setup.rig.axis_names();
    let reason = note(run, ended, setup);
    let status = Status::from(ended.as_ref().map_or(PointStatus::Errored, |o| o.status)).word().to_owned();
    let (point, planned_s) = (case.point.clone(), case.planned_s());
    let entry = Entry::PointEnded {
        procedure: procedure.clone(),
        point: point.clone(),
        status: status.clone(),
        reason: reason.clone(),
        safe: ended.as_ref().map_or(String::new(), |o| o.safe.text(&axes)),
        angles_deg: ended.as_ref().map_or_else(|_| Vec::new(), |o| angles(o, &axes)),
    };
    keep(journal, entry, run);
    let _ = events.send(RunEvent::PointEnded { procedure, point, status, planned_s, reason });
}

/// Takes a point's end into the procedure's; returns the reason where it did not complete.
fn note(
    run: &mut ProcedureRun,
    ended: &Result<PointOutcome, DeviceError>,
    setup: &Setup<'_>,
) -> Option<String> {
    let (status, reason, code) = match ended {
        Err(error) => (Status::Errored, error.to_string(), exit::BENCH),
        Ok(outcome) => {
            run.loop_s += outcome.loop_s;
            let reasons = reasons(outcome, setup);
            if reasons.is_empty() {
                return None;
            }
            let code = reasons.iter().fold(exit::PASS, |code, (_, other)| exit::worse(code, *other));
            let texts: Vec<&str> = reasons.iter().map(|(text, _)| text.as_str()).collect();
            (outcome.status.into(), texts.join("; "), code)
        }
    };
    run.status = status;
    run.reason = Some(reason.clone());
    run.exit_code = exit::worse(run.exit_code, code);
    Some(reason)
}

/// Whether a point tripped, failed or did not end at standstill.
fn run_badly(ended: &Result<PointOutcome, DeviceError>) -> bool {
    ended.as_ref().map_or(true, |o| o.trip.is_some() || o.error.is_some() || !o.safe.standstill)
}

/// Everything that kept a point from completing, each with what it means for the exit.
fn reasons(outcome: &PointOutcome, setup: &Setup<'_>) -> Vec<(String, u8)> {
    let mut all = Vec::new();
    if let Some(trip) = &outcome.trip {
        all.push((format!("tripped: {}", trip.reason(&setup.rig.axis_names())), exit::INCONCLUSIVE));
    }
    if let Some(error) = &outcome.error {
        let internal = error.starts_with("internal error");
        all.push((error.clone(), if internal { exit::INTERNAL } else { exit::BENCH }));
    }
    if let Some(refused) = &outcome.refused {
        all.push((format!("refused before motion: {refused}"), exit::REFUSED));
    }
    all.extend(outcome.signal.map(|code| (signals::cause(code).to_owned(), code)));
    all
}

/// Where the axes were left, for whoever must compare.
fn angles(outcome: &PointOutcome, axes: &[String]) -> Vec<AxisAngle> {
    let known = outcome.safe.axes.iter().filter(|left| left.position_rad.is_finite());
    known
        .filter_map(|left| {
            Some(AxisAngle { axis: axes.get(left.axis)?.clone(), deg: left.position_rad.to_degrees() })
        })
        .collect()
}

fn one_point(
    setup: &Setup<'_>,
    index: usize,
    plan: &Plan,
    (point, log_start_ns): (usize, u64),
    recorder: &mut Recorder,
) -> Result<PointOutcome, DeviceError> {
    let case = &plan.cases[point];
    let (unit, rate_hz) = (crate::scenery::shown(&setup.unit.settings, case), setup.rig.loop_rate_hz);
    let start = start_state(setup, case);
    let simulated = SimulatedRig::at_rate(&unit, &address(plan, case), start, rate_hz);
    let wires = (setup.seams.wires)(&simulated);
    let rig_file = limited(setup.rig, case);
    let _armed = signals::Armed::new(&setup.stop);
    let mut rig = OpenRig::open(wires, &rig_file, setup.gains, &Clock::Virtual)?.arm()?;
    let loops = AxisLoop::of_rig(setup.rig, setup.gains);
    let moving = setup.rig.axis_index(&case.axis).ok_or_else(|| DeviceError::Bus {
        device: setup.rig.id.clone(),
        reason: format!("the rig has no axis `{}`", case.axis),
    })?;
    let quantum_nm = plan.axes.get(&case.axis).map_or(0.0, |a| a.torque_quantum_nm);
    let log_every = (rate_hz / plan.log_rate_hz).round().max(1.0) as u64;
    let conditions = Conditions {
        point,
        case,
        moving,
        log_start_ns,
        loop_rate_hz: setup.rig.loop_rate_hz,
        log_every,
        log_payload_every: if case.logs_payload_fully {
            1
        } else {
            (plan.log_rate_hz / PAYLOAD_LOG_HZ.min(PAYLOAD_SHARE * plan.log_rate_hz)).ceil() as u64
        },
        max_missed_periods: setup.rig.max_missed_periods,
        gates: &setup.plan.procedures[index].procedure.gates,
        questions: &answered(&setup.plan.procedures[index].procedure.prompts),
        parks: point + 1 == plan.cases.len(),
        stop: &setup.stop,
        clock: Clock::Virtual,
    };
    let mut dither = Dither::new(plan, &case.point, quantum_nm);
    let mut outcome = run_point(&mut rig, loops, &conditions, &mut dither, recorder);
    // The bench cannot see an end stop; the simulator can, and a contact is never what was planned.
    if let Some((axis, at_s, speed)) = simulated.record().crashes.first() {
        let text = format!("{axis} hit its end stop at {at_s:.3} s with {:.2} deg/s", speed.to_degrees());
        outcome.error.get_or_insert(text);
        outcome.status = PointStatus::Errored;
    }
    Ok(outcome)
}

/// In virtual time nobody can be waited for: every prompt was answered before the point began, or it does not begin.
fn answered(prompts: &[Prompt]) -> Vec<Question> {
    prompts
        .iter()
        .map(|prompt| {
            let question = Question::new(prompt.class);
            question.give(Answer::Confirmed);
            question
        })
        .collect()
}

fn address(plan: &Plan, case: &Case) -> SeedAddress {
    SeedAddress { seed: plan.seed, procedure: plan.procedure.clone(), point: case.point.clone() }
}

/// Every point of the virtual tier starts from a declared state: at rest, bristles relaxed, heat sinks at ambient.
fn start_state(setup: &Setup<'_>, case: &Case) -> StartState {
    let at = |axis: &str| case.start_pose_rad.get(axis).copied().unwrap_or(0.0);
    StartState { az_rad: at("az"), el_rad: at("el"), heat_sink_degc: setup.unit.settings.az.ambient_degc }
}

fn log_plan(setup: &Setup<'_>, index: usize) -> Plan {
    let planned = &setup.plan.procedures[index];
    let loop_rate_hz = setup.rig.loop_rate_hz;
    let every = ticks_per_row(loop_rate_hz, planned.procedure.log_rate_hz);
    Plan {
        schema: 1,
        procedure: planned.procedure.id.clone(),
        axis: planned.procedure.axis.clone(),
        seed: setup.seed,
        loop_rate_hz,
        log_rate_hz: loop_rate_hz / every,
        command_delay_ticks: 1,
        axes: setup.rig.limits(),
        cases: planned.cases.clone(),
        mode: "simulated".to_owned(),
    }
}

fn attachments(setup: &Setup<'_>, index: usize) -> Vec<Attachment> {
    let attach = |name: &str, text: &str| Attachment { name: name.to_owned(), text: text.to_owned() };
    let mut all = vec![
        attach("procedure.toml", &setup.plan.procedures[index].procedure.source.text),
        attach("requirements.toml", &setup.plan.requirements_source.text),
        attach("rig.toml", &setup.rig.source.text),
    ];
    for (layer, source) in setup.unit.sources.iter().enumerate() {
        all.push(attach(&format!("unit.{layer}.toml"), &source.text));
    }
    all
}

/// Opens the rig once, before anything moves, to learn the name of its bus and who its devices are.
pub(super) fn identify(setup: &Setup<'_>) -> Result<(String, Vec<DeviceRecord>), DeviceError> {
    let address = SeedAddress { seed: setup.seed, procedure: "identify".to_owned(), point: String::new() };
    let start = StartState { az_rad: 0.0, el_rad: 0.0, heat_sink_degc: setup.unit.settings.az.ambient_degc };
    let simulated = SimulatedRig::new(&setup.unit.settings, &address, start);
    let wires = (setup.seams.wires)(&simulated);
    let bus = wires.bus.name().to_owned();
    let rig = OpenRig::open(wires, setup.rig, setup.gains, &Clock::Virtual)?;
    Ok((bus, crate::devices::records(setup.rig, &rig)))
}
