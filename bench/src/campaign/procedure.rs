//! One procedure: its points through the loop into one log, then to the judge.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::sync::mpsc::Sender;

use drivers::device::DeviceError;
use procedures::case::Case;
use procedures::log::{LogError, Plan};
use procedures::verdict::Verdict;
use reports::record::Status;

use super::ask::{ask, ask_for_a_look};
use super::ended::point_ended;
use super::held::PointOf;
use super::point::{Ended, LOG_EPOCH_NS, attachments, log_plan, one_point};
use super::procedure_run::{ProcedureRun, keep, note_end};
use super::{Finished, Shared, kept};
use crate::clock;
use crate::cycle::gate;
use crate::cycle::recorder::{LogHead, Recorder};
use crate::exit;
use crate::judge::{self, JudgedLog, Known, Trouble};
use crate::people::Denied;
use crate::people::event::{FirstVerdict, RunEvent};
use crate::people::signals;
use crate::plan::CampaignPlan;
use crate::record::durable;
use crate::record::journal::Entry;

/// Room on the log's time axis for power-up, arrests and the safe state of each point.
const POINT_ROOM_S: f64 = 60.0;

/// Runs procedure `index` of the plan and judges its log.
pub(super) fn run_and_judge(shared: &Shared<'_>, index: usize, events: &Sender<RunEvent>) -> Finished {
    let Shared { setup, journal, .. } = shared;
    let planned = &setup.plan.procedures[index];
    let id = planned.procedure.id.clone();
    let log = format!("{id}.mcap");
    let signal = signals::exit_code(&setup.stop);
    if signal != 0 {
        return (ProcedureRun::not_run(signal), None);
    }
    if let Err(reason) = looked_at(shared, &id, events) {
        let mut run = ProcedureRun::held_back(reason);
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
    let found = kept::put_on_record(&path, &log, journal, &mut run);
    let judged = match found {
        kept::Log::Kept => Some(judge_it(shared, index, &path, &mut run)),
        kept::Log::Missing => Some(judge::missing(&shared.page.procedures[index], setup.seed)),
        kept::Log::None => None,
    };
    note_end(setup, index, journal, &mut run, (found == kept::Log::Kept).then_some(log));
    let status = run.reason.clone().unwrap_or_else(|| run.status.word().to_owned());
    let verdicts = judged.as_ref().map(first_verdicts).unwrap_or_default();
    let planned_s = planned.planned_s();
    let _ = events.send(RunEvent::ProcedureEnded { procedure: id, status, planned_s, verdicts });
    (run, judged)
}

/// The worst verdict of each requirement, in the order in which they were judged.
fn first_verdicts(judged: &JudgedLog) -> Vec<FirstVerdict> {
    let mut worst: Vec<(&str, Verdict)> = Vec::new();
    for judgement in &judged.findings.judgements {
        match worst.iter_mut().find(|(id, _)| *id == judgement.requirement) {
            Some((_, verdict)) => *verdict = (*verdict).max(judgement.verdict),
            None => worst.push((&judgement.requirement, judgement.verdict)),
        }
    }
    let one = |(id, verdict): (&str, Verdict)| FirstVerdict {
        requirement: id.to_owned(),
        verdict: reports::terminal::word(verdict).to_owned(),
    };
    worst.into_iter().map(one).collect()
}

/// What a worker that panicked leaves behind: its log goes on record and is judged as far as it is whole.
pub(super) fn crashed(shared: &Shared<'_>, index: usize) -> Finished {
    let Shared { setup, journal, .. } = shared;
    let log = format!("{}.mcap", setup.plan.procedures[index].procedure.id);
    let path = setup.folder.join(&log);
    let mut run = ProcedureRun::crashed();
    let kept = kept::put_on_record(&path, &log, journal, &mut run) == kept::Log::Kept;
    let judged = kept.then(|| judge_it(shared, index, &path, &mut run));
    note_end(setup, index, journal, &mut run, kept.then_some(log));
    (run, judged)
}

fn judge_it(shared: &Shared<'_>, index: usize, path: &Path, run: &mut ProcedureRun) -> JudgedLog {
    let Shared { setup, page, .. } = shared;
    let planned = &page.procedures[index];
    let tried = match &setup.judge_program {
        Some(program) => judge::judge_aside(program, &setup.folder, index, planned, setup.seed),
        None => {
            let requirements = &setup.plan.requirements;
            judge::try_log(setup.judge, path, planned, requirements, &Known::default(), setup.seed)
        }
    };
    if let Some(trouble) = tried.trouble {
        run.exit_code = exit::worse(run.exit_code, trouble.exit_code());
        if !matches!(trouble, Trouble::Damaged(_)) {
            // The log is there: `rejudge` can still say what it holds.
            run.status = Status::Errored;
            run.reason = Some(trouble.text().to_owned());
        }
    }
    tried.log
}

/// Time that the plan has for a point.
fn room_s(case: &Case) -> f64 {
    case.planned_s() + case.cool_down_s.unwrap_or(0.0) + POINT_ROOM_S
}

/// How long after the beginning of the campaign a point begins, by the plan: all points before it in the order of the file,
/// whether they were run or not, and however many jobs run them.
pub(super) fn planned_from_s(plan: &CampaignPlan, index: usize, point: usize) -> f64 {
    let before = plan.procedures[..index].iter().flat_map(|planned| &planned.cases);
    before.chain(&plan.procedures[index].cases[..point]).map(room_s).sum()
}

/// Log time at which the next point begins: by the plan, so that every run has the same, and after the end of this one
/// in any case.
fn next_start_ns(start_ns: u64, case: &Case, ended: &Result<Ended, DeviceError>) -> u64 {
    let planned_s = room_s(case);
    let took_s = ended.as_ref().map_or(0.0, |ended| ended.outcome.loop_s);
    let room_s = planned_s.ceil().max(took_s.ceil() + 1.0);
    start_ns + (room_s * 1e9) as u64
}

/// Whether the rig may be used: after a trip or a failure somebody must have looked at it. In a session they are asked;
/// its axes are held and watched meanwhile.
fn looked_at(shared: &Shared<'_>, procedure: &str, events: &Sender<RunEvent>) -> Result<(), String> {
    if !shared.halted.load(Ordering::Relaxed) {
        return Ok(());
    }
    let nobody = "an earlier procedure tripped or failed, and the rig has not been inspected since";
    let Some(session) = &shared.session else { return Err(nobody.to_owned()) };
    match ask_for_a_look(shared, procedure, events) {
        Err(Denied::Stopped(code)) => Err(signals::cause(code).to_owned()),
        Err(Denied::Refused(reason)) => Err(format!("{nobody}: {reason}")),
        Ok(()) => {
            session.lock().unwrap_or_else(PoisonError::into_inner).was_looked_at();
            shared.halted.store(false, Ordering::Relaxed);
            Ok(())
        }
    }
}

/// Runs a point in the run's session, or on a rig of its own where there is none. The log comes back, unless the session
/// is gone.
fn in_its_place(
    shared: &Shared<'_>,
    index: usize,
    plan: &Plan,
    point: usize,
    log_start_ns: u64,
    mut recorder: Recorder,
    run: &mut ProcedureRun,
) -> (Result<Ended, DeviceError>, Option<Recorder>) {
    let Some(session) = &shared.session else {
        let ended = one_point(shared.setup, index, plan, point, log_start_ns, &mut recorder);
        return (ended, Some(recorder));
    };
    let mut session = session.lock().unwrap_or_else(PoisonError::into_inner);
    let ended =
        session.run(PointOf { procedure: index, plan, point, devices: &shared.page.devices }, recorder);
    session.take_news().into_iter().for_each(|entry| keep(&shared.journal, entry, run));
    ended
}

/// What a log says of itself: which run it belongs to, and when it began.
fn about(shared: &Shared<'_>, procedure: &str) -> BTreeMap<String, String> {
    let Shared { setup, page, .. } = shared;
    let run = setup.folder.file_name().map(|name| name.to_string_lossy().into_owned());
    let entries = [
        ("begun_utc", Some(clock::utc_now())),
        ("run_started_utc", Some(page.started_utc.clone())),
        ("run", run),
        ("campaign", Some(page.campaign.clone())),
        ("procedure", Some(procedure.to_owned())),
        ("rig", Some(page.rig_id.clone())),
        ("unit", Some(page.unit.clone())),
        ("serial_number", setup.serial_number.clone()),
        ("operator", setup.operator.clone()),
    ];
    let known = entries.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?)));
    known.collect()
}

