//! The campaign runner: procedures to jobs, points to the loop, logs to the judge, all of it to the journal.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Scope;

use controllers::DirectorGains;
use reports::record::Grant;

use crate::cycle::laws::Laws;
use crate::exit;
use crate::judge::{self, JudgedLog};
use crate::model::rig::Rig;
use crate::people::event::{Guarded, Listener, RunEvent};
use crate::people::lock::{Held, LockError};
use crate::people::signals;
use crate::people::underway::Underway;
use crate::people::{Answers, Desk};
use crate::plan::CampaignPlan;
use crate::record::durable::OUTPUT_HELP;
use crate::record::journal::{Entry, Journal};
use crate::record::page::Page;
use crate::site::Site;
use crate::site::unit::Unit;
use held::{Extras, HeldSession, KeptSession};

mod admit;
mod ask;
mod ended;
mod held;
mod kept;
mod point;
mod procedure;
mod procedure_run;
mod schedule;
pub(crate) mod simulated;

pub(crate) use admit::processors;
pub use procedure_run::ProcedureRun;

/// Everything that a run is made from.
pub struct Setup<'a> {
    /// Campaign, planned.
    pub plan: &'a CampaignPlan,
    /// Rig.
    pub rig: &'a Rig,
    /// Simulated unit.
    pub unit: &'a Unit,
    /// Unit in the build state of each stage, where that is not the final one: [`CampaignPlan::units`].
    pub built: Vec<Option<Unit>>,
    /// Gains of the production controllers.
    pub gains: &'a DirectorGains,
    /// External velocity laws; axes without one have the built-in law.
    pub laws: Laws,
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
    /// The points that run now, for whoever shows how far the run is.
    pub underway: Underway,
    /// Set by signals, see [`crate::people::signals`].
    pub stop: Arc<AtomicU16>,
    /// Earlier run whose proof of polarity is relied on.
    pub polarity: Option<PathBuf>,
    /// Where it runs.
    pub site: &'a dyn Site,
    /// Judges a closed log.
    pub judge: judge::JudgeFn,
    /// Program that judges in a process of its own instead, where axes are held meanwhile.
    pub judge_program: Option<PathBuf>,
}

impl Setup<'_> {
    /// The simulated unit as the procedure of an index finds it.
    fn unit_of(&self, index: usize) -> &Unit {
        let stage = self.plan.procedures[index].stage;
        stage.and_then(|stage| self.built.get(stage)?.as_ref()).unwrap_or(self.unit)
    }

    /// The rig as the procedure of an index finds it.
    fn rig_of(&self, index: usize) -> &Rig {
        self.plan.procedures[index].on(self.rig)
    }

    /// Gains as the procedure of an index needs them: those of a velocity loop follow the inertia of the build state.
    fn gains_of(&self, index: usize) -> DirectorGains {
        let mut gains = *self.gains;
        let axes = self.rig.axes.iter().zip(&self.rig_of(index).axes);
        for ((own, built), of_axis) in axes.zip(&mut gains.axes) {
            let ratio = built.limits.inertia_kg_m2 / own.limits.inertia_kg_m2;
            of_axis.velocity_kp_nm_s_per_rad *= ratio;
            of_axis.velocity_ki_nm_per_rad *= ratio;
        }
        gains
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
    /// Why the rig is not given back before somebody has looked: end stops that were met, axes that did not end at
    /// standstill. Empty where the rig was left in order.
    pub must_look: Vec<String>,
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
    /// Another run took the folder first: exit 2.
    #[error("--out {0}: another run is writing to this folder; choose a new one")]
    Taken(String),
    /// A device: exit 4.
    #[error("{0}")]
    Device(#[from] drivers::device::DeviceError),
    /// No thread could be started, and nothing has moved: exit 4.
    #[error("cannot start a thread: {source}; raise the limit of processes (`ulimit -u`)")]
    Threads {
        /// Cause.
        source: std::io::Error,
    },
    /// Refused before motion: exit 6.
    #[error("refused before motion: {0}")]
    Refused(String),
    /// Something that the run needs is held by somebody else, or was left by a run that was lost: exit 6.
    #[error("refused before motion: {0}")]
    Locked(#[from] LockError),
}

fn output(path: &Path, source: std::io::Error) -> RunError {
    RunError::Output { file: path.display().to_string(), source, help: OUTPUT_HELP }
}

/// What the workers share.
struct Shared<'a> {
    setup: &'a Setup<'a>,
    page: Page,
    journal: Mutex<Journal>,
    slots: Mutex<Vec<Option<Finished>>>,
    desk: Mutex<Desk>,
    /// The session of the run, where its site keeps one.
    session: Option<Mutex<Box<dyn KeptSession + 'a>>>,
    /// Whether any device is real.
    real: bool,
    /// Something tripped or failed on a real axis: nothing moves again before somebody has looked.
    halted: AtomicBool,
    /// What it was, for whoever is asked to look.
    why_halted: Mutex<String>,
    /// Why somebody must look at the rig.
    must_look: Mutex<Vec<String>>,
}

type Finished = (ProcedureRun, Option<JudgedLog>);

/// Runs a planned campaign and judges every log as soon as it is closed. Where polarity is not proven, nothing that
/// closes a loop is run; where a stage did not come out in order, nothing of the stages that need it.
///
/// # Errors
/// When the folder cannot be written, the rig's devices cannot be opened, or the run is refused; everything later is
/// in the result.
pub fn run<'a>(setup: &'a Setup<'a>, listener: &mut dyn Listener) -> Result<RunResult, RunError> {
    let extras = Extras::new(setup);
    std::thread::scope(|scope| run_in(scope, setup, &extras, listener))
}

