//! Campaign `wired` in process: what `tests/wired/run` then repeats over real wires.

use std::path::Path;

use rayon::prelude::*;
use validation::blind::draw;

use crate::bench::{folder, run_in, write};

/// Runs the campaign on a unit in virtual time and gives exit code, last lines and the table of requirements.
fn run(folder: &Path, unit: &str, more: &[&str]) -> (i32, String) {
    let common = ["run", "wired", "--rig", "wired", "--tier", "virtual", "--yes", "--non-interactive"];
    let said =
        run_in(folder, &[&common, ["--jobs", "1", "--out", "run", "--unit", unit].as_slice(), more].concat());
    (said.code, said.out)
}

/// A folder with a drawn unit of this number.
fn drawn(number: u32) -> tempfile::TempDir {
    let folder = folder();
    write(folder.path(), "drawn.toml", &draw::unit("drawn", number));
    folder
}

#[test]
fn a_drawn_unit_passes_every_requirement_of_the_wired_campaign() {
    let folder = drawn(801);
    let (code, told) = run(folder.path(), "./drawn.toml", &[]);
    assert_eq!(code, 0, "{told}");
    assert!(told.contains("requirements: 13 pass"), "{told}");
}

#[test]
#[ignore = "takes a minute; `.ci/run` runs it after the others"]
fn the_limits_of_the_wired_campaign_are_tuned_on_no_unit_and_no_seed() {
    let shortfalls = |unit: &str, folder: &Path, seed: u32| {
        let (code, told) = run(folder, unit, &["--seed", &seed.to_string()]);
        (code != 0).then(|| format!("{unit} with seed {seed}: {code}: {told}"))
    };
    let nominal = (1..5_u32).into_par_iter().filter_map(|seed| shortfalls("nominal", folder().path(), seed));
    let others = (802..808)
        .into_par_iter()
        .filter_map(|number| shortfalls("./drawn.toml", drawn(number).path(), number));
    let found: Vec<String> = nominal.chain(others).collect();
    assert!(found.is_empty(), "{found:#?}");
}

/// A nominal unit whose mirror differs by this.
fn mirror(differs_by: &str) -> String {
    format!("schema = 1\nid = \"own\"\ntitle = \"Own\"\nbase = \"nominal\"\n\n[mirror]\n{differs_by}\n")
}

#[test]
#[ignore = "takes half a minute; `.ci/run` runs it after the others"]
fn a_defect_of_every_device_on_a_line_fails_the_requirement_of_its_line() {
    let slow_servo = mirror("integral-gain = \"170 1/s\"\ndouble-integral-gain = \"15000 1/s^2\"");
    let soft_mirror = mirror("az-frequency = \"306 Hz\"");
    let planted = [
        ("gyro-scale", None, "WIRE-GYR"),
        ("./own.toml", Some(slow_servo), "WIRE-FSM"),
        ("fine-latency", None, "WIRE-FINE"),
        ("tracker-latency", None, "WIRE-COARSE"),
        ("./own.toml", Some(soft_mirror), "WIRE-IMP"),
        ("extra-latency", None, "WIRE-OUT"),
    ];
    planted.into_par_iter().for_each(|(unit, own, requirement)| {
        let folder = folder();
        if let Some(own) = own {
            write(folder.path(), "own.toml", &own);
        }
        let (code, told) = run(folder.path(), unit, &["--select", requirement]);
        assert_eq!(code, 1, "{requirement} on {unit}: {told}");
        assert!(told.contains(&format!("fail  {requirement}: ")), "{requirement} on {unit}: {told}");
        // The same selection on a unit without the defect, so that the defect is what fails it.
        let (code, told) = run(crate::bench::folder().path(), "nominal", &["--select", requirement]);
        assert_eq!(code, 0, "{requirement} on nominal: {told}");
    });
}
