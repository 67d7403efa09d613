//! The steering mirror through `quick`'s own procedures: the nominal unit passes, each defect of the mirror fails what its
//! file says and nothing that it does not say.

use std::path::{Path, PathBuf};

use bench::files::unit::load_unit;
use serde_json::Value;
use validation::linear;
use validation::prediction::mirror_open_loop;

use crate::bench::{folder, run_in, verdict, write};

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
fn nominal_mirror_passes_everything_that_is_asked_of_it() {
    let folder = folder();
    assert_eq!(verdicts(&run(folder.path(), "nominal")), MIRROR.map(|id| (id, "pass".to_owned())));
}

/// Value and standard uncertainty of a measurand for both axes, all points, in a run of the response on a unit.
fn margins_of(unit: &str) -> [Vec<[f64; 2]>; 4] {
    let folder = folder();
    write(folder.path(), "unit.toml", unit);
    let arguments =
        ["run", "quick/fsm-response", "--unit", "./unit.toml", "--out", "run", "--non-interactive"];
    let said = run_in(folder.path(), &arguments);
    let text = std::fs::read_to_string(folder.path().join("run/results.json"));
    let text = text.unwrap_or_else(|e| panic!("{e}: {}\n{}", said.out, said.err));
    let results: Value = serde_json::from_str(&text).expect("results are JSON");
    let of = |measurand: &str, axis: &str| {
        let mine = found(&results, measurand).into_iter().filter(|(name, ..)| name == axis);
        mine.map(|(_, value, u)| [value, u]).collect::<Vec<_>>()
    };
    [
        of("mirror-crossover", "az"),
        of("mirror-phase-margin", "az"),
        of("mirror-crossover", "el"),
        of("mirror-phase-margin", "el"),
    ]
}

const UNIT: &str = "schema = 1\nid = \"unit\"\ntitle = \"t\"\nbase = \"nominal\"\n";

/// The linear model has no hysteresis; with it, the actuator turns the loop by some degrees more.
#[test]
fn margins_of_the_mirrors_servo_are_those_of_its_model_and_hysteresis_costs_some() {
    let unit = load_unit("nominal").expect("a shipped unit");
    let mut settings = unit.director().expect("a director").clone();
    settings.mirror.hysteresis_ratio = 0.0;
    let straight = margins_of(&format!("{UNIT}\n[mirror]\nhysteresis = \"0 %\"\n"));
    let bent = margins_of(UNIT);
    for axis in 0..2 {
        let model = linear::margins(mirror_open_loop(&settings, axis, LEVEL_RAD), 5.0, 2000.0);
        let model = model.expect("the servo crosses 0 dB");
        let [hz, margin_rad] = [&straight[2 * axis], &straight[2 * axis + 1]];
        assert_eq!((hz.len(), margin_rad.len()), (2, 2), "by both channels: {straight:?}");
        for ([hz, u_hz], [margin_rad, u_rad]) in hz.iter().zip(margin_rad) {
            let expected_hz = model.bandwidth_hz;
            assert!((hz / expected_hz - 1.0).abs() < 0.025, "{axis}: {hz} ± {u_hz}, model {expected_hz}");
            let degrees = margin_rad.to_degrees();
            let expected = model.phase_margin_deg;
            assert!((degrees - expected).abs() < 0.8, "{axis}: {degrees} ± {u_rad} rad, model {expected}");
        }
        let cost = margin_rad[0][0] - bent[2 * axis + 1][0][0];
        assert!((1.0..3.0).contains(&cost.to_degrees()), "{axis}: {}", cost.to_degrees());
    }
}

/// One of the mirror's defects; `defects` runs all of them.
#[test]
fn a_short_stroke_fails_what_its_file_says_and_nothing_else() {
    let unit = load_unit("mirror-stroke-short").expect("a shipped defect");
    let folder = folder();
    let found = verdicts(&run(folder.path(), "mirror-stroke-short"));
    for (id, verdict) in &found {
        let must = unit.must_flip.iter().any(|claim| claim == id);
        let may = unit.may_flip.iter().any(|claim| claim == id);
        assert!(!must || verdict == "fail", "{id} must fail: {found:?}");
        assert!(must || may || verdict == "pass", "{id} turns unannounced: {found:?}");
    }
}

#[test]
fn a_mirror_behind_a_gcs_controller_has_its_stroke_and_its_slow_serial_line_is_told() {
    let folder = folder();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("rigs/sim.toml");
    let text = std::fs::read_to_string(path).expect("a shipped rig");
    assert!(text.contains("driver = \"ccbu40\""));
    write(folder.path(), "rig.toml", &text.replace("driver = \"ccbu40\"", "driver = \"gcs\""));
    let arguments = ["run", "quick/fsm-response", "--rig", "./rig.toml", "--out", "run", "--non-interactive"];
    let said = run_in(folder.path(), &arguments);
    let run = folder.path().join("run");
    assert!(run.join("results.json").is_file(), "{}\n{}", said.out, said.err);
    assert_eq!(verdict(&run, "FSM-STR"), "pass");
    // At 115200 bit/s a position and its acknowledgement take longer than the period of the fastest lines.
    assert_eq!(verdict(&run, "FSM-CH"), "inconclusive");
}