/// Runs the campaign in a scope for the thread of a session, with cases that the plan does not have.
fn run_in<'scope, 'env, 'a: 'scope>(
    scope: &'scope Scope<'scope, 'env>,
    setup: &'a Setup<'a>,
    extras: &'a Extras,
    listener: &mut dyn Listener,
) -> Result<RunResult, RunError> {
    let wires = admit::hold_wires(setup)?;
    let mut session = match setup.site.keeps_session() {
        true => Some(HeldSession::open(scope, setup, extras)?),
        false => None,
    };
    let found = session.as_ref().and_then(HeldSession::identified);
    let (page, held) = admit::admit(setup, found, wires)?;
    let page = Page { grants: session.as_ref().map(HeldSession::grants).unwrap_or_default(), ..page };
    if let Some(faults) = setup.site.wire_faults() {
        faults.begin();
    }
    let unwritten = |e| output(&setup.folder, e);
    let journal = open_journal(setup, &page, claim(&setup.folder)?).map_err(unwritten)?;
    let slots = Mutex::new(setup.plan.procedures.iter().map(|_| None).collect());
    held.arm()?;
    if let Some(session) = &mut session {
        session.arm(&page.devices)?;
    }
    let real = page.devices.iter().any(|device| device.may_be_real);
    let desk = Mutex::new(Desk::new(setup.answers.clone(), real, setup.operator.as_deref()));
    let halted = AtomicBool::new(false);
    let journal = Mutex::new(journal);
    let boxed = |session| -> Mutex<Box<dyn KeptSession + '_>> { Mutex::new(Box::new(session)) };
    let session = session.map(boxed);
    let shared = Shared {
        setup,
        page,
        journal,
        slots,
        desk,
        session,
        real,
        halted,
        why_halted: Mutex::default(),
        must_look: Mutex::default(),
    };
    if let Some(session) = &shared.session {
        shared.write(session.lock().unwrap_or_else(PoisonError::into_inner).take_news());
    }
    let mut listener = Guarded::new(listener, &setup.stop);
    listener.hear(&started(setup));
    without_rights(&shared.page.grants).iter().for_each(|notice| listener.hear(notice));
    let begun = schedule::work(&shared, shared.page.jobs, &mut listener);
    let lost = listener.is_lost();
    shared.end_session();
    let Shared { page, journal, slots, must_look, .. } = shared;
    if let Err(source) = begun {
        return Err(not_begun(source, held, journal).unwrap_or_else(unwritten));
    }
    let mut result = result(setup, page, held, (journal, slots, must_look), lost);
    kept::look_again(setup, &mut result);
    Ok(result)
}

