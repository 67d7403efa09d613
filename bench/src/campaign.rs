//! The campaign runner: procedures to jobs, points to the loop, logs to the judge, all of it to the journal.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU16, AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, PoisonError};

use controllers::DirectorGains;
use reports::record::{DeviceRecord, Origin, TitlePage};
use sim_devices::rig::SimulatedRig;

use crate::event::{Guarded, Listener, RunEvent};
use crate::exit;
use crate::files::rig::Rig;
use crate::files::unit::Unit;
use crate::journal::{Entry, Journal};
use crate::judge::{self, JudgedLog};
use crate::lock::{self, Held, LockError};
use crate::page::Page;
use crate::people::{self, Answers, Desk, Situation};
use crate::plan::CampaignPlan;
use crate::polarity::{self, Basis, Gate};
use crate::signals;
use crate::wires::Wires;

mod procedure;
#[cfg(test)]
mod tests;

pub use procedure::ProcedureRun;

/// Everything that a run is made from.
pub struct Setup<'a> {
    /// Campaign, planned.
    pub plan: &'a CampaignPlan,
    /// Rig.
    pub rig: &'a Rig,
    /// Simulated unit.
    pub unit: &'a Unit,
    /// Gains of the production controllers.
    pub gains: &'a DirectorGains,
    /// Run folder, existing and empty.
    pub folder: PathBuf,
    /// Seed.
    pub seed: u64,
    /// Procedures at a time, where somebody asked for a number.
    pub jobs: Option<usize>,
    /// How prompts are answered.
    pub answers: Answers,
    /// Where the lock files lie.
    pub lock_folder: PathBuf,
    /// Who runs it.
    pub operator: Option<String>,
    /// Serial number of the unit under test.
    pub serial_number: Option<String>,
    /// How the program was called.
    pub command_line: String,
    /// Set by signals, see [`crate::signals`].
    pub stop: Arc<AtomicU16>,
    /// Earlier run whose proof of polarity is relied on.
    pub polarity: Option<PathBuf>,
    /// What is put in for wires and judge.
    pub seams: Seams,
}

/// The two places where a run meets what it does not own: the wires to its devices, and the judge of its logs.
#[derive(Clone, Copy)]
pub struct Seams {
    /// The host's ends of the wires of a rig.
    pub wires: fn(&SimulatedRig) -> Wires,
    /// Judges a closed log.
    pub judge: judge::JudgeFn,
}

impl Default for Seams {
    fn default() -> Self {
        Self { wires: Wires::simulated, judge: judge::judge_log }
    }
}

/// What a run came to, before the report.
pub struct RunResult {
    /// Title page as written.
    pub page: Page,
    /// Judged logs, in the plan's order; `None` where a procedure left none.
    pub judged: Vec<Option<JudgedLog>>,
    /// How each procedure ended, in the plan's order.
    pub runs: Vec<ProcedureRun>,
    /// Loop time of all points, s.
    pub simulated_s: f64,
    /// A listener panicked; it must not be spoken to again.
    pub listener_lost: bool,
    /// Exit code so far (without the verdict).
    pub exit_code: u8,
    /// What the run holds, to be released after that.
    pub held: Held,
    /// Whether every point ended at standstill: otherwise the rig is not given back before somebody has looked.
    pub stands: bool,
    /// The journal, to be closed with the final exit code.
    pub journal: Journal,
}

/// Why a run could not be carried out or kept.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// Output: exit 4.
    #[error("{file}: {source}; {help}")]
    Output {
        /// File or folder.
        file: String,
        /// Cause.
        source: std::io::Error,
        /// What to do.
        help: &'static str,
    },
    /// A device: exit 4.
    #[error("{0}")]
    Device(#[from] drivers::device::DeviceError),
    /// Refused before motion: exit 6.
    #[error("refused before motion: {0}")]
    Refused(String),
    /// Something that the run needs is held by somebody else, or was left by a run that was lost: exit 6.
    #[error("refused before motion: {0}")]
    Locked(#[from] LockError),
}

/// Advice for output that cannot be written.
pub const OUTPUT_HELP: &str =
    "check that the folder exists, is writable and has free space, or choose another --out";

fn output(path: &Path, source: std::io::Error) -> RunError {
    RunError::Output { file: path.display().to_string(), source, help: OUTPUT_HELP }
}

/// What the workers share.
struct Shared<'a> {
    setup: &'a Setup<'a>,
    journal: Mutex<Journal>,
    slots: Mutex<Vec<Option<Finished>>>,
    desk: Mutex<Desk>,
    /// Whether any device is real.
    real: bool,
    /// Something tripped or failed on a real axis: nothing moves again before somebody has looked.
    halted: AtomicBool,
    /// Some point did not end at standstill.
    moves: AtomicBool,
}

type Finished = (ProcedureRun, Option<JudgedLog>);

