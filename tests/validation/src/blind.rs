//! Units that nobody has tuned anything on: settings drawn from declared distributions, measured by the program as a customer
//! would, and compared with what was drawn.
//!
//! A finding whose truth follows from the settings without a model of its own is scored: its error in its expanded
//! uncertainty, and its verdict beside the verdict on the truth. Everything is a pure function of the number of the unit.

pub mod draw;
pub mod on_limits;
pub mod score;
pub mod truth;

use std::path::{Path, PathBuf};
use std::process::Command;

use bench::files::unit::load_unit;
use procedures::requirement::{Requirement, Requirements, Rule};
use procedures::verdict::{Judgement, Verdict, judge};
use reports::record::Results;
use serde::{Deserialize, Serialize};
use sim_devices::unit::UnitSettings;

pub use score::{OnLimit, Scored};

/// Kinds of the procedures that run into limits on purpose.
const INTO_LIMITS: [&str; 2] = ["range", "stop"];

/// What to run on each unit.
pub struct Asked {
    /// The built program.
    pub program: PathBuf,
    /// Name or path of a campaign.
    pub campaign: String,
    /// Ids of procedures or requirements; none for the whole campaign.
    pub select: Vec<String>,
    /// Which units.
    pub units: Units,
}

/// Which units are measured. Seed and unit have one number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Units {
    /// Drawn from the declared distributions.
    Drawn,
    /// Drawn, with play, slip, wear and drifts.
    InService,
    /// Drawn, with truths on limits.
    OnLimits,
    /// One shipped unit, by its id: only seeds differ.
    Shipped(String),
}

/// What came of one unit.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Unit {
    /// Its number.
    pub number: u32,
    /// Findings with a truth.
    pub scored: Vec<Scored>,
    /// Interlocks that tripped outside of the points that look for them, and procedures that were refused, in words.
    pub troubles: Vec<String>,
    /// Requirements that fail, in the order of the file.
    pub failed: Vec<String>,
}

/// Draws a unit, runs the campaign on it and scores what it found; the run folder does not stay.
///
/// # Panics
/// Where the program does not start, or leaves no results.
pub fn measured(asked: &Asked, number: u32) -> Unit {
    let folder = tempfile::tempdir().expect("a folder for a run");
    measured_in(asked, number, folder.path())
}

/// The same in a folder that stays: the unit's file, and `run`.
///
/// # Panics
/// As `measured`.
pub fn measured_in(asked: &Asked, number: u32, folder: &Path) -> Unit {
    let name = unit_name(number);
    std::fs::create_dir_all(folder).expect("a writable folder");
    let unit = match &asked.units {
        Units::Drawn => draw::unit(&name, number),
        Units::InService => draw::unit_in_service(&name, number),
        Units::OnLimits => on_limits::unit(&name, number),
        Units::Shipped(base) => {
            format!("schema = 1\nid = \"{name}\"\ntitle = \"Seed {number} of {base}\"\nbase = \"{base}\"\n")
        }
    };
    std::fs::write(folder.join(format!("{name}.toml")), unit).expect("a writable folder");
    let mut program = Command::new(&asked.program);
    program
        .args(["run", &asked.campaign, "--unit", &format!("./{name}.toml"), "--seed", &number.to_string()])
        .args(["--non-interactive", "--jobs", "1", "--out", "run"])
        .args(asked.select.iter().flat_map(|id| ["--select", id]));
    scored(number, folder, program, "run")
}

/// Judges a run that `measured_in` left with the program as it is now, and scores what that finds.
///
/// # Panics
/// Where the folder holds no run of this unit.
pub fn judged_again(program: &Path, number: u32, folder: &Path) -> Unit {
    let mut rejudge = Command::new(program);
    rejudge.args(["rejudge", "run", "--out", "again"]);
    // Where results are written already, nothing is written over.
    let _ = std::fs::remove_dir_all(folder.join("again"));
    scored(number, folder, rejudge, "again")
}

/// Scores a run that `measured_in` left as it is.
///
/// # Panics
/// Where the folder holds no run of this unit.
pub fn scored_again(number: u32, folder: &Path) -> Unit {
    of_folder(number, folder, "run", "")
}

fn unit_name(number: u32) -> String {
    format!("unit-{number}")
}

/// What the program leaves in `results`, beside what is true.
fn scored(number: u32, folder: &Path, mut program: Command, results: &str) -> Unit {
    let output = program.current_dir(folder).output().expect("the program starts");
    of_folder(number, folder, results, &String::from_utf8_lossy(&output.stderr))
}

