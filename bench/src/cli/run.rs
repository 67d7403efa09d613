//! `bench run`: from names to a report.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU16;

use reports::record::{EvidenceState, FileHash, Results};

use super::law::LawArgs;
use super::options::{Asked, Fit};
use super::{output, verdicts};
use crate::campaign::{self, RunError, RunResult, Setup};
use crate::clock::{self, Stopwatch};
use crate::cycle::laws::Laws;
use crate::exit;
use crate::files::answers;
use crate::files::parameters;
use crate::files::shipped;
use crate::judge;
use crate::model::rig::{Rig, Tier};
use crate::people::Answers;
use crate::people::console::{self, Speaker, Writers};
use crate::people::event::{JsonLines, Listener, PlainLines, Progress, RunEvent};
use crate::people::lock;
use crate::people::signals;
use crate::people::underway::Underway;
use crate::plan::{CampaignPlan, Wanted};
use crate::realtime::privileges;
use crate::record::ITSELF;
use crate::record::evidence;
use crate::record::journal::Entry;
use crate::site::unit::Unit;
use crate::site::{Site, WiredSite, site};

mod keep;
mod summary;
mod wire;
mod wire_fault;

#[derive(clap::Args, Debug)]
#[command(after_help = EXIT_CODES)]
pub(super) struct Args {
    #[command(flatten)]
    asked: Asked,
    /// Run folder to create; `runs/<next number>` if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Run only these requirements, procedures, stages, axes or kinds; the report is marked PARTIAL
    #[arg(long, value_name = "ID", num_args = 1..)]
    select: Vec<String>,
    #[command(flatten)]
    fit: Fit,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Number of procedures to run at a time; one per processor if not given, always one with real devices
    #[arg(long, value_name = "N", value_parser = jobs)]
    jobs: Option<usize>,
    /// Rely on the polarity check of this earlier run instead of repeating it
    #[arg(long, value_name = "RUN")]
    polarity: Option<PathBuf>,
    /// Serial number of the unit under test
    #[arg(long, value_name = "S")]
    serial: Option<String>,
    /// Name of the operator
    #[arg(long, value_name = "NAME")]
    operator: Option<String>,
    /// Print events as JSON lines on stdout
    #[arg(long)]
    json: bool,
    /// File with answers to prompts: a table `[answers]` with one key per prompt id
    #[arg(long, value_name = "F")]
    answers: Option<String>,
    /// Answer every prompt with yes; refused for safety prompts where a device is real
    #[arg(long)]
    yes: bool,
    /// Ask nothing and draw no progress bar; the run is refused if a prompt has no answer
    #[arg(long)]
    non_interactive: bool,
    #[command(flatten)]
    laws: LawArgs,
    #[command(flatten)]
    wire: wire::WireArgs,
}

/// What `--help` says behind the options.
const EXIT_CODES: &str = "Exit codes: 0 pass, conditional pass or a screening without shortfall; 1 a \
                          shortfall; 2 a mistake in files or options; 3 inconclusive, incomplete, or a \
                          trip in motion; 4 failure of bench, device or disk; 5 nothing selected; 6 \
                          refused before motion; 129, 130, 143 stopped by a signal. Details: `bench \
                          explain exit-code`.";

/// A number of jobs, from 1.
fn jobs(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) => Err("expected at least 1; leave out `--jobs` for one procedure per processor".to_owned()),
        Ok(count) => Ok(count),
        Err(_) => Err("expected a whole number from 1".to_owned()),
    }
}

pub(super) fn run(args: &Args) -> u8 {
    privileges::keep_for_opening();
    let underway = Underway::default();
    let stop = match ready(args, &underway) {
        Ok(stop) => stop,
        Err(error) => {
            output::error(&format!(
                "a run could not be stopped safely here, so none is started: {error}; raise the limit of \
                 processes (`ulimit -u`)"
            ));
            return exit::BENCH;
        }
    };
    let ready = |prepared: Prepared| judges(&prepared.rig).map(|()| prepared);
    match prepare(args).and_then(ready).and_then(|prepared| signals::begin(&stop).map(|()| prepared)) {
        Ok(prepared) => {
            let code = carry_out(args, &prepared, stop, underway);
            prepared.wire.finish(code)
        }
        Err(code) => code,
    }
}

