//! `bench regress`: a candidate controller beside a baseline, on the same units with the same seeds.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU16;

use procedures::diagnostic::Diagnostic;
use procedures::regression::{ArmRecord, Baseline, Criteria, Look, Shard, pair, propose};
use reports::regression::Regression;

use super::folders;
use super::law::{AskedLaw, LawArgs, asked_law};
use super::options::load_rig;
use super::output;
use crate::campaign::processors;
use crate::cycle::laws::Laws;
use crate::exit;
use crate::files::shipped::{self, Folder, sort};
use crate::model::rig::{Rig, Tier};
use crate::people::signals;
use crate::plan::{self, CampaignPlan, Wanted};
use crate::record::durable;
use crate::regression::population::Units;
use crate::regression::{Arm, ArmFiles, Asked, Course, Records, planned_record, run_arms, store};

mod sequential;

#[derive(clap::Args, Debug)]
#[command(after_help = EXIT_CODES)]
pub(super) struct Args {
    /// Campaigns or procedures that both controllers run through: shipped names or paths; `regression` if none
    names: Vec<String>,
    /// Parameters of the baseline: a shipped name or a path; or `baseline.json` of an earlier comparison, which is not run again
    #[arg(long, value_name = "F", default_value = "director")]
    baseline: String,
    /// Parameters of the candidate: a shipped name or a path
    #[arg(long, value_name = "F", required_unless_present = "propose")]
    candidate: Option<String>,
    /// State files that change the units with the baseline alone
    #[arg(long, value_name = "F", num_args = 1..)]
    baseline_state: Vec<String>,
    /// State files that change the units with the candidate alone, e.g. a firmware with more delay
    #[arg(long, value_name = "F", num_args = 1..)]
    candidate_state: Vec<String>,
    /// Close a velocity loop with the law of a shared library in the baseline's arm alone; may be repeated
    #[arg(long, value_name = "AXIS=FILE@SHA256", value_parser = asked_law)]
    baseline_law: Vec<AskedLaw>,
    /// Close a velocity loop with the law of a shared library in the candidate's arm alone; may be repeated
    #[arg(long, value_name = "AXIS=FILE@SHA256", value_parser = asked_law)]
    candidate_law: Vec<AskedLaw>,
    /// Step external laws in processes of their own: one that crashes is then a trip
    #[arg(long)]
    host_laws: bool,
    /// Criteria: a file, or the name of shipped ones; `regress.toml` beside you if there is one, otherwise those of the campaign
    #[arg(long, value_name = "F")]
    criteria: Option<String>,
    /// Write a criteria file with margins from the baseline's distances to its limits, and compare nothing
    #[arg(long, value_name = "FILE", conflicts_with_all = ["candidate", "candidate_state", "candidate_law", "criteria", "out", "shard", "sequential", "bisect", "keep", "json"])]
    propose: Option<PathBuf>,
    #[command(flatten)]
    over: Over,
    /// Look at 5, 10, 20, 40 units and stop as soon as all blocking criteria are decided
    #[arg(long, conflicts_with = "shard")]
    sequential: bool,
    /// Exit codes for `git bisect run`: 0 good, 1 worse, 125 not decided or not run
    #[arg(long, conflicts_with = "shard")]
    bisect: bool,
    /// Folder for the comparison; `regressions/<next number>` if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Keep the logs of all runs in the folder
    #[arg(long)]
    keep: bool,
    /// Print the comparison as JSON
    #[arg(long)]
    json: bool,
}

