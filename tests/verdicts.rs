//! Verdicts of the quick campaign: the nominal unit passes, a planted defect fails, and only where it must.

use std::path::Path;

use crate::bench::{folder, outcomes, run_in, verdict};

const MUST_MEASURE: [&str; 13] = [
    "FRC-AZ", "FRC-EL", "UNB-AZ", "UNB-EL", "SPR-AZ", "SPR-EL", "HOLD-EL", "COG-AZ", "COG-EL", "FSM-BW",
    "FSM-STR", "FSM-MODE", "FSM-CH",
];

/// One run of the whole campaign for both: it takes longer than everything else here.
#[test]
fn nominal_unit_passes_the_quick_campaign_and_a_missing_log_takes_the_pass_from_everything_it_serves() {
    let folder = folder();
    let said = run_in(folder.path(), &["run", "--out", "run", "--non-interactive"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    // A first look is no acceptance, and says so everywhere.
    let headline = "no shortfall found; ";
    assert!(said.out.contains("SCREENING") && said.out.contains(headline), "{}", said.out);
    let run = folder.path().join("run");
    for file in ["report.html", "report.md"] {
        let text = std::fs::read_to_string(run.join(file)).expect("a report");
        assert!(text.contains("SCREENING") && text.contains(headline), "{file}");
    }
    let junit = std::fs::read_to_string(run.join("junit.xml")).expect("a report");
    assert!(junit.contains("screened: not measured: velocity-gain-margin on"), "one elevation is not all");
    assert!(!junit.contains("<failure ") && !junit.contains("<error "), "a run that ends with 0 has none");
    for id in MUST_MEASURE {
        assert_eq!(verdict(&run, id), "pass", "{id}\n{}", said.out);
    }
    insta::assert_snapshot!("quick_looks_at_in_part", looked_at_in_part(&run));
    for file in [
        "run.json",
        "journal.jsonl",
        "results.json",
        "report.html",
        "junit.xml",
        "results.csv",
        "requirements.csv",
    ] {
        assert!(run.join(file).is_file(), "{file} is missing");
    }
    std::fs::remove_file(run.join("AZ-BREAKAWAY.mcap")).expect("a log");
    let said = run_in(folder.path(), &["rejudge", "run", "--out", "again"]);
    assert_eq!(said.code, 65, "it was there when the run ended: {}\n{}", said.out, said.err);
    assert!(said.err.contains("AZ-BREAKAWAY.mcap: no log"), "{}", said.err);
    let again = folder.path().join("again");
    assert_eq!(verdict(&again, "FRC-AZ"), "inconclusive");
    assert_eq!(verdict(&again, "FRC-EL"), "pass");
    let junit = std::fs::read_to_string(again.join("junit.xml")).expect("a report");
    let case = junit.split("name=\"FRC-AZ ").nth(1).and_then(|t| t.split("</testcase>").next());
    assert!(
        case.is_some_and(|case| case.contains("<error type=\"inconclusive\"")),
        "red beats silent: {junit}"
    );
}

/// The headline of a run and the requirements that it covers in part only, a line each.
fn looked_at_in_part(run: &Path) -> String {
    let outcomes = outcomes(run);
    let screened = outcomes.iter().filter(|o| o["verdict"] == "screened");
    let ids: Vec<&str> = screened.filter_map(|o| o["requirement"].as_str()).collect();
    let report = std::fs::read_to_string(run.join("report.md")).expect("a report");
    let headline = report.lines().find(|line| line.contains("SCREENING")).expect("a headline");
    format!("{headline}\n{}", ids.join("\n"))
}

/// What measures these requirements, instead of everything.
#[test]
#[ignore = "takes the better part of a minute; `.ci/run` runs it after the others"]
fn azimuth_retainer_fails_frc_az_and_only_what_its_friction_costs() {
    let folder = folder();
    let options = ["run", "--unit", "azimuth-retainer", "--out", "run", "--non-interactive", "--select"];
    let said = run_in(folder.path(), &[&options[..], &MUST_MEASURE].concat());
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    let run = folder.path().join("run");
    assert_eq!(verdict(&run, "FRC-AZ"), "fail", "{}", said.out);
    for id in MUST_MEASURE.into_iter().filter(|id| *id != "FRC-AZ") {
        assert_eq!(verdict(&run, id), "pass", "{id}\n{}", said.out);
    }
}

#[test]
#[ignore = "the whole of `quick` on another unit; `.ci/run` runs it after the others"]
fn as_measured_unit_passes_what_quick_measures() {
    let folder = folder();
    let said = run_in(folder.path(), &["run", "--unit", "as-measured", "--out", "run", "--non-interactive"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
}