/// Signals are taken, and nobody waits for the console any more; first of all, so that every later thread inherits it.
fn ready(args: &Args, underway: &Underway) -> std::io::Result<Arc<AtomicU16>> {
    let stop = signals::listen(console::note)?;
    let draws = !args.non_interactive && !args.json;
    let notes: Box<dyn Listener> = match draws.then(|| Progress::new(underway.clone())).flatten() {
        Some(bar) => Box::new(bar),
        None => Box::new(PlainLines::new(console::stderr()?, underway.clone())),
    };
    let stdout = console::stdout()?;
    // How far the run is stands on stderr alone.
    let result: Box<dyn Listener> = match args.json {
        true => Box::new(JsonLines::new(stdout)),
        false => Box::new(PlainLines::new(stdout, Underway::default()).coloured(console::takes_colour())),
    };
    console::open(Writers { result, notes }, &stop)?;
    Ok(stop)
}

/// Starts the threads that judge before anything moves: later nobody could say that there are none to be had. While a
/// session is open there is one, and it gives way to the one that ticks.
fn judges(rig: &Rig) -> Result<(), u8> {
    let pool = match rig.tier {
        Tier::Virtual => rayon::ThreadPoolBuilder::new(),
        Tier::Paced | Tier::Wired | Tier::Hardware => {
            rayon::ThreadPoolBuilder::new().num_threads(1).start_handler(|_| clock::give_way())
        }
    };
    pool.build_global().map_err(|error| {
        output::error(&format!("cannot start threads: {error}; raise the limit of processes (`ulimit -u`)"));
        exit::BENCH
    })
}

struct Prepared {
    rig: Rig,
    unit: Unit,
    built: Vec<Option<Unit>>,
    plan: CampaignPlan,
    gains: controllers::DirectorGains,
    laws: Laws,
    answers: Answers,
    folder: PathBuf,
    wire: wire::RunWire,
}

fn prepare(args: &Args) -> Result<Prepared, u8> {
    let (rig, unit) = args.asked.on.load()?;
    args.wire.check(&rig)?;
    let wanted =
        Wanted { polarity_proven: args.polarity.is_some(), ..args.asked.wanted(&args.select, args.fit) };
    let plan = crate::plan::plan(&wanted, &rig).map_err(|e| output::plan_error(&e, exit::REFUSED))?;
    let built = plan.units(&unit).map_err(|found| output::mistakes(&found))?;
    let gains = parameters::load(&rig).map_err(|found| output::mistakes(&found))?;
    let laws = args.laws.load(&rig)?;
    let answers = answers(args, &plan)?;
    let folder = keep::folder(args.out.as_deref())?;
    let wire = args.wire.open(&rig, args.seed, &folder)?;
    Ok(Prepared { rig, unit, built, plan, gains, laws, answers, folder, wire })
}

/// How the prompts of this plan are answered.
fn answers(args: &Args, plan: &CampaignPlan) -> Result<Answers, u8> {
    let asked: Vec<&str> = plan.questions().into_iter().map(|asked| asked.prompt.id.as_str()).collect();
    let read =
        |name: &String| shipped::read(Path::new(name)).and_then(|source| answers::read(&source, &asked));
    let file = args.answers.as_ref().map(read).transpose().map_err(|found| output::mistakes(&found))?;
    Ok(Answers {
        yes: args.yes,
        non_interactive: args.non_interactive,
        file: file.unwrap_or_default(),
        terminal: std::io::stdin().is_terminal() && std::io::stderr().is_terminal(),
    })
}

