//! Envelope, soft limits and restricted zones of simulated units, from the procedure file to the verdict.

use std::path::Path;

use crate::bench::{Said, folder, run_in, verdict, write};

fn measured(folder: &Path, file: &str, unit: &str) -> Said {
    run_in(folder, &["run", file, "--unit", unit, "--out", "run", "--non-interactive"])
}

#[test]
fn the_nominal_unit_covers_its_envelope_and_keeps_every_limit() {
    for (file, range) in [("quick/az-range.toml", "MOT-RNG-AZ"), ("fat/el-range.toml", "MOT-RNG-EL")] {
        let folder = folder();
        let said = measured(folder.path(), file, "nominal");
        for id in [range, "MOT-SOFT", "MOT-MASK"] {
            assert_eq!(verdict(&folder.path().join("run"), id), "pass", "{id}\n{}\n{}", said.out, said.err);
        }
        // One axis alone does not verify what is claimed of both.
        assert_eq!(said.code, 3, "{}\n{}", said.out, said.err);
    }
}

/// With this seed the encoder counted one tick of the last stretch as 1.03e-3 rad/s when that was driven at 0.87e-3 rad/s:
/// more than interlocks take for rest, too near to the end.
#[test]
fn noise_of_the_encoder_trips_nothing_at_the_ends_of_the_travel() {
    let folder = folder();
    let arguments = [
        "run",
        "quick/az-range.toml",
        "--seed",
        "100910",
        "--select",
        "MOT-RNG-AZ",
        "--out",
        "run",
        "--non-interactive",
    ];
    let said = run_in(folder.path(), &arguments);
    assert_eq!(verdict(&folder.path().join("run"), "MOT-RNG-AZ"), "pass", "{}\n{}", said.out, said.err);
}

/// The bench's own limits hold all the same: only the drive's are travelled past, by as much as was planned.
#[test]
fn a_drive_that_ignores_its_soft_limits_fails_them_and_nothing_else() {
    let folder = folder();
    let said = measured(folder.path(), "quick/az-range.toml", "soft-limit-missing");
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    let run = folder.path().join("run");
    assert_eq!(verdict(&run, "MOT-SOFT"), "fail", "{}", said.out);
    assert_eq!(verdict(&run, "MOT-RNG-AZ"), "pass", "{}", said.out);
    assert_eq!(verdict(&run, "MOT-MASK"), "pass", "{}", said.out);
}

fn with_zero(folder: &Path, axis: &str, zero: &str, file: &str) -> Said {
    let unit = format!(
        "schema = 1\nid = \"zero\"\ntitle = \"Encoder zero\"\nbase = \"nominal\"\n[{axis}]\nencoder-zero = \"{zero}\"\n"
    );
    write(folder, "zero.toml", &unit);
    measured(folder, file, "./zero.toml")
}

/// Two degrees off, an axis met its stop at 5 deg/s on its way to the start, with every limit in order by its encoder.
#[test]
fn an_encoder_zero_that_is_not_where_people_read_it_closes_the_gate_of_every_loop() {
    for (axis, zero, file) in [
        ("el", "2 deg", "fat/el-range.toml"),
        ("el", "-0.3 deg", "fat/el-range.toml"),
        ("az", "-2 deg", "quick/az-range.toml"),
    ] {
        let folder = folder();
        let said = with_zero(folder.path(), axis, zero, file);
        let text = format!("{}\n{}", said.out, said.err);
        assert_eq!(said.code, 3, "{zero}: {text}");
        assert!(text.contains(&format!("encoder zero of {axis}")), "{zero}: {text}");
        assert!(!text.contains("hit its end stop"), "{zero}: {text}");
    }
}

#[test]
fn a_zero_within_its_tolerance_meets_no_stop_at_the_ends_of_the_travel() {
    for zero in ["0.24 deg", "-0.24 deg"] {
        let folder = folder();
        let said = with_zero(folder.path(), "el", zero, "fat/el-range.toml");
        let text = format!("{}\n{}", said.out, said.err);
        assert_eq!(verdict(&folder.path().join("run"), "MOT-SOFT"), "pass", "{zero}: {text}");
        assert!(!text.contains("hit its end stop"), "{zero}: {text}");
    }
}
