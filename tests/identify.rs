//! `bench identify`: units from what runs found.

use std::path::Path;

use validation::blind::{Asked, Units};
use validation::twins::{Setting, twin};

use crate::bench::{folder, run_in, write};
use crate::comparison::runs;

/// The value of a key in a table of a unit file, as it is written.
fn written(file: &Path, table: &str, key: &str) -> String {
    let text = std::fs::read_to_string(file).expect("a unit file");
    let parsed: toml::Table = text.parse().expect("TOML");
    parsed[table][key].as_str().expect("a quantity").to_owned()
}

#[test]
fn a_run_of_the_unit_as_measured_gives_its_spring_and_its_delays_to_a_twin_of_nominal() {
    let folder = folder();
    let out = folder.path().join("twin.toml");
    let path = out.to_str().expect("a plain path");
    let said = run_in(runs(), &["identify", "as-measured", "--out", path]);
    assert_eq!(said.code, 0, "{}", said.err);
    let stiffness = written(&out, "el", "spring-stiffness");
    let number: f64 = stiffness.split(' ').next().and_then(|number| number.parse().ok()).expect("a number");
    assert!((number - 54.0).abs() < 1.0, "{stiffness}");
    let us = |key: &str| -> f64 {
        written(&out, "az", key).split(' ').next().and_then(|number| number.parse().ok()).expect("a number")
    };
    // 1.1 ms and 1.5 ms; only their sum was measured. One is written in us, the other in ms.
    assert!((us("command-delay") + 1e3 * us("sensor-delay") - 2600.0).abs() < 0.1, "{}", said.out);
    assert!(said.out.contains("az.command-delay") && said.out.contains("in part"), "{}", said.out);
    let text = std::fs::read_to_string(&out).expect("a unit file");
    let again = run_in(runs(), &["identify", "as-measured", "--out", &path.replace("twin", "again")]);
    assert_eq!(again.code, 0, "{}", again.err);
    let again = std::fs::read_to_string(folder.path().join("again.toml")).expect("a unit file");
    assert_eq!(again.replace("\"again\"", "\"twin\""), text, "the same run gives the same file");
    let plan = run_in(
        folder.path(),
        &[
            "run",
            "quick",
            "--select",
            "EL-FRICTION",
            "--unit",
            "./twin.toml",
            "--out",
            "r",
            "--non-interactive",
        ],
    );
    assert!(matches!(plan.code, 0 | 1 | 3), "{}", plan.err);
}

#[test]
fn the_hysteresis_of_the_mirror_is_found_by_rehearsals_of_its_response() {
    let folder = folder();
    let at = folder.path();
    let unit =
        "schema = 1\nid = \"less\"\ntitle = \"Less\"\nbase = \"nominal\"\n[mirror]\nhysteresis = \"12 %\"\n";
    write(at, "less.toml", unit);
    let run = ["run", "quick", "--select", "FSM-RESPONSE", "--unit", "./less.toml", "--out", "r"];
    let said = run_in(at, &[&run[..], &["--non-interactive"]].concat());
    assert!(at.join("r/results.json").exists(), "{}", said.err);
    let said = run_in(at, &["identify", "r", "--out", "twin.toml"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let found = written(&at.join("twin.toml"), "mirror", "hysteresis");
    let percent: f64 = found.trim_end_matches(" %").parse().expect("a number");
    assert!((percent - 12.0).abs() < 0.1, "{found}\n{}", said.out);
    assert!(said.out.contains("gain and phase of FSM-RESPONSE (FSM-RESPONSE.mcap)"), "{}", said.out);
}

#[test]
fn what_no_unit_can_be_made_of_is_refused_in_words() {
    let folder = folder();
    let new = folder.path().join("new.toml");
    let new = new.to_str().expect("a plain path");
    let refused = |arguments: &[&str], words: &str| {
        let said = run_in(runs(), &[&["identify"], arguments].concat());
        assert_eq!(said.code, 2, "{arguments:?}: {}{}", said.out, said.err);
        assert!(said.err.contains(words), "{arguments:?}: {}", said.err);
    };
    refused(&["nominal", "--out", "nominal/run.json"], "exists; choose a new file");
    refused(&["nominal", "--out", "unit"], "ends in `.toml`");
    refused(&["nowhere", "--out", new], "is this a run folder?");
    refused(&["nominal", "--base", "nominl", "--out", new], "nominal");
    refused(&["nominal", "--base", "table", "--out", new], "not a director");
    assert!(!Path::new(new).exists());
}

#[test]
fn a_run_of_a_rotary_table_is_refused() {
    let folder = folder();
    let run = [
        "run",
        "table",
        "--rig",
        "table",
        "--unit",
        "table",
        "--select",
        "TABLE-FRICTION",
        "--out",
        "r",
        "--non-interactive",
    ];
    let said = run_in(folder.path(), &run);
    assert!(folder.path().join("r/results.json").exists(), "{}", said.err);
    let said = run_in(folder.path(), &["identify", "r", "--out", "twin.toml"]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("units are identified from runs of a director"), "{}", said.err);
}

#[test]
#[ignore = "takes the better part of a minute; `.ci/run` runs it after the others"]
fn the_settings_of_a_drawn_unit_are_found_again_within_their_uncertainty() {
    let asked = Asked {
        program: env!("CARGO_BIN_EXE_bench").into(),
        campaign: "quick".to_owned(),
        select: [
            "AZ-TORQUE-CONSTANT",
            "AZ-FRICTION",
            "AZ-BREAKAWAY",
            "EL-FRICTION",
            "AZ-LATENCY",
            "AZ-MODES",
            "FSM-IMPEDANCE",
        ]
        .map(str::to_owned)
        .into(),
        units: Units::Drawn,
    };
    let folder = folder();
    let found = twin(&asked, 951, folder.path(), false);
    let measured: Vec<&Setting> = found.settings.iter().filter(|setting| setting.is_measured).collect();
    assert!(measured.len() >= 25, "{} settings are determined: {measured:#?}", measured.len());
    let outside: Vec<&&Setting> = measured.iter().filter(|setting| !setting.is_covered()).collect();
    assert!(outside.len() as f64 <= 0.07 * measured.len() as f64, "{outside:#?}");
}