/// Runs a planned campaign and judges every log as soon as it is closed. Polarity comes first and alone; where it is
/// not proven, nothing that closes a loop is run.
///
/// # Errors
/// When the folder cannot be written, the rig's devices cannot be opened, or the run is refused; everything later is
/// in the result.
pub fn run(setup: &Setup<'_>, listener: &mut dyn Listener) -> Result<RunResult, RunError> {
    let (page, held) = admit(setup)?;
    page.write(&setup.folder).map_err(|e| output(&setup.folder, e))?;
    let journal = open_journal(setup, &page).map_err(|e| output(&setup.folder, e))?;
    let slots = Mutex::new(setup.plan.procedures.iter().map(|_| None).collect());
    held.arm()?;
    let real = page.devices.iter().any(|device| device.real);
    let desk = Mutex::new(Desk::new(setup.answers.clone(), real, setup.operator.as_deref()));
    let (halted, moves) = (AtomicBool::new(false), AtomicBool::new(false));
    let shared = Shared { setup, journal: Mutex::new(journal), slots, desk, real, halted, moves };
    let mut listener = Guarded::new(listener, &setup.stop);
    listener.hear(&started(setup));
    let (first, others) = order(setup.plan);
    work(&shared, &first, 1, &mut listener);
    let gate = polarity_gate(&shared, &page, &first);
    let (others, held_back) = others.into_iter().partition::<Vec<usize>, _>(|&index| {
        gate == Gate::Open || !setup.plan.procedures[index].closes_loops()
    });
    work(&shared, &others, page.jobs, &mut listener);
    skip(&shared, &held_back, &gate, &mut listener);
    let lost = listener.is_lost();
    Ok(result(shared, page, held, lost))
}

fn result(shared: Shared<'_>, page: Page, held: Held, listener_lost: bool) -> RunResult {
    let Shared { setup, journal, slots, moves, .. } = shared;
    let slots = slots.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter();
    let results = slots.map(|slot| slot.unwrap_or_else(|| (ProcedureRun::crashed(), None)));
    let (runs, judged): (Vec<ProcedureRun>, Vec<_>) = results.unzip();
    // A signal after the last point still ends the run as stopped.
    let mut code = signals::exit_code(&setup.stop);
    if listener_lost {
        code = exit::worse(code, exit::INTERNAL);
    }
    RunResult {
        page,
        judged,
        simulated_s: runs.iter().map(|run| run.loop_s).sum(),
        exit_code: runs.iter().fold(code, |code, run| exit::worse(code, run.exit_code)),
        runs,
        listener_lost,
        held,
        stands: !moves.into_inner(),
        journal: journal.into_inner().unwrap_or_else(PoisonError::into_inner),
    }
}

fn open_journal(setup: &Setup<'_>, page: &Page) -> std::io::Result<Journal> {
    let mut journal = Journal::create(&setup.folder)?;
    journal.write(Entry::Opened {
        campaign: page.campaign.clone(),
        rig: page.rig_id.clone(),
        unit: page.unit.clone(),
        seed: setup.seed,
    })?;
    if let Some(from) = &setup.polarity {
        let from = Some(from.display().to_string());
        journal.write(Entry::Polarity { hash: page.polarity.hash(), proven: true, fault: None, from })?;
    }
    Ok(journal)
}

/// Runs procedures, `jobs` at a time, and hands what happens to the listener.
fn work(shared: &Shared<'_>, order: &[usize], jobs: usize, listener: &mut Guarded<'_>) {
    let next = AtomicUsize::new(0);
    let (events, heard) = channel::<RunEvent>();
    std::thread::scope(|scope| {
        for _ in 0..jobs.clamp(1, order.len().max(1)) {
            let (events, next) = (events.clone(), &next);
            scope.spawn(move || {
                while let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    // A defect in one procedure must not take the others, the journal and the results with it.
                    let run = || procedure::run_and_judge(shared, index, &events);
                    let finished = catch_unwind(AssertUnwindSafe(run));
                    if finished.is_err() {
                        shared.ended_badly(false);
                    }
                    shared.keep(index, finished.unwrap_or_else(|_| (ProcedureRun::crashed(), None)));
                }
            });
        }
        drop(events);
        for event in heard {
            listener.hear(&event);
        }
    });
}

impl Shared<'_> {
    /// A point tripped or failed; `stands` is whether the axes were left at standstill.
    fn ended_badly(&self, stands: bool) {
        // Simulated points begin in worlds of their own.
        self.halted.fetch_or(self.real, Ordering::Relaxed);
        self.moves.fetch_or(!stands, Ordering::Relaxed);
    }

    fn keep(&self, index: usize, finished: Finished) {
        self.slots.lock().unwrap_or_else(PoisonError::into_inner)[index] = Some(finished);
    }
}