/// Over which units, and how.
#[derive(clap::Args, Debug)]
struct Over {
    /// Rig, which is rehearsed in virtual time: a shipped name or a path
    #[arg(long, default_value = "sim")]
    rig: String,
    /// Units: shipped names or paths, each a replicate; units of `--family` if none
    #[arg(long, value_name = "F", num_args = 1..)]
    unit: Vec<String>,
    /// Family that units are drawn from: a shipped name or a path
    #[arg(long, value_name = "F", default_value = "production", conflicts_with = "unit")]
    family: String,
    /// Number of units drawn from the family; --sequential draws as many as its looks need
    #[arg(long, value_name = "N", default_value_t = 20, conflicts_with = "unit", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    units: u32,
    /// Seed of the draws
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "unit")]
    family_seed: u64,
    /// Seed of the first run; every further run has the next one
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Runs of each unit; they are averaged and do not count as more units
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds_per_unit: u32,
    /// Runs at a time; one per processor if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Run a part of the units, e.g. `2/8`; `bench merge` joins all parts
    #[arg(long, value_name = "K/N", value_parser = shard)]
    shard: Option<Shard>,
}

/// What `--help` says behind the options.
const EXIT_CODES: &str = "Exit codes: 0 identical, equivalent or better; 1 worse; 2 a mistake in files or options; 3 \
                          inconclusive; 4 failure of bench or disk; 129, 130, 143 stopped by a signal. With --bisect: 0; 1; 125 \
                          for all others but signals.";

/// A shard as it is written on the command line.
fn shard(text: &str) -> Result<Shard, String> {
    let parsed = text.split_once('/').and_then(|(number, parts)| {
        let shard = Shard { number: number.parse().ok()?, parts: parts.parse().ok()? };
        (shard.number >= 1 && shard.number <= shard.parts).then_some(shard)
    });
    parsed.ok_or_else(|| "expected K/N with K from 1 to N, e.g. 2/8".to_owned())
}

/// Where comparisons lie that nobody gave a folder.
pub(super) const FOLDERS: &str = "regressions";

/// Exit code of `git bisect run` for a commit that cannot be told.
const CANNOT_TELL: u8 = 125;

/// The exit code of the program in the words of `git bisect`, where its command line asks for them: every other code below 128, of
/// a mistake or of an internal error, would be a bad commit there.
pub(super) fn for_bisect(found: u8) -> u8 {
    let mut arguments = std::env::args_os().skip(1);
    let asks = arguments.next().is_some_and(|verb| verb == "regress") && arguments.any(|a| a == "--bisect");
    match found {
        exit::PASS | exit::FAIL | 128.. => found,
        _ if asks => CANNOT_TELL,
        _ => found,
    }
}

pub(super) fn run(args: &Args) -> u8 {
    match signals::listen(output::note) {
        Ok(stop) => regress(args, stop).unwrap_or_else(|code| code),
        Err(error) => {
            output::error(&format!("signals cannot be taken: {error}"));
            exit::BENCH
        }
    }
}

/// Everything read and checked, before the first run.
struct Prepared {
    rig: Rig,
    plan: CampaignPlan,
    units: Units,
    criteria: Option<Criteria>,
    baseline: BaselineArm,
    candidate: Option<Arm>,
}

/// The baseline: to be run, or as it was measured.
enum BaselineArm {
    ToRun(Box<Arm>),
    Stored(Box<ArmRecord>),
}

fn regress(args: &Args, stop: Arc<AtomicU16>) -> Result<u8, u8> {
    let prepared = prepare(args).map_err(|found| output::mistakes(&found))?;
    share_processors(jobs(args));
    let Some(folder) = &args.propose else { return compare(args, &prepared, stop) };
    let scratch = tempfile_beside(folder)?;
    signals::begin(&stop)?;
    let asked = asked(args, &prepared, scratch.clone(), stop);
    let found = propose_from(&asked, &prepared, folder);
    let _ = std::fs::remove_dir_all(&scratch);
    found
}

