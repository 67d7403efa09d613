//! The campaign runner: procedures to jobs, points to the loop, logs to the judge, all of it to the journal.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU16, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};

use controllers::DirectorGains;
use reports::record::{DeviceRecord, Origin, TitlePage};

use crate::event::{Listener, RunEvent};
use crate::exit;
use crate::files::rig::Rig;
use crate::files::unit::Unit;
use crate::journal::{Entry, Journal};
use crate::judge::JudgedLog;
use crate::page::Page;
use crate::plan::CampaignPlan;
use crate::signals;

mod procedure;

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
    /// Procedures at a time.
    pub jobs: usize,
    /// Who runs it.
    pub operator: Option<String>,
    /// Serial number of the unit under test.
    pub serial_number: Option<String>,
    /// How the program was called.
    pub command_line: String,
    /// Set by signals, see [`crate::signals`].
    pub stop: Arc<AtomicU16>,
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
    /// Exit code so far (without the verdict).
    pub exit_code: u8,
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
    order: Vec<usize>,
    next: AtomicUsize,
    journal: Mutex<Journal>,
    events: Sender<RunEvent>,
}

/// Runs a planned campaign and judges every log as soon as it is closed.
///
/// # Errors
/// When the folder cannot be written or the rig's devices cannot be opened; everything later is in the result.
pub fn run(setup: &Setup<'_>, listener: &mut dyn Listener) -> Result<RunResult, RunError> {
    let page = title_page(setup)?;
    page.write(&setup.folder).map_err(|e| output(&setup.folder, e))?;
    let mut journal = Journal::create(&setup.folder).map_err(|e| output(&setup.folder, e))?;
    let opened = Entry::Opened {
        campaign: page.campaign.clone(),
        rig: page.rig_id.clone(),
        unit: page.unit.clone(),
        seed: setup.seed,
    };
    journal.write(opened).map_err(|e| output(&setup.folder, e))?;
    let (events, heard) = channel();
    let shared = Shared {
        setup,
        order: longest_first(setup.plan),
        next: AtomicUsize::new(0),
        journal: Mutex::new(journal),
        events,
    };
    listener.hear(&started(setup));
    let (results, journal) = work(shared, &heard, listener);
    let simulated_s = results.iter().map(|(run, _)| run.loop_s).sum();
    // A signal after the last point still ends the run as stopped.
    let signal = signals::exit_code(&setup.stop);
    let code = results.iter().fold(signal, |code, (run, _)| exit::worse(code, run.exit_code));
    let (runs, judged) = results.into_iter().unzip();
    Ok(RunResult { page, judged, runs, simulated_s, exit_code: code, journal })
}

type Finished = (ProcedureRun, Option<JudgedLog>);

fn work(
    shared: Shared<'_>,
    heard: &Receiver<RunEvent>,
    listener: &mut dyn Listener,
) -> (Vec<Finished>, Journal) {
    let count = shared.order.len();
    let slots: Mutex<Vec<Option<Finished>>> = Mutex::new((0..count).map(|_| None).collect());
    let Shared { setup, order, next, journal, events } = shared;
    std::thread::scope(|scope| {
        for _ in 0..setup.jobs.clamp(1, count.max(1)) {
            let (events, slots, order, next, journal) = (events.clone(), &slots, &order, &next, &journal);
            scope.spawn(move || {
                while let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    // A defect in one procedure must not take the others, the journal and the results with it.
                    let run = AssertUnwindSafe(|| procedure::run_and_judge(setup, index, journal, &events));
                    let finished = catch_unwind(run).unwrap_or_else(|_| (ProcedureRun::crashed(), None));
                    if let Ok(mut slots) = slots.lock() {
                        slots[index] = Some(finished);
                    }
                }
            });
        }
        drop(events);
        for event in heard {
            listener.hear(&event);
        }
    });
    let results: Vec<Finished> = slots
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
        .into_iter()
        .map(|slot| slot.unwrap_or_else(|| (ProcedureRun::crashed(), None)))
        .collect();
    let journal = journal.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    (results, journal)
}

/// Longest procedure first: the last one to finish decides how long a run takes.
fn longest_first(plan: &CampaignPlan) -> Vec<usize> {
    let mut order: Vec<usize> = (0..plan.procedures.len()).collect();
    order.sort_by(|&a, &b| {
        plan.procedures[b].planned_s().total_cmp(&plan.procedures[a].planned_s()).then(a.cmp(&b))
    });
    order
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

fn title_page(setup: &Setup<'_>) -> Result<Page, RunError> {
    let (campaign_file, requirements, rig, unit_files) = Page::kept_files(setup.plan, setup.rig, setup.unit);
    let devices = procedure::identify(setup)?;
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
        procedures: Page::logs(setup.plan),
        title_page: TitlePage::default(),
        operator: setup.operator.clone(),
        serial_number: setup.serial_number.clone(),
        command_line: setup.command_line.clone(),
        jobs: setup.jobs,
        started_utc: crate::clock::utc_now(),
    })
}

/// Real, simulated or mixed, from what was proven of each device.
fn origin(devices: &[DeviceRecord]) -> Origin {
    match devices.iter().filter(|d| d.real).count() {
        0 => Origin::Simulated,
        real if real == devices.len() => Origin::Real,
        _ => Origin::Mixed,
    }
}
