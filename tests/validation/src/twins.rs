//! Twins of drawn units: a unit that nobody knows is run and identified, its twin is run, and both runs are compared.
//!
//! Each identified setting is compared with what was drawn, each verdict with that of the twin where the margin is clear, and each
//! curve point by point within the uncertainty of the difference. Unit and twin have different seeds: their noise differs.

use std::path::Path;
use std::process::Command;

use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::files::unit::load_unit;
use bench::identify::{Identified, Rehearsal, Setup, Standing, identify};
use procedures::comparison::{Band, Found, compare};
use reports::record::{Findings, Results};
use serde::{Deserialize, Serialize};
use sim_devices::unit::{CURVES, PARAMETERS, UnitSettings};

use crate::blind::{Asked, measured_in};
use crate::shipped::director;

/// A setting that was identified, beside what was drawn. SI.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Setting {
    /// Key, or table and key with an elevation for a curve.
    pub key: String,
    /// What the twin has.
    pub value: f64,
    /// Its expanded uncertainty.
    pub expanded_u: f64,
    /// What was drawn.
    pub truth: f64,
    /// Whether the findings determine it; else the base has a say in it.
    pub is_measured: bool,
}

impl Setting {
    /// Error in expanded uncertainties; 0 for what was counted and is equal.
    pub fn error_in_u(&self) -> f64 {
        let error = self.value - self.truth;
        if error == 0.0 { 0.0 } else { error / self.expanded_u }
    }

    /// Whether the interval holds the truth.
    pub fn is_covered(&self) -> bool {
        self.error_in_u().abs() <= 1.0
    }
}

/// A verdict of the unit beside that of the twin.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Verdict {
    /// Id of the requirement.
    pub requirement: String,
    /// Verdict on the unit, then on the twin, in words.
    pub verdicts: [String; 2],
    /// Smallest distance of the unit's values from the limit, in their expanded uncertainties.
    pub margin_in_u: f64,
}

/// A curve of both runs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Curve {
    /// Procedure, picture and curve.
    pub name: String,
    /// Points that both have.
    pub points: usize,
    /// Those of them within the band of the difference.
    pub inside: usize,
}

/// What came of one unit.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Twin {
    /// Number of the unit.
    pub number: u32,
    /// Settings, then curves over elevation.
    pub settings: Vec<Setting>,
    /// Verdicts whose margin is clear.
    pub verdicts: Vec<Verdict>,
    /// Curves with an uncertainty.
    pub curves: Vec<Curve>,
    /// Findings that contradict each other, and remarks.
    pub said: Vec<String>,
}

/// A verdict must be the same where every value is farther from its limit than this, in its expanded uncertainty.
pub const CLEAR_U: f64 = 3.0;
/// The twin's seed is that of the unit and this.
const OTHER_SEED: u32 = 100_000;

/// Draws a unit, runs and identifies it, and runs its twin unless only the settings are wanted. All files go into `folder`; a run
/// that it holds already is not repeated.
///
/// # Panics
/// Where the program does not start, or leaves no results.
pub fn twin(asked: &Asked, number: u32, folder: &Path, with_second_run: bool) -> Twin {
    if !folder.join("run/results.json").exists() {
        measured_in(asked, number, folder);
    }
    let run = findings(&folder.join("run"));
    let found = identified(&run, &folder.join("run"));
    // Nothing is written over; the file of an earlier call is out of date.
    let _ = std::fs::remove_file(folder.join("twin.toml"));
    let seen = program(asked, folder, &["identify", "run", "--out", "twin.toml"]);
    assert!(folder.join("twin.toml").exists(), "unit {number}: {seen}");
    let written = settings_of(&folder.join("twin.toml"));
    let truth = settings_of(&folder.join(format!("unit-{number}.toml")));
    let mut twin = Twin { number, settings: settings(&found, &written, &truth), ..Twin::default() };
    twin.said = [found.contradictions, found.remarks].concat();
    if with_second_run {
        let seed = (number + OTHER_SEED).to_string();
        let mut words =
            vec!["run", asked.campaign.as_str(), "--unit", "./twin.toml", "--seed", seed.as_str()];
        words.extend(["--non-interactive", "--jobs", "1", "--out", "again"]);
        words.extend(asked.select.iter().flat_map(|id| ["--select", id.as_str()]));
        if !folder.join("again/results.json").exists() {
            program(asked, folder, &words);
        }
        let again = findings(&folder.join("again"));
        twin.verdicts = verdicts(&run, &again);
        twin.curves = curves(&run, &again);
    }
    twin
}

/// What the program says on stderr.
fn program(asked: &Asked, folder: &Path, words: &[&str]) -> String {
    let output = Command::new(&asked.program).args(words).current_dir(folder).output();
    String::from_utf8_lossy(&output.expect("the program starts").stderr).into_owned()
}