fn record(
    shared: &Shared<'_>,
    index: usize,
    path: &Path,
    events: &Sender<RunEvent>,
) -> Result<ProcedureRun, LogError> {
    let setup = shared.setup;
    let planned = &setup.plan.procedures[index];
    let procedure = &planned.procedure;
    let cases = &planned.cases;
    let plan = log_plan(setup, &shared.page.devices, index);
    let head = LogHead::new(&plan, setup.rig);
    if let Some(reason) = gate::free_disk(&setup.folder, gate::planned_log_bytes(&plan, &head.topics)) {
        return Ok(ProcedureRun::errored(format!("refused before motion: {reason}"), exit::REFUSED));
    }
    // In real time nobody waits for the disk: the ring holds, or the loop stops.
    let attached = attachments(setup, &shared.page.devices, index);
    let waits = shared.session.is_none();
    let mut recorder = Some(Recorder::start(
        path,
        LogHead { attachments: &attached, about: about(shared, &procedure.id), ..head },
        waits,
    )?);
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
        point_begins(shared, index, point, &mut run, events);
        let Some(own) = recorder.take() else { break };
        let (ended, back) = in_its_place(shared, index, &plan, point, log_start_ns, own, &mut run);
        recorder = back;
        log_start_ns = next_start_ns(log_start_ns, case, &ended);
        setup.underway.end(&procedure.id);
        point_ended(shared, index, case, &ended, &mut run, events);
        if run.status != Status::Completed {
            break;
        }
    }
    if let Some(Err(error)) = recorder.map(Recorder::finish) {
        run.status = Status::Errored;
        run.reason = Some(format!("{error}; {}", durable::OUTPUT_HELP));
        run.exit_code = exit::worse(run.exit_code, exit::BENCH);
    }
    Ok(run)
}

/// The journal, the terminal and the stream of events hear of a point before its first motion.
fn point_begins(
    shared: &Shared<'_>,
    index: usize,
    point: usize,
    run: &mut ProcedureRun,
    events: &Sender<RunEvent>,
) {
    let Shared { setup, journal, .. } = shared;
    let planned = &setup.plan.procedures[index];
    let (id, case, points) = (&planned.procedure.id, &planned.cases[point], planned.cases.len());
    keep(journal, Entry::PointStarted { procedure: id.clone(), point: case.point.clone() }, run);
    setup.underway.begin(id, case, point + 1, points);
    let _ = events.send(RunEvent::PointStarted {
        procedure: id.clone(),
        point: case.point.clone(),
        number: point + 1,
        points,
        planned_s: case.planned_s(),
    });
}