fn prepare(args: &Args) -> Result<Prepared, Vec<Diagnostic>> {
    let rig = load_rig(&args.over.rig)?.rehearsed_on(Tier::Virtual, &crate::files::profile::simulated());
    let names = if args.names.is_empty() { vec!["regression".to_owned()] } else { args.names.clone() };
    // Signs are those of the simulated units: a check in every run would cost a fifth of the time.
    let wanted = Wanted { names, polarity_proven: true, ..Wanted::default() };
    let plan = plan::plan(&wanted, &rig).map_err(plan::PlanError::diagnostics)?;
    let criteria = match args.propose {
        Some(_) => None,
        None => Some(Criteria::parse(&criteria_file(args, &plan)?, &plan.requirements)?),
    };
    let units = units(&args.over)?;
    if let Some(criteria) = &criteria {
        check_criteria(criteria, &plan)?;
    }
    check_shard(args.over.shard, &units)?;
    let baseline = if args.baseline.ends_with(".json") {
        if !args.baseline_state.is_empty() || !args.baseline_law.is_empty() {
            let message = format!(
                "{}: a stored baseline is not run again: states and laws of it have no effect",
                args.baseline
            );
            let help = "leave out `--baseline-state` and `--baseline-law`, or give the baseline's parameters";
            return Err(vec![Diagnostic::new(message).help(help)]);
        }
        let record =
            store::read_arm(Path::new(&args.baseline)).map_err(|text| vec![Diagnostic::new(text)])?;
        BaselineArm::Stored(Box::new(record))
    } else {
        let laws = laws(&args.baseline_law, args.host_laws, &rig)?;
        let files = ArmFiles { parameters: &args.baseline, states: &args.baseline_state, laws };
        BaselineArm::ToRun(Box::new(Arm::read(&files, &rig)?))
    };
    let candidate = match &args.candidate {
        Some(parameters) => {
            let laws = laws(&args.candidate_law, args.host_laws, &rig)?;
            Some(Arm::read(&ArmFiles { parameters, states: &args.candidate_state, laws }, &rig)?)
        }
        None => None,
    };
    Ok(Prepared { candidate, rig, plan, units, criteria, baseline })
}

/// Every criterion is measured by a procedure of the campaign.
fn check_criteria(criteria: &Criteria, plan: &CampaignPlan) -> Result<(), Vec<Diagnostic>> {
    let is_measured =
        |measurand: &str| plan.procedures.iter().any(|p| p.procedure.yields.contains(&measurand));
    let unmeasured = criteria.all.iter().filter(|criterion| !is_measured(&criterion.measurand));
    let told = |criterion: &procedures::regression::Criterion| {
        let message =
            format!("criterion {}: no procedure of campaign `{}` measures it", criterion.name(), plan.id);
        Diagnostic::new(message).help("add a procedure to the campaign, or remove the criterion")
    };
    let mistakes: Vec<Diagnostic> = unmeasured.map(told).collect();
    if mistakes.is_empty() { Ok(()) } else { Err(mistakes) }
}

/// No shard is empty.
fn check_shard(shard: Option<Shard>, units: &Units) -> Result<(), Vec<Diagnostic>> {
    match shard {
        Some(Shard { parts, .. }) if parts > units.count() => {
            let message = format!("--shard: {parts} parts of {} units; some would be empty", units.count());
            Err(vec![Diagnostic::new(message).help("ask for at most as many parts as there are units")])
        }
        _ => Ok(()),
    }
}

/// External laws of an arm, loaded and checked.
fn laws(asked: &[AskedLaw], host_laws: bool, rig: &Rig) -> Result<Laws, Vec<Diagnostic>> {
    LawArgs { law: asked.to_vec(), host_laws }.read(rig).map_err(|why| vec![Diagnostic::new(why)])
}

