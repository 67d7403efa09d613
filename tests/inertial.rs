//! The inertial unit of simulated directors, from the procedure file to the verdict.

use std::path::Path;

use crate::bench::{Said, folder, outcomes, run_in, verdict, write};

fn run(folder: &Path, unit: &str, name: &str) -> Said {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../procedures/quick").join(name);
    let file = file.to_str().expect("a path of ours").to_owned();
    run_in(folder, &["run", &file, "--unit", unit, "--out", "run", "--non-interactive"])
}

/// Values of a measurand in the results of a run, in their order.
fn values(run: &Path, measurand: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(run.join("results.json")).expect("a run folder with results");
    let results: serde_json::Value = serde_json::from_str(&text).expect("results are JSON");
    let mut found = Vec::new();
    collect(&results["findings"], measurand, &mut found);
    found
}

fn collect(results: &serde_json::Value, measurand: &str, found: &mut Vec<f64>) {
    match results {
        serde_json::Value::Object(map) if map.get("measurand").is_some_and(|m| m == measurand) => {
            found.extend(map.get("value").and_then(serde_json::Value::as_f64));
        }
        serde_json::Value::Object(map) => map.values().for_each(|v| collect(v, measurand, found)),
        serde_json::Value::Array(all) => all.iter().for_each(|v| collect(v, measurand, found)),
        _ => {}
    }
}

#[test]
fn nominal_gyros_have_their_walk_and_both_encoders_26_bit() {
    let folder = folder();
    let said = run(folder.path(), "nominal", "imu-noise.toml");
    let run = folder.path().join("run");
    assert_eq!(verdict(&run, "GYR-ARW"), "pass", "{}\n{}", said.out, said.err);
    // What the encoders err within their pitches is not known yet.
    assert_eq!(verdict(&run, "ENC-RES"), "pass", "{}\n{}", said.out, said.err);
    assert!(values(&run, "encoder-resolution").iter().all(|rad| *rad < 3e-6));
    let nominal = 0.01_f64.to_radians() / 60.0;
    let walks = values(&run, "angle-random-walk");
    assert!(walks.len() >= 3 && walks.iter().all(|n| (n / nominal - 1.0).abs() < 0.04), "{walks:?}");
    assert!(
        values(&run, "encoder-bits").iter().all(|bits| (bits - 26.0).abs() < 1e-6),
        "{said:?}",
        said = said.out
    );
}

#[test]
fn gyros_three_times_as_noisy_fail_their_requirement_and_no_other() {
    let folder = folder();
    let said = run(folder.path(), "gyro-noise", "imu-noise.toml");
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    let run = folder.path().join("run");
    assert_eq!(verdict(&run, "GYR-ARW"), "fail");
    assert_eq!(verdict(&run, "ENC-RES"), "pass");
}

#[test]
fn gyros_and_encoders_of_the_nominal_unit_agree() {
    let folder = folder();
    let said = run(folder.path(), "nominal", "imu-consistency.toml");
    let run = folder.path().join("run");
    // Scale errors up to 50 ppm; misalignment and lean of 150 urad.
    let scales = values(&run, "gyro-scale-error");
    assert!(
        scales.len() >= 2 && scales.iter().all(|s| s.abs() < 150e-6),
        "{scales:?}\n{}\n{}",
        said.out,
        said.err
    );
    let angles = values(&run, "gyro-mapping-error");
    assert!(angles.len() >= 2 && angles.iter().all(|a| *a < 400e-6), "{angles:?}");
    let delays = values(&run, "gyro-encoder-delay");
    // 0.875 ms of the gyros and the exchange of 0.25 ms after it, less 1.25 ms of encoder and drive: half a tick counts.
    assert!(delays.len() >= 2 && delays.iter().all(|s| (s + 125e-6).abs() < 50e-6), "{delays:?}");
    // 0.05 urad within the pitches of both scales.
    let pitches = values(&run, "encoder-pitch-error");
    assert!(pitches.len() >= 2 && pitches.iter().all(|rad| (rad - 0.05e-6).abs() < 0.06e-6), "{pitches:?}");
    // The unit leans by (100 + 80)/√2 urad about the elevation axis; its accelerometers err by 0.5, -0.4 and 0.3 mg.
    let zeros = values(&run, "elevation-zero-error");
    assert!(!zeros.is_empty() && zeros.iter().all(|rad| (rad - 127e-6).abs() < 450e-6), "{zeros:?}");
    let biases = values(&run, "accelerometer-bias");
    assert!(biases.len() >= 2 && biases.iter().all(|b| b.abs() < 0.012), "{biases:?}");
    for id in ["ENC-PITCH", "ENC-ZERO", "ACC-GRAV", "GYR-SCALE", "GYR-MAP"] {
        assert_eq!(verdict(&run, id), "pass", "{id}\n{}", said.out);
    }
}