fn findings(run: &Path) -> Findings {
    let path = run.join("results.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let results: Results = serde_json::from_str(&text).expect("results as the program writes them");
    results.findings
}

fn settings_of(file: &Path) -> UnitSettings {
    let unit =
        load_unit(file.to_str().expect("a plain path")).unwrap_or_else(|mistakes| panic!("{mistakes:?}"));
    unit.director().expect("a director").clone()
}

/// The same as the program does with a run on the shipped rig.
fn identified(run: &Findings, folder: &Path) -> Identified {
    let source = shipped::find(Folder::Rigs, "sim", None).expect("a shipped rig");
    let rig = read_rig(source).expect("a shipped rig");
    let base = load_unit("nominal").expect("a shipped unit");
    let mut found = identify(run, &Setup::of(&rig).expect("a director"), &director("nominal"));
    Rehearsal { findings: run, run: folder, rig: &rig, base: &base, tell: &|_| {} }.identify(&mut found);
    found
}

/// Identified settings as the file has them, beside the drawn ones.
fn settings(found: &Identified, written: &UnitSettings, drawn: &UnitSettings) -> Vec<Setting> {
    let scalars = found.settings.iter().map(|own| {
        let parameter = PARAMETERS.iter().find(|p| p.key == own.key).expect("a setting");
        let truth = parameter.get(drawn);
        let value = parameter.get(written);
        Setting {
            key: own.key.to_owned(),
            value,
            expanded_u: own.value.expanded_u_si(),
            truth: alike(own.key, truth + by_zero_rad(own.key, written, drawn), value),
            is_measured: own.standing != Standing::InPart,
        }
    });
    let curves = found.curves.iter().flat_map(|own| {
        let curve = CURVES.iter().find(|c| c.table == own.table && c.key == own.key).expect("a curve");
        let at = move |unit: &UnitSettings, elevation_rad: f64| {
            let structure = if own.table.starts_with("az") { &unit.az_structure } else { &unit.el_structure };
            structure.interpolate(curve.get(unit), elevation_rad)
        };
        own.points.iter().map(move |(elevation_rad, value)| Setting {
            key: format!("{}.{} at {:.0} deg", own.table, own.key, elevation_rad.to_degrees()),
            value: at(written, *elevation_rad),
            expanded_u: value.expanded_u_si(),
            truth: at(drawn, *elevation_rad),
            is_measured: true,
        })
    });
    scalars.chain(curves).collect()
}

/// Cogging is found over the angle that the encoder shows: what another zero of the encoder shifts its phase by.
fn by_zero_rad(key: &str, written: &UnitSettings, drawn: &UnitSettings) -> f64 {
    let axis = usize::from(key.starts_with("el."));
    let line = match key.split_once('.') {
        Some((_, "cogging-phase")) => 1.0,
        Some((_, "cogging-second-phase")) => 2.0,
        _ => return 0.0,
    };
    let [drawn, written] = [drawn.axis(axis), written.axis(axis)];
    line * drawn.cogging_orders_per_rev * (drawn.encoder_zero_rad - written.encoder_zero_rad)
}

/// A phase is the same by whole turns; of unbalances only the magnitude is found.
fn alike(key: &str, truth: f64, value: f64) -> f64 {
    use std::f64::consts::TAU;
    match key {
        _ if key.ends_with("-phase") => truth + TAU * ((value - truth) / TAU).round(),
        "az.unbalance" | "el.unbalance" => truth.abs().copysign(value),
        _ => truth,
    }
}

/// Verdicts of requirements of which every judged value of the unit is clear of its limit.
fn verdicts(unit: &Findings, twin: &Findings) -> Vec<Verdict> {
    let verdict = |requirement: &str| {
        let margins =
            unit.procedures.iter().flat_map(|p| &p.judgements).filter(|j| j.requirement == requirement);
        let in_u = margins.filter_map(|j| Some(j.margin?.abs() / j.expanded_u.max(f64::MIN_POSITIVE)));
        let margin_in_u = in_u.fold(f64::INFINITY, f64::min);
        let word = |of: &Findings| Some(format!("{:?}", of.outcome(requirement)?.before_coverage));
        let verdicts = [word(unit)?, word(twin)?];
        let decided = ["Pass", "Fail"].contains(&verdicts[0].as_str());
        (margin_in_u > CLEAR_U && margin_in_u.is_finite() && decided).then(|| Verdict {
            requirement: requirement.to_owned(),
            verdicts,
            margin_in_u,
        })
    };
    unit.outcomes.iter().filter_map(|outcome| verdict(&outcome.requirement)).collect()
}

/// Points of measured curves within the uncertainty of the difference, as `bench compare` tells them.
fn curves(unit: &Findings, twin: &Findings) -> Vec<Curve> {
    let compared = compare(&found(unit), &found(twin), None);
    let measured = compared.curves.into_iter().filter(|curve| curve.band == Band::Uncertainty);
    measured
        .map(|curve| Curve {
            name: format!("{} {} {}", curve.procedure, curve.picture, curve.curve),
            points: curve.points,
            inside: curve.inside,
        })
        .collect()
}

fn found(findings: &Findings) -> Vec<Found<'_>> {
    let procedures = findings.procedures.iter();
    procedures.map(|p| Found { procedure: &p.id, measurements: &p.measurements, plots: &p.plots }).collect()
}