/// No worker could be started and nothing has moved: the rig is given back as it was. Gives the error of the run.
///
/// # Errors
/// When the journal cannot be closed.
fn not_begun(source: std::io::Error, held: Held, journal: Mutex<Journal>) -> std::io::Result<RunError> {
    held.release();
    journal.into_inner().unwrap_or_else(PoisonError::into_inner).close(exit::BENCH)?;
    Ok(RunError::Threads { source })
}

/// What the workers leave behind.
type Left = (Mutex<Journal>, Mutex<Vec<Option<Finished>>>, Mutex<Vec<String>>);

fn result(setup: &Setup<'_>, page: Page, held: Held, left: Left, listener_lost: bool) -> RunResult {
    let (journal, slots, must_look) = left;
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
        must_look: must_look.into_inner().unwrap_or_else(PoisonError::into_inner),
        journal: journal.into_inner().unwrap_or_else(PoisonError::into_inner),
    }
}

/// Makes the run folder this run's own. The journal is the first file in it, and only one of two runs can create it.
fn claim(folder: &Path) -> Result<Journal, RunError> {
    Journal::create(folder).map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => RunError::Taken(folder.display().to_string()),
        _ => output(folder, error),
    })
}

fn open_journal(setup: &Setup<'_>, page: &Page, mut journal: Journal) -> std::io::Result<Journal> {
    let page_file = page.write(&setup.folder)?;
    journal.write(Entry::Opened {
        campaign: page.campaign.clone(),
        rig: page.rig_id.clone(),
        unit: page.unit.clone(),
        seed: setup.seed,
    })?;
    journal.write(kept::entry(page_file))?;
    if let Some(from) = &setup.polarity {
        let from = Some(from.display().to_string());
        journal.write(Entry::Polarity { hash: page.polarity.hash(), proven: true, fault: None, from })?;
    }
    Ok(journal)
}

impl Shared<'_> {
    /// A point tripped or failed, and what it was; `why` somebody must look at the rig before it is given back, if anybody
    /// must.
    fn ended_badly(&self, what: String, why: Vec<String>) {
        *self.why_halted.lock().unwrap_or_else(PoisonError::into_inner) = what;
        // Simulated points that have no session begin in worlds of their own.
        self.halted.fetch_or(self.real || self.session.is_some(), Ordering::Relaxed);
        self.must_look.lock().unwrap_or_else(PoisonError::into_inner).extend(why);
    }

    /// A journal that cannot be written any more shows itself when it is closed.
    fn write(&self, entries: Vec<Entry>) {
        let mut journal = self.journal.lock().unwrap_or_else(PoisonError::into_inner);
        for entry in entries {
            let _ = journal.write(entry);
        }
    }

    /// Closes the session, if there is one, and puts its log on record.
    fn end_session(&self) {
        let Some(session) = &self.session else { return };
        let mut session = session.lock().unwrap_or_else(PoisonError::into_inner);
        let why = session.close();
        self.write(session.take_news());
        self.must_look.lock().unwrap_or_else(PoisonError::into_inner).extend(why);
        for log in session.logs() {
            kept::keep_session(self.setup, &log, &self.journal);
        }
    }

    fn keep(&self, index: usize, finished: Finished) {
        self.slots.lock().unwrap_or_else(PoisonError::into_inner)[index] = Some(finished);
    }
}

/// One line about the rights that the ticking thread does not have; `None` where it has all.
fn without_rights(grants: &[Grant]) -> Option<RunEvent> {
    let missing: Vec<&str> = grants.iter().filter(|g| !g.granted).map(|g| g.what.as_str()).collect();
    let text =
        format!("the loop runs without {}: `bench rtcheck` says why and what to do", missing.join(", "));
    (!missing.is_empty()).then_some(RunEvent::Notice { text })
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
