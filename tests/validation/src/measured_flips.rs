//! Runs of the program on defects, and what they turn.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use bench::files::shipped::{self, Folder};
use bench::files::unit::load_unit;
use bench::site::unit::Unit;
use procedures::verdict::Verdict;
use serde_json::Value;

use crate::expected::{broken_claims, turned, word};

/// What runs instead of everything where nothing is to be measured: the first motion trips.
const ANY_MOTION: &str = "FRC-AZ";

/// Head of a table of [`Row::line`]s.
pub const HEAD: &str = "| defect | must | turned | broken claims |\n| --- | --- | --- | --- |";

/// What to run.
pub struct Asked {
    /// The whole campaign, not only what verifies the requirements that a defect may turn.
    pub whole: bool,
    /// Name or path of a campaign.
    pub campaign: String,
    /// The built program.
    pub program: PathBuf,
    /// Names of shipped units; none for every defect.
    pub defects: Vec<String>,
}

/// A defect, and what its run showed.
pub struct Row {
    defect: Unit,
    turned: Vec<(String, Verdict)>,
    /// What its file says and the run does not show.
    pub broken: Vec<String>,
}

impl Row {
    /// A line of a Markdown table.
    pub fn line(&self) -> String {
        let must = &self.defect.must_trip;
        let must = must.as_ref().map_or(self.defect.must_flip.join(", "), |trip| format!("trips {trip}"));
        let told = self.turned.iter().map(|(id, verdict)| format!("{id} {}", word(*verdict)));
        let told: Vec<String> = told.collect();
        format!("| {} | {must} | {} | {} |", self.defect.id, told.join(", "), self.broken.join("; "))
    }
}

/// Verdicts of what was judged, by requirement, and what refused or ended procedures.
struct Seen {
    verdicts: Vec<(String, Verdict)>,
    reasons: Vec<String>,
}

/// Runs the nominal unit, then every defect that is asked for, and tells each row in the order of the shipped files. Gives
/// their number.
///
/// As many runs at a time as there are processors, each on one of them: selections are short, with little to share out.
///
/// # Panics
/// Where the nominal unit fails a requirement, and where a run does not come to a result.
pub fn measured(asked: &Asked, mut tell: impl FnMut(&Row)) -> usize {
    let nominal = run(asked, "nominal", &[], None).verdicts;
    let failed: Vec<_> = nominal.iter().filter(|(_, verdict)| *verdict == Verdict::Fail).collect();
    assert!(failed.is_empty(), "the nominal unit fails {failed:?}");
    let defects = defects(&asked.defects);
    let next = AtomicUsize::new(0);
    let (done, rows) = mpsc::channel();
    let work = |done: mpsc::Sender<(usize, Row)>| {
        let waiting = || {
            let k = next.fetch_add(1, Ordering::Relaxed);
            Some((k, defects.get(k)?))
        };
        for (k, defect) in std::iter::from_fn(waiting) {
            // Nobody listens any longer only where the other end has panicked.
            let _ = done.send((k, held(asked, defect, &nominal)));
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            let work = &work;
            let done = done.clone();
            scope.spawn(move || work(done));
        }
        drop(done);
        let mut waiting = BTreeMap::new();
        let mut told = 0;
        for (k, row) in rows {
            waiting.insert(k, row);
            while let Some(row) = waiting.remove(&told) {
                tell(&row);
                told += 1;
            }
        }
    });
    defects.len()
}

/// Shipped directors that claim something, of these names if there are any.
fn defects(names: &[String]) -> Vec<Unit> {
    let units = shipped::all(Folder::Units).map(|f| load_unit(f.stem()).expect("the shipped units are good"));
    let named = |unit: &Unit| names.is_empty() || names.contains(&unit.id);
    units.filter(|unit| unit.is_defect() && unit.director().is_some() && named(unit)).collect()
}

/// Runs a defect and compares what it turned with what its file says.
fn held(asked: &Asked, defect: &Unit, nominal: &[(String, Verdict)]) -> Row {
    let select: Vec<&str> = match (asked.whole, &defect.must_trip) {
        (true, _) => Vec::new(),
        (false, Some(_)) => vec![ANY_MOTION],
        (false, None) => defect.must_flip.iter().chain(&defect.may_flip).map(String::as_str).collect(),
    };
    let seen = run(asked, &defect.id, &select, Some(1));
    let turned = turned(&borrowed(nominal), &borrowed(&seen.verdicts));
    let broken = match &defect.must_trip {
        Some(trip) if tripped(trip, &seen.reasons) => Vec::new(),
        Some(trip) => vec![format!("must trip {trip} and does not")],
        None => broken_claims(defect, &turned),
    };
    let turned = turned.into_iter().map(|(id, verdict)| (id.to_owned(), verdict)).collect();
    Row { defect: defect.clone(), turned, broken }
}

fn borrowed(verdicts: &[(String, Verdict)]) -> Vec<(&str, Verdict)> {
    verdicts.iter().map(|(id, verdict)| (id.as_str(), *verdict)).collect()
}

fn tripped(trip: &str, reasons: &[String]) -> bool {
    let starts = [format!("{trip}:"), format!("tripped: {trip}:")];
    reasons.iter().any(|reason| starts.iter().any(|start| reason.starts_with(start)))
}

/// Runs a campaign on a unit, this many procedures at a time; its folder does not stay.
fn run(asked: &Asked, unit: &str, select: &[&str], jobs: Option<usize>) -> Seen {
    let folder = std::env::temp_dir().join(format!("measured-flips-{}-{unit}", std::process::id()));
    let mut command = Command::new(&asked.program);
    command.args(["run", &asked.campaign, "--unit", unit]);
    command.arg("--non-interactive").arg("--out").arg(&folder);
    if let Some(jobs) = jobs {
        command.args(["--jobs", &jobs.to_string()]);
    }
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
    let verdict = |o: &Value| serde_json::from_value(o["before_coverage"].clone()).expect("a verdict");
    let outcomes = list(&findings["outcomes"]);
    let verdicts = outcomes.iter().map(|o| (text(&o["requirement"]), verdict(o)));
    let verdicts = verdicts.filter(|(_, verdict)| *verdict != Verdict::None).collect();
    let mut reasons = Vec::new();
    for procedure in list(&findings["procedures"]) {
        reasons.extend(list(&procedure["remarks"]).iter().map(text));
        reasons.extend(list(&procedure["points"]).iter().map(|point| text(&point["reason"])));
    }
    Seen { verdicts, reasons }
}
