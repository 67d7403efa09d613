//! Latency of simulated units, from the procedure file to the verdict: what was put into the unit comes out, lag and hold
//! apart, and a defect of latency fails LAT-RT.

use std::path::Path;

use crate::bench::{folder, run_in, verdict, write};

/// A campaign of one procedure, its points replaced.
fn measured(unit: &str, points: &str, folder: &Path) -> serde_json::Value {
    let text = include_str!("../procedures/quick/az-latency.toml");
    write(folder, "requirements.toml", include_str!("../procedures/requirements.toml"));
    write(folder, "az-latency.toml", &text.replace("[\"fit\", \"onset\"]", points));
    let campaign = "schema = 1\nid = \"mine\"\ntitle = \"Latency\"\nrequirements = \"requirements.toml\"\nclaim = \"screening\"\nmust-measure = []\n\n[[procedure]]\nfile = \"az-latency.toml\"\n";
    write(folder, "mine.toml", campaign);
    let said = run_in(folder, &["run", "mine.toml", "--unit", unit, "--out", "run", "--non-interactive"]);
    assert!(said.code <= 1, "exit {}\n{}\n{}", said.code, said.out, said.err);
    let text = std::fs::read_to_string(folder.join("run/results.json")).expect("results of the run");
    serde_json::from_str(&text).expect("results are JSON")
}

/// The value of a measurand, wherever the results hold it, s.
fn value_s(results: &serde_json::Value, measurand: &str) -> Option<f64> {
    match results {
        serde_json::Value::Object(map) if map.get("measurand").is_some_and(|m| m == measurand) => {
            map.get("value")?.as_f64()
        }
        serde_json::Value::Object(map) => map.values().find_map(|v| value_s(v, measurand)),
        serde_json::Value::Array(all) => all.iter().find_map(|v| value_s(v, measurand)),
        _ => None,
    }
}

fn near(results: &serde_json::Value, measurand: &str, expected_s: f64, within_s: f64) {
    let found = value_s(results, measurand);
    assert!(
        found.is_some_and(|s| (s - expected_s).abs() < within_s),
        "{measurand}: {found:?} s, expected {expected_s} s within {within_s} s"
    );
}

#[test]
fn the_round_trip_of_the_unit_as_measured_is_found_and_split() {
    let folder = folder();
    let results = measured("as-measured", "[\"fit\", \"onset\", \"echo\", \"probe\"]", folder.path());
    // 1.1 ms and a tick out, 1.5 ms back; with the lag of 159 us the 3 ms of the study.
    near(&results, "transport-round-trip", 2.85e-3, 20e-6);
    near(&results, "current-lag", 159e-6, 10e-6);
    near(&results, "transport-out", 1.35e-3, 20e-6);
    near(&results, "transport-back", 1.5e-3, 20e-6);
    near(&results, "transport-by-onset", 2.85e-3, 75e-6);
    near(&results, "echo-delay", 250e-6, 1e-6);
    assert_eq!(verdict(&folder.path().join("run"), "LAT-RT"), "pass");
}

#[test]
fn one_and_a_quarter_milliseconds_more_fail_the_requirement() {
    let folder = folder();
    let results = measured("extra-latency-small", "[\"fit\", \"onset\"]", folder.path());
    near(&results, "transport-round-trip", 3.75e-3, 20e-6);
    near(&results, "transport-by-onset", 3.75e-3, 75e-6);
    assert_eq!(verdict(&folder.path().join("run"), "LAT-RT"), "fail");
}
