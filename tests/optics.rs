//! Optics and fine loop of simulated directors, from the procedure file to the verdict.

use std::path::Path;

use bench::files::unit::load_unit;

use crate::bench::{Said, folder, run_in, verdict};

const OPTICS: [&str; 2] = ["OPT-GAIN", "ATM-REJ"];

/// Quick procedures of the shipped files on a unit.
fn run(folder: &Path, unit: &str, names: &[&str]) -> Said {
    let names: Vec<String> = names.iter().map(|name| format!("quick/{name}")).collect();
    let files = names.iter().map(String::as_str);
    let options = ["--unit", unit, "--out", "run", "--non-interactive"];
    let arguments: Vec<&str> = ["run"].into_iter().chain(files).chain(options).collect();
    run_in(folder, &arguments)
}

/// Values of a measurand on an axis in the results of a run, in their order.
fn values(run: &Path, measurand: &str, axis: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(run.join("results.json")).expect("a run folder with results");
    let results: serde_json::Value = serde_json::from_str(&text).expect("results are JSON");
    let mut found = Vec::new();
    collect(&results["findings"], (measurand, axis), &mut found);
    found
}

fn collect(results: &serde_json::Value, wanted: (&str, &str), found: &mut Vec<f64>) {
    match results {
        serde_json::Value::Object(map) => {
            let is = |key: &str, wanted: &str| map.get(key).is_some_and(|v| v == wanted);
            if is("measurand", wanted.0) && is("axis", wanted.1) {
                found.extend(map.get("value").and_then(serde_json::Value::as_f64));
            }
            map.values().for_each(|v| collect(v, wanted, found));
        }
        serde_json::Value::Array(all) => all.iter().for_each(|v| collect(v, wanted, found)),
        _ => {}
    }
}

#[test]
fn the_nominal_optics_are_those_of_the_study_and_reject_what_they_must() {
    let folder = folder();
    let said = run(folder.path(), "nominal", &["optical-gain", "atmosphere", "fine-latency"]);
    let run = folder.path().join("run");
    for id in OPTICS {
        assert_eq!(verdict(&run, id), "pass", "{id}\n{}\n{}", said.out, said.err);
    }
    for (axis, expected) in [("az", 3.5355), ("el", 2.5)] {
        let gains = values(&run, "optical-gain", axis);
        assert!(!gains.is_empty() && gains.iter().all(|g| (g / expected - 1.0).abs() < 0.01), "{gains:?}");
        let crossing = values(&run, "tip-tilt-crossing", axis);
        // 48 1/s and the 8 ms of the unit: 8.9 Hz.
        assert!(crossing.iter().all(|hz| (hz - 8.9).abs() < 0.3) && crossing.len() == 1, "{crossing:?}");
    }
    let latency = values(&run, "tracker-latency", "el");
    assert!(latency.iter().all(|s| (s - 7.5e-3).abs() < 0.2e-3) && latency.len() == 1, "{latency:?}");
}

/// One of the defects of optics and trackers; `defects` runs all of them. The rig declares the delay of a sound unit's
/// messages: that exposures are stated 7.5 ms late must not hide what the loop does not reject.
#[test]
fn trackers_twice_as_late_fail_what_their_file_says_and_nothing_else() {
    let unit = load_unit("tracker-latency").expect("a shipped defect");
    let folder = folder();
    let said = run(folder.path(), "tracker-latency", &["optical-gain", "atmosphere"]);
    for id in OPTICS {
        let found = verdict(&folder.path().join("run"), id);
        let must = unit.must_flip.iter().any(|claim| claim == id);
        let may = unit.may_flip.iter().any(|claim| claim == id);
        assert!(!must || found == "fail", "{id} must fail, is {found}\n{}\n{}", said.out, said.err);
        assert!(must || may || found == "pass", "{id} turns unannounced: {found}");
    }
}

/// The gate of a stage that needs the optics reads what is proven here; alone, the fine loop runs into its stroke.
#[test]
fn an_image_that_is_upside_down_is_a_fault_of_the_sight_and_rejects_nothing() {
    let folder = folder();
    let said = run(folder.path(), "optical-gain-sign", &["optical-gain", "atmosphere"]);
    let run = folder.path().join("run");
    assert_eq!(verdict(&run, "OPT-GAIN"), "fail", "{}\n{}", said.out, said.err);
    assert!(values(&run, "optical-gain", "el").iter().all(|g| (g + 2.5).abs() < 0.05));
    assert!(values(&run, "optical-gain", "az").iter().all(|g| (g - 3.5355).abs() < 0.07));
    assert_eq!(verdict(&run, "ATM-REJ"), "inconclusive", "{}\n{}", said.out, said.err);
}
