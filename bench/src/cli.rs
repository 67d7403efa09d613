//! The command line: one file a verb.

use clap::{Parser, Subcommand};

use crate::exit;
use crate::people::console;

mod check;
mod compare;
mod devices;
mod draw;
mod explain;
mod folders;
mod host_controller;
mod identify;
mod import;
mod init;
mod inspect;
mod judge_aside;
mod law;
mod list;
mod merge;
mod monitor;
mod monte_carlo;
mod options;
mod output;
mod plan;
mod record;
mod regress;
mod rejudge;
mod report;
mod results;
mod rtcheck;
mod run;
mod schema;
mod sim;
mod verdicts;

/// Hardware test bench for a two-axis electro-optical director.
#[derive(Debug, Parser)]
#[command(name = "bench", version, about, after_help = "Exit codes: `bench explain exit-code`.")]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Run a campaign or procedures, judge the logs and write the report
    Run(run::Args),
    /// Check campaign, procedures, requirements and rig for mistakes; nothing moves
    Check(check::Args),
    /// Show what a run would do: order of actions, motion envelope and duration
    Plan(plan::Args),
    /// List the shipped campaigns, procedures, requirements, kinds, measurands, rigs and units
    List(list::Args),
    /// Judge a run folder or a single log again and show what differs
    Rejudge(rejudge::Args),
    /// Compare the findings of two runs, or of a run and published values
    Compare(compare::Args),
    /// Compare a candidate controller with a baseline on the same units with the same seeds
    Regress(regress::Args),
    /// Join the shards of a comparison of controllers
    Merge(merge::Args),
    /// Write a simulated unit from what a run found, to rehearse the unit that was tested
    Identify(identify::Args),
    /// Write the report of a run in another format
    Report(report::Args),
    /// Draw units from a family and write their unit files
    Draw(draw::Args),
    /// Pass probabilities, quantiles and sensitivities from stored runs of drawn units
    MonteCarlo(monte_carlo::Args),
    /// Explain a kind, requirement, measurand, rig, unit or topic
    Explain(explain::Args),
    /// Print the JSON Schema of a file type
    Schema(schema::Args),
    /// Open the rig's devices and print their identification; nothing moves
    Devices(devices::Args),
    /// Show the values of one device live, with rate, age and counts of its line; nothing moves
    Monitor(monitor::Args),
    /// Serve a rig's simulated devices to another process, in real time, over real wires
    Sim(sim::Args),
    /// Measure whether this computer keeps the rate of a loop, and what to change; no device is opened
    Rtcheck(rtcheck::Args),
    /// After a lost run: read the positions of the axes, record the inspection and release the rig; nothing moves
    Inspect(inspect::Args),
    /// Create a starter folder whose campaign passes on the simulator
    Init(init::Args),
    /// Convert a log that another tool recorded into a bench log
    Import(import::Args),
    /// Judge one log of a run folder for the process that runs it
    #[command(hide = true)]
    JudgeAside(judge_aside::Args),
    /// Step an external law for the process that runs it
    #[command(hide = true)]
    HostController(host_controller::Args),
}

/// Parses the command line, does what it says, returns the exit code.
pub fn main() -> u8 {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return regress::for_bisect(with_output(usage(&error))),
    };
    let code = match std::panic::catch_unwind(|| dispatch(cli.verb)) {
        Ok(code) => code,
        Err(_) => {
            output::note("internal error: a defect in the bench; please report the text above");
            exit::INTERNAL
        }
    };
    regress::for_bisect(with_output(code))
}

/// Help, or what is wrong with the command line; in colour, unless somebody typed what steers a terminal.
fn usage(error: &clap::Error) -> u8 {
    let steers = |text: std::ffi::OsString| text.to_string_lossy().contains(char::is_control);
    let code = if error.use_stderr() { exit::USAGE } else { exit::PASS };
    if std::env::args_os().any(steers) {
        output::note(error.render().to_string().trim_end());
    } else if let Err(why) = error.print()
        && !error.use_stderr()
        && why.kind() != std::io::ErrorKind::BrokenPipe
    {
        output::error(&format!("standard output: {why}"));
        return exit::BENCH;
    }
    code
}

/// What was said is out, as far as anybody reads it; a result that could not be written is a failure of the output.
fn with_output(code: u8) -> u8 {
    console::drain();
    let Some(why) = console::failure() else { return code };
    output::error(&format!("standard output: {why}; the output is incomplete"));
    console::drain();
    exit::worse(code, exit::BENCH)
}

fn dispatch(verb: Verb) -> u8 {
    match verb {
        Verb::Run(args) => run::run(&args),
        Verb::Check(args) => check::run(&args),
        Verb::Plan(args) => plan::run(&args),
        Verb::List(args) => list::run(&args),
        Verb::Rejudge(args) => rejudge::run(&args),
        Verb::Compare(args) => compare::run(&args),
        Verb::Regress(args) => regress::run(&args),
        Verb::Merge(args) => merge::run(&args),
        Verb::Identify(args) => identify::run(&args),
        Verb::Report(args) => report::run(&args),
        Verb::Draw(args) => draw::run(&args),
        Verb::MonteCarlo(args) => monte_carlo::run(&args),
        Verb::Explain(args) => explain::run(&args),
        Verb::Schema(args) => schema::run(&args),
        Verb::Devices(args) => devices::run(&args),
        Verb::Monitor(args) => monitor::run(&args),
        Verb::Sim(args) => sim::run(&args),
        Verb::Rtcheck(args) => rtcheck::run(&args),
        Verb::Inspect(args) => inspect::run(&args),
        Verb::Init(args) => init::run(&args),
        Verb::Import(args) => import::run(&args),
        Verb::JudgeAside(args) => judge_aside::run(&args),
        Verb::HostController(args) => host_controller::run(&args),
    }
}
