//! All runs of a regression, several at a time, in an order that no number of workers changes.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU16, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use controllers::DirectorGains;
use procedures::diagnostic::Diagnostic;
use procedures::regression::{ARM_SCHEMA, ArmRecord, Controller, Program, Replicate, Scenario, Shard};
use reports::record::LawRecord;

use super::population::Units;
use super::replicate::{Job, RunFailure};
use crate::cycle::laws::Laws;
use crate::exit;
use crate::files::parameters;
use crate::files::unit::{in_state, load_state};
use crate::model::rig::Rig;
use crate::people::signals;
use crate::plan::CampaignPlan;
use crate::record::journal::sha256;
use crate::record::page::Basis;
use crate::site::unit::{BuildState, Unit};

/// What an arm is made of, as it is asked for.
#[derive(Clone, Debug)]
pub struct ArmFiles<'a> {
    /// Parameters of the controllers: a shipped name or a path.
    pub parameters: &'a str,
    /// States that are laid over each unit in this arm alone.
    pub states: &'a [String],
    /// External velocity laws, loaded.
    pub laws: Laws,
}

/// One arm, read.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Gains of its controllers.
    pub gains: DirectorGains,
    /// External velocity laws; axes without one have the built-in law.
    pub laws: Laws,
    states: Vec<BuildState>,
    controller: Controller,
}

impl Arm {
    /// Reads an arm's files for a rig.
    ///
    /// # Errors
    /// All mistakes of the files.
    pub fn read(files: &ArmFiles<'_>, rig: &Rig) -> Result<Self, Vec<Diagnostic>> {
        let gains = parameters::load_named(files.parameters, None, rig)?;
        let states: Vec<BuildState> =
            files.states.iter().map(|name| load_state(name, None)).collect::<Result<_, _>>()?;
        let digest = |state: &BuildState| format!("{} {}", state.id, sha256(state.source.text.as_bytes()));
        let controller = Controller {
            parameters: files.parameters.to_owned(),
            sha256: Basis::new(&[], &[], "", &gains, &files.laws.records()).parameters_sha256,
            states: states.iter().map(digest).collect(),
            laws: files.laws.records().iter().map(law).collect(),
        };
        Ok(Self { gains, laws: files.laws.clone(), states, controller })
    }

    /// The unit as this arm finds it.
    pub(super) fn laid_over(&self, unit: &Unit) -> Result<Unit, Vec<Diagnostic>> {
        self.states.iter().try_fold(unit.clone(), |unit, state| in_state(&unit, state))
    }
}

/// `az: supplier-pi 1.2 (3f5a…)`.
fn law(record: &LawRecord) -> String {
    format!("{}: {} {} ({})", record.axis, record.name, record.version, record.sha256)
}

/// What all runs have in common.
pub struct Asked<'a> {
    /// The campaign, planned.
    pub plan: &'a CampaignPlan,
    /// Rig.
    pub rig: &'a Rig,
    /// The units.
    pub units: &'a Units,
    /// Seed of the first unit's first run.
    pub seed: u64,
    /// Runs of each unit.
    pub seeds_per_unit: u32,
    /// Which units.
    pub shard: Shard,
    /// Runs at a time.
    pub jobs: usize,
    /// Folder for run folders; each is removed when its run was read, unless they are kept.
    pub folder: PathBuf,
    /// Whether run folders stay.
    pub keep: bool,
    /// Set by signals.
    pub stop: Arc<AtomicU16>,
    /// Told how many runs are done, of how many.
    pub tell: &'a (dyn Fn(usize, usize) + Sync),
}

/// Units of which runs were already made and those to come.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    /// First unit to run.
    pub from: u32,
    /// Last unit to run, which is the number of units from then on.
    pub to: u32,
}

/// Why there are no records.
#[derive(Debug, thiserror::Error)]
pub enum Stopped {
    /// A run failed for a reason that is not the controller's.
    #[error(transparent)]
    Run(#[from] RunFailure),
    /// A file that cannot be read or written.
    #[error("{0}")]
    Io(String),
}

impl Stopped {
    /// What it means for the program's exit.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Run(failure) => failure.exit_code,
            Self::Io(_) => exit::BENCH,
        }
    }
}

/// One run to make.
struct Planned<'a> {
    arm: &'a Arm,
    /// Which arm, from 0.
    index: usize,
    number: u32,
    seed: u64,
}

/// Runs arms on the units of a course; gives a record of each arm, in their order. The runs of a unit come one after another, so that a
/// unit that was begun is soon complete.
///
/// # Errors
/// The first failure in the order of the runs.
pub fn run_arms(asked: &Asked<'_>, arms: &[Arm], course: Course) -> Result<Vec<ArmRecord>, Stopped> {
    let program =
        super::this_program().map_err(|error| Stopped::Io(format!("the program's own file: {error}")))?;
    let planned = planned(asked, arms, course);
    let replicates = work(asked, &planned)?;
    let mut records: Vec<ArmRecord> = arms.iter().map(|arm| empty(asked, arm, &program, course)).collect();
    for (planned, replicate) in planned.iter().zip(replicates) {
        records[planned.index].replicates.push(replicate);
    }
    Ok(records)
}