/// The criteria file that somebody names, the one that lies there, or the one of the campaign.
fn criteria_file(
    args: &Args,
    plan: &CampaignPlan,
) -> Result<procedures::diagnostic::SourceFile, Vec<Diagnostic>> {
    const HERE: &str = "regress.toml";
    let find = |name: &str| {
        shipped::find(Folder::Criteria, name, None).and_then(|source| sort::expect(source, Folder::Criteria))
    };
    match &args.criteria {
        Some(name) => find(name),
        None if Path::new(HERE).exists() => find(HERE),
        None => find(&plan.id).map_err(|_| {
            let message = format!(
                "no criteria: `{HERE}` is not here, and none are shipped for campaign `{}`",
                plan.id
            );
            let help = "give them with `--criteria FILE`; `bench regress --propose FILE` writes one with a margin for every \
                        requirement that the baseline is measured by";
            vec![Diagnostic::new(message).help(help)]
        }),
    }
}

fn units(over: &Over) -> Result<Units, Vec<Diagnostic>> {
    if over.unit.is_empty() {
        return Units::drawn(&over.family, over.family_seed, over.units);
    }
    Units::named(&over.unit)
}

/// Runs at a time.
fn jobs(args: &Args) -> usize {
    args.over.jobs.map_or_else(processors, usize::from)
}

/// Leaves the analysis of all runs together the processors that no run needs, and one: a pool of as many threads as processors looks
/// for work that is not there, which takes a tenth of the time from the runs.
fn share_processors(jobs: usize) {
    let threads = processors().saturating_sub(jobs) + 1;
    // Fails where the program has a pool already, which is as good.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
}

fn asked<'a>(args: &Args, prepared: &'a Prepared, folder: PathBuf, stop: Arc<AtomicU16>) -> Asked<'a> {
    Asked {
        plan: &prepared.plan,
        rig: &prepared.rig,
        units: &prepared.units,
        seed: args.over.seed,
        seeds_per_unit: args.over.seeds_per_unit,
        shard: args.over.shard.unwrap_or(Shard::WHOLE),
        jobs: jobs(args),
        folder,
        keep: args.keep,
        stop,
        tell: &tell,
    }
}

/// How far it is, at most twenty times.
fn tell(done: usize, of: usize) {
    if done == of || done.is_multiple_of(of.div_ceil(20)) {
        output::note(&format!("{done} of {of} runs"));
    }
}

/// A hidden folder for logs beside a file that is to be written.
fn tempfile_beside(file: &Path) -> Result<PathBuf, u8> {
    if file.exists() {
        output::error(&format!("--propose {}: the file exists; choose a new one", file.display()));
        return Err(exit::USAGE);
    }
    let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = parent.join(format!(".regress-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map(|()| folder).map_err(|error| {
        output::error(&format!("{}: {error}; {}", file.display(), durable::OUTPUT_HELP));
        exit::BENCH
    })
}

/// Runs the baseline and writes criteria with margins from what it measured.
fn propose_from(asked: &Asked<'_>, prepared: &Prepared, file: &Path) -> Result<u8, u8> {
    let record = match &prepared.baseline {
        BaselineArm::Stored(record) => (**record).clone(),
        BaselineArm::ToRun(arm) => {
            let course = Course { from: 1, to: prepared.units.count() };
            records(asked, std::slice::from_ref(&**arm), course)?.remove(0)
        }
    };
    let text = propose(&prepared.plan.requirements, &Baseline::of_record(&record));
    durable::write(file, text.as_bytes()).map_err(|error| {
        output::error(&format!("{}: {error}; {}", file.display(), durable::OUTPUT_HELP));
        exit::BENCH
    })?;
    output::say(&format!("{}: criteria with proposed margins; read and adjust them", file.display()));
    Ok(exit::PASS)
}

fn records(asked: &Asked<'_>, arms: &[Arm], course: Course) -> Result<Vec<ArmRecord>, u8> {
    run_arms(asked, arms, course).map_err(|stopped| {
        output::error(&stopped.to_string());
        stopped.exit_code()
    })
}

