//! The steering mirror through `quick`'s own procedures: the nominal unit passes, each defect of the mirror fails what its
//! file says and nothing that it does not say.

use std::path::{Path, PathBuf};

use bench::files::unit::Unit;
use serde_json::Value;
use sim_devices::linear;
use sim_devices::prediction::mirror_open_loop;

use crate::bench::{folder, run_in, verdict};

/// Amplitude of the excitation: 1 V peak to peak.
const LEVEL_RAD: f64 = 250e-6;
const MIRROR: [&str; 4] = ["FSM-BW", "FSM-STR", "FSM-MODE", "FSM-CH"];

/// A run of both procedures.
fn run(folder: &Path, unit: &str) -> PathBuf {
    let procedures = ["quick/fsm-impedance", "quick/fsm-response"];
    let arguments =
        ["run", procedures[0], procedures[1], "--unit", unit, "--out", "run", "--non-interactive"];
    let said = run_in(folder, &arguments);
    let run = folder.join("run");
    assert!(run.join("results.json").is_file(), "{}\n{}", said.out, said.err);
    run
}

/// Verdicts of the mirror's requirements in a run.
fn verdicts(run: &Path) -> Vec<(&'static str, String)> {
    MIRROR.into_iter().map(|id| (id, verdict(run, id))).collect()
}

/// Axis, value and standard uncertainty of a measurand, all points.
fn found(results: &Value, measurand: &str) -> Vec<(String, f64, f64)> {
    match results {
        Value::Object(map) if map.get("measurand").is_some_and(|m| m == measurand) => {
            let number = |key: &str| map.get(key).and_then(Value::as_f64);
            let axis = map["axis"].as_str().unwrap_or_default().to_owned();
            number("value").zip(number("u")).map(|(value, u)| (axis, value, u)).into_iter().collect()
        }
        Value::Object(map) => map.values().flat_map(|v| found(v, measurand)).collect(),
        Value::Array(all) => all.iter().flat_map(|v| found(v, measurand)).collect(),
        _ => Vec::new(),
    }
}

#[test]
fn nominal_mirror_passes_everything_that_is_asked_of_it_with_the_margins_of_its_model() {
    let folder = folder();
    let run = run(folder.path(), "nominal");
    assert_eq!(verdicts(&run), MIRROR.map(|id| (id, "pass".to_owned())));
    let text = std::fs::read_to_string(run.join("results.json")).expect("results of the run");
    let results: Value = serde_json::from_str(&text).expect("results are JSON");
    let unit = Unit::load("nominal").expect("a shipped unit");
    for (axis, name) in ["az", "el"].into_iter().enumerate() {
        let model = linear::margins(mirror_open_loop(&unit.settings, axis, LEVEL_RAD), 5.0, 2000.0);
        let model = model.expect("the servo crosses 0 dB");
        let all = |measurand: &str| -> Vec<(f64, f64)> {
            let mine = found(&results, measurand).into_iter().filter(|(axis, ..)| axis == name);
            mine.map(|(_, value, u)| (value, u)).collect()
        };
        let (crossovers, margins) = (all("mirror-crossover"), all("mirror-phase-margin"));
        assert_eq!((crossovers.len(), margins.len()), (2, 2), "{name} by both channels");
        for ((hz, u_hz), (margin_rad, u_rad)) in crossovers.into_iter().zip(margins) {
            let expected_hz = model.bandwidth_hz;
            assert!((hz / expected_hz - 1.0).abs() < 0.02, "{name}: {hz} ± {u_hz}, model {expected_hz}");
            let (degrees, expected) = (margin_rad.to_degrees(), model.phase_margin_deg);
            assert!((degrees - expected).abs() < 1.5, "{name}: {degrees} ± {u_rad} rad, model {expected}");
        }
        // 28 dB down and near half of the row rate; behind the jitter of the serial line it may not be seen at all.
        let [(gain_db, u_db), ..] = all("mirror-gain-margin")[..] else { panic!("{name}: no gain margin") };
        let expected_db = model.gain_margin_db;
        assert!(
            (gain_db - expected_db).abs() < 3.0 * u_db,
            "{name}: {gain_db} ± {u_db}, model {expected_db}"
        );
    }
}

#[test]
fn each_defect_of_the_mirror_fails_what_its_file_says_and_nothing_else() {
    for name in ["mirror-serial-slow", "mirror-stroke-short", "mirror-hysteresis", "mirror-notch-off"] {
        let unit = Unit::load(name).expect("a shipped defect");
        let folder = folder();
        let found = verdicts(&run(folder.path(), name));
        for (id, verdict) in &found {
            let must = unit.must_flip.iter().any(|claim| claim == id);
            let may = unit.may_flip.iter().any(|claim| claim == id);
            assert!(!must || verdict == "fail", "{name}: {id} must fail: {found:?}");
            assert!(must || may || verdict == "pass", "{name}: {id} turns unannounced: {found:?}");
        }
    }
}
