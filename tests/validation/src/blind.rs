//! Units that nobody has tuned anything on: settings drawn from declared distributions, measured by the program as a customer
//! would, and compared with what was drawn.
//!
//! A finding whose truth follows from the settings without a model of its own is scored: its error in its expanded
//! uncertainty, and its verdict beside the verdict on the truth. Everything is a pure function of the number of the unit.

pub mod draw;
pub mod score;
pub mod truth;

use std::path::{Path, PathBuf};
use std::process::Command;

use bench::files::unit::load_unit;
use procedures::requirement::Requirements;
use procedures::verdict::{Verdict, judge};
use reports::record::Results;
use serde::{Deserialize, Serialize};
use sim_devices::unit::UnitSettings;

pub use score::Scored;

/// Kind of the procedures that run into limits on purpose.
const RANGE: &str = "range";

/// What to run on each unit.
pub struct Asked {
    /// The built program.
    pub program: PathBuf,
    /// Name or path of a campaign.
    pub campaign: String,
    /// Ids of procedures or requirements; none for the whole campaign.
    pub select: Vec<String>,
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
    let name = format!("unit-{number}");
    let file = folder.path().join(format!("{name}.toml"));
    std::fs::write(&file, draw::unit(&name, number)).expect("a writable folder");
    let output = Command::new(&asked.program)
        .current_dir(folder.path())
        .args(["run", &asked.campaign, "--unit", &format!("./{name}.toml"), "--seed", &number.to_string()])
        .args(["--non-interactive", "--jobs", "1", "--out", "run"])
        .args(asked.select.iter().flat_map(|id| ["--select", id]))
        .output()
        .expect("the program starts");
    let path = folder.path().join("run/results.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| {
        panic!("{name}: {error}: {}", String::from_utf8_lossy(&output.stderr));
    });
    let results: Results = serde_json::from_str(&text).expect("results as the program writes them");
    let settings = settings(&file);
    of_results(number, &results, &settings, &requirements(folder.path()))
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
    for procedure in &findings.procedures {
        // What looks for the limits ends in an interlock: that is how they hold.
        let rows =
            procedure.points.iter().filter(|_| procedure.kind != RANGE).filter_map(|row| row.reason.as_ref());
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
            });
        }
    }
    let fails = findings.outcomes.iter().filter(|outcome| outcome.before_coverage == Verdict::Fail);
    unit.failed = fails.map(|outcome| outcome.requirement.clone()).collect();
    unit
}