/// Azimuth turns along (0, cos el, sin el) of the unit: the gyro along the line of sight has 41 % of it at 40 deg and 97 % at 80 deg.
#[test]
fn one_gyro_that_errs_by_900_ppm_hides_at_one_elevation_which_therefore_passes_nothing() {
    let folder = folder();
    write(
        folder.path(),
        "unit.toml",
        "schema = 1\nid = \"one-gyro\"\ntitle = \"One gyro off\"\nbase = \"nominal\"\nmust-flip = [\"GYR-SCALE\"]\n\
         reason = \"Drawn.\"\n[imu]\ngyro-scale-error-z = \"900 ppm\"\n",
    );
    let looked = |campaign: &str| {
        let out = format!("run-{campaign}");
        let words = [
            "run",
            campaign,
            "--select",
            "GYR-SCALE",
            "--unit",
            "unit.toml",
            "--out",
            &out,
            "--non-interactive",
        ];
        let said = run_in(folder.path(), &words);
        let scale = outcomes(&folder.path().join(&out))
            .into_iter()
            .find(|o| o["requirement"] == "GYR-SCALE")
            .expect("it is judged");
        (said.code, scale)
    };
    // A selection is no screening: what it did not cover is inconclusive, however good the rest is.
    let (code, scale) = looked("quick");
    assert_eq!(
        (code, &scale["before_coverage"], &scale["verdict"]),
        (3, &"pass".into(), &"inconclusive".into())
    );
    let why = scale["reason"].as_str().expect("a reason");
    assert!(why.contains("gyro-scale-error on az: elevation 0 deg .. 80 deg, reached 40 deg only"), "{why}");
    let (code, scale) = looked("fat");
    assert_eq!((code, &scale["verdict"]), (1, &"fail".into()));
}

#[test]
fn gyros_of_the_wrong_sign_never_come_so_far() {
    let folder = folder();
    let said = run(folder.path(), "gyro-sign", "imu-consistency.toml");
    assert_eq!(said.code, 3, "{}\n{}", said.out, said.err);
    assert!(values(&folder.path().join("run"), "gyro-scale-error").is_empty(), "{}", said.out);
}

/// The shipped rig with a STIM300 in the place of its inertial unit.
fn rig_with_stim300() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("rigs/sim.toml");
    let text = std::fs::read_to_string(path).expect("a shipped rig");
    let name = text.find("name = \"imu\"").expect("an inertial unit");
    let begin = text[..name].rfind("[[device]]").expect("its table");
    let end = name + text[name..].find("[[device]]").expect("another device");
    let own = "[[device]]\nname = \"imu\"\ndriver = \"stim300\"\nports = { line = \"sim:imu\" }\n\n";
    format!("{}{own}{}", &text[..begin], &text[end..])
}

#[test]
fn a_stim300_takes_the_place_of_the_kvh_and_shows_its_own_noise() {
    let folder = folder();
    write(folder.path(), "rig.toml", &rig_with_stim300());
    let run_on_it = |name: &str, out: &str| {
        let procedure = format!("quick/{name}");
        let said = run_in(
            folder.path(),
            &["run", &procedure, "--rig", "./rig.toml", "--out", out, "--non-interactive"],
        );
        assert!(folder.path().join(out).join("results.json").is_file(), "{}\n{}", said.out, said.err);
        folder.path().join(out)
    };
    let run = run_on_it("imu-consistency", "consistency");
    for id in ["GYR-SCALE", "GYR-MAP", "ACC-GRAV"] {
        assert_eq!(verdict(&run, id), "pass", "{id}");
    }
    // 0.15 deg/sqrt(h) where the KVH has 0.01.
    let run = run_on_it("imu-noise", "noise");
    let expected = 0.15_f64.to_radians() / 60.0;
    let walks = values(&run, "angle-random-walk");
    assert!(walks.len() >= 3 && walks.iter().all(|n| (n / expected - 1.0).abs() < 0.2), "{walks:?}");
    assert_eq!(verdict(&run, "GYR-ARW"), "fail");
}

/// A loop at 1 kHz gets two measurements a tick: with one of them alone standstill would not be found for minutes.
#[test]
fn the_signs_are_proven_in_the_planned_time_with_a_stim300_on_a_slow_loop() {
    let folder = folder();
    let text = rig_with_stim300().replace("loop-rate = \"4 kHz\"", "loop-rate = \"1 kHz\"");
    let text = text.replace("max-missed-periods = 20", "max-missed-periods = 5");
    assert!(
        text.contains("1 kHz") && text.contains("max-missed-periods = 5"),
        "the shipped rig has other keys"
    );
    write(folder.path(), "rig.toml", &text);
    let arguments = ["run", "wired/polarity", "--rig", "./rig.toml", "--out", "run", "--non-interactive"];
    let said = run_in(folder.path(), &arguments);
    let record = std::fs::read_to_string(folder.path().join("run/results.json")).expect("a run with results");
    let results: serde_json::Value = serde_json::from_str(&record).expect("results are JSON");
    let procedures = results["findings"]["procedures"].as_array().expect("procedures");
    let completed = procedures.iter().all(|own| own["status"] == "completed");
    assert!(completed, "{}\n{}", said.out, said.err);
}