/// What the polarity procedures came to; it goes into the journal for later runs.
fn polarity_gate(shared: &Shared<'_>, page: &Page, checked: &[usize]) -> Gate {
    if checked.is_empty() {
        let needed = page.procedures.iter().any(|p| p.closes_loops) && shared.setup.polarity.is_none();
        let reason = format!("{}: not proven: nothing in the plan checks it", polarity::KIND);
        return if needed { Gate::Closed(reason) } else { Gate::Open };
    }
    let slots = shared.slots.lock().unwrap_or_else(PoisonError::into_inner);
    let gate = polarity::gate(&page.procedures, |index| {
        let (_, log) = slots[index].as_ref()?;
        log.as_ref().map(|log| (log.findings.status, log.proof.clone()))
    });
    let fault = gate.reason().map(str::to_owned);
    let entry = Entry::Polarity { hash: page.polarity.hash(), proven: fault.is_none(), fault, from: None };
    // A journal that cannot be written shows itself at the next procedure's end; no motion hangs on this line.
    let _ = shared.journal.lock().unwrap_or_else(PoisonError::into_inner).write(entry);
    gate
}

/// Procedures that close loops while the gate is closed.
fn skip(shared: &Shared<'_>, indices: &[usize], gate: &Gate, listener: &mut Guarded<'_>) {
    for &index in indices {
        let id = shared.setup.plan.procedures[index].procedure.id.clone();
        let reason = gate.reason().unwrap_or_default().to_owned();
        let mut run = match signals::exit_code(&shared.setup.stop) {
            0 => ProcedureRun::held_back(reason.clone()),
            code => ProcedureRun::not_run(code),
        };
        procedure::note_end(shared.setup, index, &shared.journal, &mut run, None);
        listener.hear(&RunEvent::ProcedureEnded { procedure: id, status: format!("skipped: {reason}") });
        shared.keep(index, (run, None));
    }
}

/// Polarity first, in the plan's order; then the others, longest first: the last one to finish decides how long a
/// run takes.
fn order(plan: &CampaignPlan) -> (Vec<usize>, Vec<usize>) {
    let checks = |&index: &usize| plan.procedures[index].procedure.kind == polarity::KIND;
    let (first, mut others): (Vec<usize>, Vec<usize>) = (0..plan.procedures.len()).partition(checks);
    others.sort_by(|&a, &b| {
        plan.procedures[b].planned_s().total_cmp(&plan.procedures[a].planned_s()).then(a.cmp(&b))
    });
    (first, others)
}

fn started(setup: &Setup<'_>) -> RunEvent {
    RunEvent::RunStarted {
        campaign: setup.plan.id.clone(),
        rig: setup.rig.id.clone(),
        unit: setup.unit.id.clone(),
        procedures: setup.plan.procedures.len(),
        planned_s: setup.plan.procedures.iter().map(|p| p.planned_s()).sum(),
        folder: setup.folder.display().to_string(),
    }
}

/// Who is there, whether people allow the run, and what it must hold alone.
fn admit(setup: &Setup<'_>) -> Result<(Page, Held), RunError> {
    let (bus, devices) = procedure::identify(setup)?;
    let real = crate::devices::real(&devices);
    let Setup { plan, unit, jobs, answers, .. } = setup;
    let refusals = people::refusals(&Situation { real: &real, unit, plan, jobs: *jobs, answers });
    if !refusals.is_empty() {
        return Err(RunError::Refused(refusals.join("\n  and: ")));
    }
    let held = lock::take(&setup.lock_folder, &lock::resources(setup.rig, &bus, &devices), &setup.folder)?;
    Ok((title_page(setup, devices)?, held))
}

fn title_page(setup: &Setup<'_>, devices: Vec<DeviceRecord>) -> Result<Page, RunError> {
    let (campaign_file, requirements, rig, unit_files) = Page::kept_files(setup.plan, setup.rig, setup.unit);
    let real = devices.iter().any(|device| device.real);
    let unit: Vec<String> = unit_files.iter().map(|file| file.text.clone()).collect();
    let polarity = Basis::new(&devices, &unit, &rig.text, setup.gains);
    if let Some(earlier) = &setup.polarity {
        polarity::accept(earlier, &polarity).map_err(RunError::Refused)?;
    }
    Ok(Page {
        schema: 1,
        campaign: setup.plan.id.clone(),
        title: setup.plan.title.clone(),
        partial: setup.plan.partial,
        campaign_file,
        requirements,
        must_measure: setup.plan.must_measure.clone(),
        rig,
        rig_id: setup.rig.id.clone(),
        unit: setup.unit.id.clone(),
        unit_files,
        seed: setup.seed,
        origin: origin(&devices),
        devices,
        polarity,
        procedures: Page::logs(setup.plan),
        title_page: TitlePage::default(),
        operator: setup.operator.clone(),
        serial_number: setup.serial_number.clone(),
        command_line: setup.command_line.clone(),
        jobs: if real { 1 } else { setup.jobs.unwrap_or_else(processors) },
        started_utc: crate::clock::utc_now(),
    })
}

fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Real, simulated or mixed, from what was proven of each device.
fn origin(devices: &[DeviceRecord]) -> Origin {
    match devices.iter().filter(|d| d.real).count() {
        0 => Origin::Simulated,
        real if real == devices.len() => Origin::Real,
        _ => Origin::Mixed,
    }
}
