//! Every defect against what it must and may turn, by runs of this program: as a customer would see them.
//!
//! `cargo run --release -p bench --example measured_flips [-- [--whole] [--campaign NAME] [--program PATH] [DEFECT…]]`: by default
//! each
//! defect runs what verifies the requirements that it must or may turn; with `--whole` the whole campaign, so that what it
//! turns beside them shows, too. Ends with 1 where a claim does not hold.

#![allow(clippy::print_stdout, reason = "it is a program that prints a table")]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, ExitCode};

use bench::files::shipped::{self, Folder};
use bench::files::unit::Unit;
use serde_json::Value;

/// What ran instead of everything where nothing is to be measured: the first motion trips.
const ANY_MOTION: &str = "FRC-AZ";

struct Asked {
    whole: bool,
    campaign: String,
    /// A built program; without one cargo builds and runs this checkout's.
    program: Option<String>,
    defects: Vec<String>,
}

/// Verdicts by requirement, and what refused or ended procedures.
struct Seen {
    verdicts: BTreeMap<String, String>,
    reasons: Vec<String>,
}

fn main() -> ExitCode {
    let asked = asked();
    let named = |unit: &Unit| asked.defects.is_empty() || asked.defects.contains(&unit.id);
    let units =
        shipped::all(Folder::Units).map(|f| Unit::load(f.stem()).expect("the shipped units are good"));
    let is_defect = |unit: &Unit| !unit.must_flip.is_empty() || unit.must_trip.is_some();
    let defects: Vec<Unit> = units.filter(|u| is_defect(u) && named(u)).collect();
    let nominal = run(&asked, "nominal", &[]).verdicts;
    let short: Vec<_> = nominal.iter().filter(|(_, verdict)| *verdict == "fail").collect();
    println!("{}: {} requirements on nominal, failed: {short:?}", asked.campaign, nominal.len());
    println!("| defect | must | turned | broken claims |\n| --- | --- | --- | --- |");
    let mut broken = 0;
    for defect in &defects {
        let seen = run(&asked, &defect.id, &selection(defect, asked.whole));
        let turned = turned(&nominal, &seen.verdicts);
        let claims = claims(defect, &turned, &seen);
        broken += claims.len();
        let must =
            defect.must_trip.as_ref().map_or(defect.must_flip.join(", "), |trip| format!("trips {trip}"));
        let told: Vec<String> = turned.iter().map(|(id, verdict)| format!("{id} {verdict}")).collect();
        println!("| {} | {must} | {} | {} |", defect.id, told.join(", "), claims.join("; "));
    }
    println!("{} defects, {broken} broken claims", defects.len());
    if broken == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn asked() -> Asked {
    let mut asked = Asked { whole: false, campaign: "quick".to_owned(), program: None, defects: Vec::new() };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--whole" => asked.whole = true,
            "--campaign" => asked.campaign = words.next().unwrap_or(asked.campaign),
            "--program" => asked.program = words.next(),
            _ => asked.defects.push(word),
        }
    }
    asked
}

fn selection(defect: &Unit, whole: bool) -> Vec<String> {
    match (whole, &defect.must_trip) {
        (true, _) => Vec::new(),
        (false, Some(_)) => vec![ANY_MOTION.to_owned()],
        (false, None) => defect.must_flip.iter().chain(&defect.may_flip).cloned().collect(),
    }
}

/// Runs a campaign on a unit; its folder does not stay.
fn run(asked: &Asked, unit: &str, select: &[String]) -> Seen {
    let folder = std::env::temp_dir().join(format!("measured-flips-{}-{unit}", std::process::id()));
    let mut command = Command::new(asked.program.as_deref().unwrap_or("cargo"));
    if asked.program.is_none() {
        command.args(["run", "--quiet", "--release", "-p", "bench", "--"]);
    }
    command.args(["run", &asked.campaign, "--unit", unit]);
    command.arg("--non-interactive").arg("--out").arg(&folder);
    if !select.is_empty() {
        command.arg("--select").args(select);
    }
    let output = command.output().expect("the program starts");
    let code = output.status.code();
    assert!(
        matches!(code, Some(0 | 1 | 3)),
        "{unit}: ended with {code:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    let seen = read(&folder.join("results.json"));
    let _ = std::fs::remove_dir_all(&folder);
    seen
}

fn read(results: &Path) -> Seen {
    let text = std::fs::read_to_string(results).expect("a run writes its results");
    let all: Value = serde_json::from_str(&text).expect("its results are JSON");
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let findings = &all["findings"];
    let verdicts = list(&findings["outcomes"]);
    let verdicts = verdicts.iter().map(|o| (text(&o["requirement"]), text(&o["verdict"])));
    let mut reasons = Vec::new();
    for procedure in list(&findings["procedures"]) {
        reasons.extend(list(&procedure["remarks"]).iter().map(text));
        reasons.extend(list(&procedure["points"]).iter().map(|point| text(&point["reason"])));
    }
    Seen { verdicts: verdicts.filter(|(_, verdict)| verdict != "none").collect(), reasons }
}

/// Requirements whose verdict is another than the nominal unit's.
fn turned(nominal: &BTreeMap<String, String>, seen: &BTreeMap<String, String>) -> Vec<(String, String)> {
    let other = |(id, verdict): &(&String, &String)| nominal.get(*id).is_some_and(|was| was != *verdict);
    seen.iter().filter(other).map(|(id, verdict)| (id.clone(), verdict.clone())).collect()
}

/// What the defect's file says and the run does not show.
fn claims(defect: &Unit, turned: &[(String, String)], seen: &Seen) -> Vec<String> {
    if let Some(trip) = &defect.must_trip {
        let starts = [format!("{trip}:"), format!("tripped: {trip}:")];
        let tripped = seen.reasons.iter().any(|reason| starts.iter().any(|start| reason.starts_with(start)));
        return if tripped { Vec::new() } else { vec![format!("must trip {trip} and does not")] };
    }
    let failed =
        |id: &&String| turned.iter().any(|(turned, verdict)| turned == *id && verdict.ends_with("fail"));
    let missing =
        defect.must_flip.iter().filter(|id| !failed(id)).map(|id| format!("{id} must fail and does not"));
    let claimed = |id: &String| defect.must_flip.contains(id) || defect.may_flip.contains(id);
    let stray = turned.iter().filter(|(id, _)| !claimed(id));
    missing.chain(stray.map(|(id, verdict)| format!("{id} turns to {verdict} unannounced"))).collect()
}
