//! The coarse track loop of simulated units, from the procedure file to the verdict.

use std::path::Path;

use crate::bench::{folder, procedure, run_in, verdict, write};

/// Both quick track loops of a unit; what the program said.
fn tracked(unit: &str, folder: &Path) -> serde_json::Value {
    write(folder, "requirements.toml", include_str!("../procedures/requirements.toml"));
    write(folder, "az.toml", include_str!("../procedures/quick/az-track-loop.toml"));
    write(folder, "el.toml", include_str!("../procedures/quick/el-track-loop.toml"));
    let campaign = "schema = 1\nid = \"mine\"\ntitle = \"Track\"\nrequirements = \"requirements.toml\"\nclaim = \"screening\"\nmust-measure = [\"TRK-BW\"]\n\n[[procedure]]\nfile = \"az.toml\"\n\n[[procedure]]\nfile = \"el.toml\"\n";
    write(folder, "mine.toml", campaign);
    let said = run_in(folder, &["run", "mine.toml", "--unit", unit, "--out", "run", "--non-interactive"]);
    assert!(said.code <= 1, "exit {}\n{}\n{}", said.code, said.out, said.err);
    let text = std::fs::read_to_string(folder.join("run/results.json")).expect("results of the run");
    serde_json::from_str(&text).expect("results are JSON")
}

/// Values of a measurand, wherever the results hold it, by axis.
fn values(results: &serde_json::Value, measurand: &str, axis: &str, into: &mut Vec<f64>) {
    match results {
        serde_json::Value::Object(map) => {
            let is = |key: &str, wanted: &str| map.get(key).is_some_and(|v| v == wanted);
            if is("measurand", measurand) && is("axis", axis) {
                into.extend(map.get("value").and_then(serde_json::Value::as_f64));
            }
            map.values().for_each(|v| values(v, measurand, axis, into));
        }
        serde_json::Value::Array(all) => all.iter().for_each(|v| values(v, measurand, axis, into)),
        _ => {}
    }
}

fn near(results: &serde_json::Value, measurand: &str, axis: &str, expected: std::ops::RangeInclusive<f64>) {
    let mut found = Vec::new();
    values(results, measurand, axis, &mut found);
    assert!(!found.is_empty(), "{axis}: no {measurand}");
    assert!(
        found.iter().all(|v| expected.contains(v)),
        "{axis} {measurand}: {found:?}, expected {expected:?}"
    );
}

/// modes.md, 6: elevation 1.010–1.020 Hz, 72.7°; azimuth 1.020–1.055 Hz, 56.5°.
#[test]
fn the_unit_as_measured_shows_the_track_loops_of_the_study() {
    let folder = folder();
    let results = tracked("as-measured", folder.path());
    near(&results, "track-bandwidth", "el", 1.00..=1.03);
    near(&results, "track-bandwidth", "az", 1.01..=1.07);
    near(&results, "track-phase-margin", "el", 1.25..=1.29);
    near(&results, "track-phase-margin", "az", 0.96..=1.02);
    let verdict = verdict(&folder.path().join("run"), "TRK-BW");
    assert!(["pass", "conditional-pass"].contains(&verdict.as_str()), "{verdict}");
}

#[test]
fn the_nominal_unit_passes_with_six_percent_more_gain() {
    let folder = folder();
    let results = tracked("nominal", folder.path());
    near(&results, "track-bandwidth", "el", 1.06..=1.14);
    near(&results, "track-bandwidth", "az", 1.06..=1.16);
    assert_eq!(verdict(&folder.path().join("run"), "TRK-BW"), "pass");
}

#[test]
fn a_coarse_camera_at_half_of_its_rate_passes_nothing_and_its_sign_is_proven_all_the_same() {
    let folder = folder();
    let unit = "schema = 1\nid = \"slow\"\ntitle = \"Slow camera\"\nbase = \"nominal\"\nmust-flip = []\n\
                reason = \"Drawn.\"\n[trackers]\ncoarse-frame-rate = \"25 Hz\"\n";
    write(folder.path(), "unit.toml", unit);
    let words =
        ["run", "quick/az-coarse-latency", "--unit", "unit.toml", "--out", "run", "--non-interactive"];
    let said = run_in(folder.path(), &words);
    let latency = procedure(&folder.path().join("run"), "AZ-COARSE-LATENCY");
    assert_eq!(latency["status"], "completed", "{}{}", said.out, said.err);
    let measurements = latency["measurements"].as_array().expect("measurements");
    assert!(measurements.len() >= 4, "{measurements:?}");
    for m in measurements {
        let why = m["inconclusive"].as_str().unwrap_or_default();
        assert!(why.contains("25.0 frames/s, expected 50.0"), "{m}");
        assert!(m["value"].is_number(), "what was seen stays: {m}");
    }
}

#[test]
fn a_camera_that_reads_a_tenth_too_little_fails_the_requirement() {
    let folder = folder();
    tracked("track-gain-low", folder.path());
    assert_eq!(verdict(&folder.path().join("run"), "TRK-BW"), "fail");
}