fn carry_out(args: &Args, prepared: &Prepared, stop: Arc<AtomicU16>, underway: Underway) -> u8 {
    let watch = Stopwatch::start();
    let site: Box<dyn Site> = match prepared.rig.tier {
        Tier::Wired | Tier::Hardware => Box::new(WiredSite::new(prepared.wire.on_wire())),
        Tier::Virtual | Tier::Paced => site(&prepared.rig, &prepared.unit, &prepared.built),
    };
    let setup = Setup {
        plan: &prepared.plan,
        rig: &prepared.rig,
        unit: &prepared.unit,
        built: prepared.built.clone(),
        gains: &prepared.gains,
        laws: prepared.laws.clone(),
        folder: prepared.folder.clone(),
        seed: args.seed,
        jobs: args.jobs,
        answers: prepared.answers.clone(),
        lock_folder: lock::system_folder(),
        operator: args.operator.clone(),
        serial_number: args.serial.clone(),
        command_line: output::command_line(),
        underway,
        stop,
        polarity: args.polarity.clone(),
        site: &*site,
        judge: judge::judge_log,
        judge_program: judge_program(prepared.rig.tier),
    };
    let mut speaker = Speaker { as_result: args.json };
    match campaign::run(&setup, &mut speaker) {
        Ok(result) => finish(args, &setup, result, &watch, speaker),
        Err(error) => {
            output::error(&error.to_string());
            match error {
                RunError::Refused(_) | RunError::Locked(_) => exit::REFUSED,
                RunError::Output { .. } | RunError::Device(_) | RunError::Threads { .. } => exit::BENCH,
                RunError::Taken(_) => exit::USAGE,
            }
        }
    }
}

/// On a wire axes are held while logs are judged.
fn judge_program(tier: Tier) -> Option<PathBuf> {
    tier.is_wired().then(|| PathBuf::from(ITSELF))
}

/// Folds, writes and prints what the run came to.
fn finish(
    args: &Args,
    setup: &Setup<'_>,
    mut result: RunResult,
    watch: &Stopwatch,
    mut speaker: Speaker,
) -> u8 {
    let folder = &setup.folder;
    let results = keep::results(&result, setup.plan, folder, watch);
    let findings = &results.findings;
    let mut code = exit::worse(result.exit_code, verdicts::exit_code(findings.overall));
    code = exit::worse(code, signals::exit_code(&setup.stop));
    if let Err(message) = keep::results_file(&results, folder, &mut result.journal) {
        output::error(&message);
        code = exit::worse(code, exit::BENCH);
    }
    let unfinished = summary::unfinished(&result);
    let RunResult { mut journal, must_look, held, .. } = result;
    code = exit::of_run(code, !must_look.is_empty());
    let warning = keep::warning(&must_look, held.holds_anything(), folder);
    let noted = match must_look {
        why if why.is_empty() => Ok(()),
        why => journal.write(Entry::MustBeInspected { why }),
    };
    let closed = noted.and_then(|()| journal.close(code));
    // Where somebody must look first, the marks stay, as those of a run that was lost.
    if closed.is_ok() && warning.is_none() {
        held.release();
    }
    code = exit::worse(code, documents(results.clone(), folder, closed));
    let overall = verdicts::overall_word(findings);
    if let Some(text) = warning.as_ref().filter(|_| args.json) {
        speaker.hear(&RunEvent::Notice { text: text.clone() });
    }
    let end = summary::End { results: &results, unfinished: &unfinished, overall: &overall, folder };
    speaker.hear(&end.event(code));
    if !args.json {
        // Two threads write: the bar is gone from the terminal before the last lines come.
        console::drain();
        output::say_parts(end.parts(output::Columns::of_stdout()));
        if let Some(warning) = warning {
            output::say(&warning);
        }
    }
    code
}

/// Writes the evidence index of a closed run, and documents that say how its folder stands; gives what failed of it as an
/// exit code.
fn documents(results: Results, folder: &Path, closed: std::io::Result<Vec<FileHash>>) -> u8 {
    let mut code = exit::PASS;
    let mut failed = |message: &str| {
        output::error(message);
        code = exit::BENCH;
    };
    match closed.map(|files| evidence::write_index(folder, &files)) {
        Ok(Ok(())) => {}
        Ok(Err(error)) => failed(&format!("{}: {error}", folder.join(evidence::INDEX).display())),
        Err(error) => failed(&format!("{}: the journal cannot be closed: {error}", folder.display())),
    }
    let found = evidence::check(folder);
    if found.state != EvidenceState::Intact {
        failed(&format!("{}: evidence {}", folder.display(), found.sentence()));
    }
    if let Err(message) = keep::documents(&results.with_evidence(found), folder) {
        failed(&message);
    }
    code
}