/// `said`: what the program said where it left no results.
fn of_folder(number: u32, folder: &Path, results: &str, said: &str) -> Unit {
    let name = unit_name(number);
    let path = folder.join(results).join("results.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}: {said}"));
    let results: Results = serde_json::from_str(&text).expect("results as the program writes them");
    let settings = settings(&folder.join(format!("{name}.toml")));
    of_results(number, &results, &settings, &requirements(folder))
}

/// The drawn settings as the program reads them.
fn settings(file: &Path) -> UnitSettings {
    let name = file.to_str().expect("a plain path");
    let unit = load_unit(name).unwrap_or_else(|mistakes| panic!("{mistakes:?}"));
    unit.director().expect("a director").clone()
}

/// Requirements by which the run was judged.
fn requirements(folder: &Path) -> Requirements {
    let text = std::fs::read_to_string(folder.join("run/run.json")).expect("a title page");
    let page: serde_json::Value = serde_json::from_str(&text).expect("a title page");
    let text = page["requirements"]["text"].as_str().expect("the requirements are kept").to_owned();
    Requirements::parse(&procedures::diagnostic::SourceFile::new("requirements.toml", &text))
        .expect("the run was judged by them")
}

fn of_results(number: u32, results: &Results, settings: &UnitSettings, requirements: &Requirements) -> Unit {
    let findings = &results.findings;
    let mut unit = Unit { number, ..Unit::default() };
    // In an earlier build state the unit has other loads than its file says.
    for procedure in findings.procedures.iter().filter(|procedure| procedure.state.is_none()) {
        // What looks for the limits ends in an interlock: that is how they hold.
        let rows = procedure
            .points
            .iter()
            .filter(|_| !INTO_LIMITS.contains(&procedure.kind.as_str()))
            .filter_map(|row| row.reason.as_ref());
        unit.troubles.extend(rows.map(|reason| format!("{}: {reason}", procedure.id)));
        for (index, m) in procedure.measurements.iter().enumerate() {
            let (Some(value), Some(truth)) = (m.value, truth::of(m, settings)) else { continue };
            let exact = procedures::measurement::Measurement { value: Some(truth), u: 0.0, ..m.clone() };
            let judged = procedure.judgements.iter().find(|j| j.measurement == index);
            let on_truth =
                judged.and_then(|j| Some(judge(&exact, index, requirements.get(&j.requirement)?).verdict));
            unit.scored.push(Scored {
                unit: number,
                procedure: procedure.id.clone(),
                measurand: m.measurand.clone(),
                axis: m.axis.clone(),
                point: m.point.clone().unwrap_or_default(),
                value,
                u: m.u,
                dof: m.dof,
                truth,
                verdict: judged.map_or(Verdict::None, |j| j.verdict),
                on_truth: on_truth.unwrap_or(Verdict::None),
                probability_outside: judged.and_then(|j| j.probability_outside),
                on_limit: judged.filter(|j| is_on_limit(j, truth)).and_then(|j| {
                    Some(OnLimit {
                        requirement: j.requirement.clone(),
                        is_guarded: j.guard_band > 0.0,
                        by_simple: judge(m, index, &simple(requirements.get(&j.requirement)?)).verdict,
                    })
                }),
                outside_in_u: judged.map_or(0.0, |j| outside_in_u(j, truth)),
            });
        }
    }
    let fails = findings.outcomes.iter().filter(|outcome| outcome.before_coverage == Verdict::Fail);
    unit.failed = fails.map(|outcome| outcome.requirement.clone()).collect();
    unit
}

/// A requirement with simple acceptance in place of a guard band.
fn simple(requirement: &Requirement) -> Requirement {
    let mut simple = requirement.clone();
    simple.rule = Rule::Simple;
    simple.judges.iter_mut().for_each(|judged| judged.rule = Rule::Simple);
    simple
}

/// A truth this near to a limit, in expanded uncertainties, is on it.
const ON_LIMIT_U: f64 = 0.02;

/// Limits as they were before the guard band; an allowance belongs to them.
fn limits(judged: &Judgement) -> [Option<f64>; 2] {
    let [low, high] = judged.acceptance;
    [low.map(|low| low - judged.guard_band), high.map(|high| high + judged.guard_band)]
}

fn is_on_limit(judged: &Judgement, truth: f64) -> bool {
    let near = |limit: f64| (truth - limit).abs() <= ON_LIMIT_U * judged.expanded_u;
    limits(judged).into_iter().flatten().any(near)
}

fn outside_in_u(judged: &Judgement, truth: f64) -> f64 {
    let [low, high] = limits(judged);
    let beyond = low.map_or(0.0, |low| low - truth).max(high.map_or(0.0, |high| truth - high)).max(0.0);
    if beyond > 0.0 { beyond / judged.expanded_u } else { 0.0 }
}