fn planned<'a>(asked: &Asked<'_>, arms: &'a [Arm], course: Course) -> Vec<Planned<'a>> {
    let mut all = Vec::new();
    for number in (course.from..=course.to).filter(|number| asked.shard.holds(*number)) {
        for repeat in 0..asked.seeds_per_unit {
            let place = u64::from(number - 1) * u64::from(asked.seeds_per_unit) + u64::from(repeat);
            let seed = asked.seed.wrapping_add(place);
            all.extend(arms.iter().enumerate().map(|(index, arm)| Planned { arm, index, number, seed }));
        }
    }
    all
}

/// Record of an arm before its first run: what a stored record must agree with.
///
/// # Errors
/// When the program's own file cannot be read.
pub fn planned_record(asked: &Asked<'_>, arm: &Arm, course: Course) -> Result<ArmRecord, Stopped> {
    let program =
        super::this_program().map_err(|error| Stopped::Io(format!("the program's own file: {error}")))?;
    Ok(empty(asked, arm, &program, course))
}

fn empty(asked: &Asked<'_>, arm: &Arm, program: &Program, course: Course) -> ArmRecord {
    ArmRecord {
        schema: ARM_SCHEMA.to_owned(),
        program: program.clone(),
        controller: arm.controller.clone(),
        scenario: Scenario {
            campaign: asked.plan.id.clone(),
            campaign_sha256: campaign_digest(asked.plan),
            rig: asked.rig.id.clone(),
            rig_sha256: sha256(asked.rig.source.text.as_bytes()),
            population: asked.units.described(course.to),
            seed: asked.seed,
            seeds_per_unit: asked.seeds_per_unit,
        },
        shard: asked.shard,
        look: None,
        replicates: Vec::new(),
    }
}

/// Digest of a campaign, its procedures and its requirements.
fn campaign_digest(plan: &CampaignPlan) -> String {
    let own = plan.source.iter().map(|source| source.text.as_str());
    let procedures = plan.procedures.iter().map(|planned| planned.procedure.source.text.as_str());
    let texts: Vec<&str> = own.chain([plan.requirements_source.text.as_str()]).chain(procedures).collect();
    sha256(texts.join("\0").as_bytes())
}

type Slot = Option<Result<Replicate, RunFailure>>;

/// Makes all runs; their order is that of the plan, whoever was first.
fn work(asked: &Asked<'_>, planned: &[Planned<'_>]) -> Result<Vec<Replicate>, Stopped> {
    let next = AtomicUsize::new(0);
    let done = AtomicUsize::new(0);
    let failed = AtomicBool::new(false);
    let slots: Mutex<Vec<Slot>> = Mutex::new(planned.iter().map(|_| None).collect());
    let worker = || {
        while !failed.load(Ordering::Relaxed) && signals::exit_code(&asked.stop) == exit::PASS {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(one) = planned.get(index) else { break };
            let found = make(asked, one);
            failed.fetch_or(found.is_err(), Ordering::Relaxed);
            slots.lock().unwrap_or_else(PoisonError::into_inner)[index] = Some(found);
            (asked.tell)(done.fetch_add(1, Ordering::Relaxed) + 1, planned.len());
        }
    };
    let begun = std::thread::scope(|scope| {
        let spawn = |number: usize| {
            std::thread::Builder::new().name(format!("regress-{number}")).spawn_scoped(scope, worker)
        };
        (0..asked.jobs.clamp(1, planned.len().max(1)))
            .map(spawn)
            .collect::<std::io::Result<Vec<_>>>()
            .map(|_| ())
    });
    begun.map_err(|error| Stopped::Io(format!("cannot start a thread: {error}; ask for fewer --jobs")))?;
    let slots = slots.into_inner().unwrap_or_else(PoisonError::into_inner);
    let stopped = signals::exit_code(&asked.stop);
    let mut all = Vec::with_capacity(planned.len());
    for (slot, planned) in slots.into_iter().zip(planned) {
        let missing = || RunFailure {
            unit: planned.number,
            seed: planned.seed,
            why: "stopped before it began".to_owned(),
            exit_code: if stopped == exit::PASS { exit::INTERNAL } else { stopped },
        };
        match slot {
            Some(found) => all.push(found?),
            // Runs are begun in order: a failed one stands before all that were not begun, and was found above.
            None => return Err(missing().into()),
        }
    }
    Ok(all)
}

fn make(asked: &Asked<'_>, planned: &Planned<'_>) -> Result<Replicate, RunFailure> {
    let Planned { arm, index, number, seed } = *planned;
    let failure = |why: String, exit_code: u8| RunFailure { unit: number, seed, why, exit_code };
    let unit = asked.units.unit(number).map_err(|found| {
        failure(found.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"), exit::USAGE)
    })?;
    let folder =
        asked.folder.join(format!("unit-{number}-seed-{seed}-{}", ["baseline", "candidate"][index % 2]));
    let job = Job {
        plan: asked.plan,
        rig: asked.rig,
        arm,
        unit: &unit,
        number,
        unit_sha256: asked.units.digest(number, &unit),
        seed,
        folder: &folder,
        stop: &asked.stop,
    };
    let found = job.run()?;
    if !asked.keep {
        remove(&folder).map_err(|why| failure(why, exit::BENCH))?;
    }
    Ok(found)
}

fn remove(folder: &Path) -> Result<(), String> {
    std::fs::remove_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))
}