fn compare(args: &Args, prepared: &Prepared, stop: Arc<AtomicU16>) -> Result<u8, u8> {
    let (Some(criteria), Some(candidate)) = (&prepared.criteria, &prepared.candidate) else {
        return Err(exit::USAGE);
    };
    let course = Course { from: 1, to: prepared.units.count() };
    let probe = asked(args, prepared, PathBuf::new(), Arc::clone(&stop));
    check_stored(&probe, prepared, candidate, course)?;
    let folder = folders::chosen(args.out.as_deref(), FOLDERS)?;
    signals::begin(&stop)?;
    let asked = Asked { folder: folder.join("runs"), ..probe };
    if args.sequential {
        return sequential::compare(args, prepared, &asked, &folder);
    }
    let found = both(&asked, &prepared.baseline, candidate, course)?;
    if !args.keep {
        let _ = std::fs::remove_dir(&asked.folder);
    }
    kept(store::write_records(&folder, &found, criteria))?;
    if asked.shard != Shard::WHOLE {
        let Shard { number, parts } = asked.shard;
        output::say(&format!(
            "{}: shard {number} of {parts}; when all are there: bench merge FOLDER… --out DIR",
            folder.display()
        ));
        return Ok(exit::PASS);
    }
    let regression = decided(criteria, &found, Look::Single)?;
    finish(&folder, &regression, args.json)
}

/// A stored baseline was run through the same as the candidate will be: told before anything runs.
fn check_stored(asked: &Asked<'_>, prepared: &Prepared, candidate: &Arm, course: Course) -> Result<(), u8> {
    let (BaselineArm::Stored(stored), Some(criteria)) = (&prepared.baseline, &prepared.criteria) else {
        return Ok(());
    };
    let whole = |record: ArmRecord| ArmRecord { shard: Shard::WHOLE, replicates: Vec::new(), ..record };
    let planned = planned_record(asked, candidate, course).map_err(|stopped| {
        output::error(&stopped.to_string());
        stopped.exit_code()
    })?;
    pair(criteria, &whole((**stored).clone()), &whole(planned)).map(|_| ()).map_err(|errors| told(&errors))
}

/// Records of both arms on the units of a course.
fn both(asked: &Asked<'_>, baseline: &BaselineArm, candidate: &Arm, course: Course) -> Result<Records, u8> {
    match baseline {
        BaselineArm::Stored(stored) => {
            let candidate = records(asked, std::slice::from_ref(candidate), course)?.remove(0);
            // A shard of the stored record: merged, they are the record again.
            let mut baseline = ArmRecord { shard: asked.shard, ..(**stored).clone() };
            baseline.replicates.retain(|replicate| asked.shard.holds(replicate.unit));
            Ok(Records { baseline, candidate })
        }
        BaselineArm::ToRun(arm) => {
            let mut found = records(asked, &[(**arm).clone(), candidate.clone()], course)?;
            let candidate = found.remove(1);
            Ok(Records { baseline: found.remove(0), candidate })
        }
    }
}

/// Tells everything that keeps arms from being compared.
fn told(errors: &[impl ToString]) -> u8 {
    let found: Vec<Diagnostic> = errors.iter().map(|error| Diagnostic::new(error.to_string())).collect();
    output::mistakes(&found)
}

/// What two records come to; mistakes on stderr.
pub(super) fn decided(criteria: &Criteria, found: &Records, look: Look) -> Result<Regression, u8> {
    Regression::new(criteria, &found.baseline, &found.candidate, look).map_err(|errors| told(&errors))
}

/// Writes and prints a decision; gives its exit code.
pub(super) fn finish(folder: &Path, regression: &Regression, json: bool) -> Result<u8, u8> {
    kept(store::write_decision(folder, regression))?;
    if json {
        output::say(reports::regression::json(regression).trim_end());
    } else {
        output::say(&reports::regression::text(regression));
        output::say(&format!("{}: regression.md, junit.xml, regression.json", folder.display()));
    }
    Ok(regression.call().exit_code())
}

pub(super) fn kept(written: Result<(), String>) -> Result<(), u8> {
    written.map_err(|message| {
        output::error(&message);
        exit::BENCH
    })
}
